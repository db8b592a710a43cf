#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/hdf5_store.h"
#include "mesh/nodule_surface.h"
#include "mesh/spring_mesh.h"
#include "springs/contact_patch.h"
#include "springs/disc_sizes.h"
#include "springs/disc_tables.h"
#include "springs/relaxation.h"
#include "springs/spring_curve.h"

namespace tissue {

/// Spring sets that one optimiser trained: one row of theta per load case.
struct SpringSets {
    std::string optimizer;
    NodeField theta;                       ///< [N/m] (C x S)
};

/// An energy model (springs/energy_model_terms.h): stiffnesses that do not depend on the tool.
struct EnergyModel {
    std::vector<std::string> terms;        ///< (P)
    Eigen::VectorXd coefficients;          ///< of the terms (P)
    /// of a TissueEnergy (E) [N/m], in space cells in [Pa]: heuristic with the terms applied
    Eigen::VectorXd constants;
    ContactParameters patch;                        ///< the same of the contact
    SkinParameters skin() const { return skin_of(terms, coefficients); }
    /// plane strain: regions conserve their area too (TissueEnergy)
    bool incompressible = false;
    double disc_radius_m = 0;              ///< in space: radius of its disc [m]
    DiscTables disc = {};                  ///< tables for the disc's place
    /// log factor on contacts by node (N), ContactKernel::scale; may be empty
    Eigen::VectorXd contact_log_scale = {};
    /// of constants and contact, which are instantaneous values; may be empty
    Relaxation relaxation = {};
    SpringCurve curve = {};                ///< force curve of its springs
    /// other disc radii that it was trained for (springs/energy_model_at_radius.h); may be empty
    DiscSizes sizes = {};
};

/// All that a session, the exports and the page need. Records of the training are in train/training_diagnostics.h; model.h5
/// holds both.
struct TissueModel {
    std::string study, law;
    SpringMesh mesh;
    /// E2 = E t; in space E [Pa] (t = 1, without unit)
    double modulus_N_m;
    Eigen::VectorXd node_mass_kg;          ///< node masses, the paper's (8) (N)
    /// theta of (7) with E2 = E t and with E2 = (C1 + C2) t [N/m] (S)
    Eigen::VectorXd heuristic_a, heuristic_b;

    /// the single set that fits all cases best [N/m] (S)
    Eigen::VectorXd one_set;

    std::vector<std::string> case_names;   ///< (C)
    NodeField contact_m, direction;        ///< contact [m] and unit direction of each case (C x D)
    Eigen::VectorXd magnitude_m;           ///< tool displacement of each case [m] (C)
    /// FE force of the indenter on the tissue (C x D); 0 rows if the file has none
    NodeField contact_force_N;
    std::vector<SpringSets> trained;       ///< first those of the study's optimiser
    /// certified optimum: the best spring sets within the bounds [N/m] (C x S)
    NodeField optimum;

    /// replaces one_set, trained and optimum, which are then empty
    std::optional<EnergyModel> energy_model;

    /// in space: surface of the inclusion as given by the study; may be empty, always so in files of earlier programs
    NoduleSurface nodule = {};

    /// in space: disc radius of each case [m] (C), if the model was trained under several; otherwise empty
    Eigen::VectorXd case_radius_m = {};

    int case_count() const { return static_cast<int>(case_names.size()); }
    /// Largest displacement of the model's own disc [m]; those of other discs are scaled by the radius. 0 without
    /// cases.
    double deepest_m() const {
        if (case_radius_m.size() > 0) return (magnitude_m.array() / case_radius_m.array()).maxCoeff() * energy_model->disc_radius_m;
        return case_count() > 0 ? magnitude_m.maxCoeff() : 0;
    }
    /// Disc radius of case c [m], in the form that IndentationSolver::of takes: 0 where all cases have the model's own disc.
    double radius_of(Eigen::Index c) const { return case_radius_m.size() > 0 ? case_radius_m[c] : 0; }
    /// Whether the disc of case c is the model's own.
    bool is_own_case(Eigen::Index c) const { return case_radius_m.size() == 0 || case_radius_m[c] == energy_model->disc_radius_m; }
};

/// Writes the model's datasets into a model.h5 that is being written.
void write_tissue(Hdf5Writer& out, const TissueModel& model);

/// Format version of the file for this model: the oldest with all that the model uses, so that earlier programs refuse
/// it.
int format_of(const TissueModel& model);

/// Writes a model.h5 without records of the training; write_trained_model writes complete ones.
void write_model(const std::string& file, const TissueModel& model, const Provenance& provenance);

/// Reads a model with spring sets or an energy model. Throws FileError when the file is not a model, or its parts do
/// not fit together.
TissueModel read_model(const std::string& file);
TissueModel read_model(const Hdf5Reader& in);

}  // namespace tissue
