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

/// What one optimiser made of every load case: one row of theta a case.
struct SpringSets {
    std::string optimizer;
    NodeField theta;                       ///< [N/m] (C x S)
};

/// Stiffness that is an energy (springs/energy_law.h), the same whatever pushes.
struct LawModel {
    std::vector<std::string> terms;        ///< (P)
    Eigen::VectorXd coefficients;          ///< of the terms (P)
    Eigen::VectorXd constants;             ///< what they make of the heuristic: of a TissueEnergy [N/m] (E)
    PatchLaw patch;                        ///< and of the contact
    SkinLaw skin() const { return skin_of(terms, coefficients); }
    bool incompressible = false;           ///< whether regions keep their area too (TissueEnergy)
    double disc_radius_m = 0;              ///< in space: of the disc that presses,
    DiscTables disc = {};                  ///< and what is read of its place
    Eigen::VectorXd contact_log_scale = {};  ///< of contacts by node (N), ContactKernel::scale; often none
    Relaxation relaxation = {};            ///< of constants and contact, which are the instantaneous ones; often none
    SpringCurve curve = {};                ///< of its springs
    DiscSizes sizes = {};                  ///< other discs that it knows (springs/law_at_radius.h); often none
};

/// What plays: everything that the realtime core, the exports and the page need. What training wrote down beside it is
/// in train/training_books.h; model.h5 holds both.
struct TissueModel {
    std::string study, law;
    SpringMesh mesh;
    double modulus_N_m;                    ///< E2 = E t; in space E [Pa], t = 1 being no length
    Eigen::VectorXd node_mass_kg;          ///< (8) (N)
    Eigen::VectorXd heuristic_a, heuristic_b;  ///< theta of (7) with E2 = E t and (C1 + C2) t [N/m] (S)

    Eigen::VectorXd one_set;               ///< the single set that serves all cases best [N/m] (S)

    std::vector<std::string> case_names;   ///< (C)
    NodeField contact_m, direction;        ///< of each case (C x D)
    Eigen::VectorXd magnitude_m;           ///< (C)
    NodeField contact_force_N;             ///< FE's, of the indenter on the tissue (C x D); 0 rows when the file has none
    std::vector<SpringSets> trained;       ///< the study's optimiser first
    NodeField optimum;                     ///< the best spring sets there are inside the box [N/m] (C x S)

    std::optional<LawModel> energy_law;    ///< in place of one_set, trained and optimum, which it leaves empty

    NoduleSurface nodule = {};             ///< in space: where there is other material, as the study says; often none, and of earlier programs never

    Eigen::VectorXd case_radius_m = {};    ///< of each case's disc, where a law in space was trained under several (C); else empty

    int case_count() const { return static_cast<int>(case_names.size()); }
    /// How deep the law's disc was pushed at most, other discs' pushes in proportion [m]; 0 without cases.
    double deepest_m() const {
        if (case_radius_m.size() > 0) return (magnitude_m.array() / case_radius_m.array()).maxCoeff() * energy_law->disc_radius_m;
        return case_count() > 0 ? magnitude_m.maxCoeff() : 0;
    }
    /// Radius of a case's disc [m], as LawPress::of takes it: 0 where all cases have the law's own.
    double radius_of(Eigen::Index c) const { return case_radius_m.size() > 0 ? case_radius_m[c] : 0; }
    /// Whether a case was pressed by the disc that the law has.
    bool is_own_case(Eigen::Index c) const { return case_radius_m.size() == 0 || case_radius_m[c] == energy_law->disc_radius_m; }
};

/// Its datasets, into a model.h5 that is being written.
void write_tissue(Hdf5Writer& out, const TissueModel& model);

/// The format version of the file that holds it: of a law 2, so that earlier programs refuse it.
int format_of(const TissueModel& model);

/// A model.h5 that plays and holds nothing else: whole ones are write_trained_model's.
void write_model(const std::string& file, const TissueModel& model, const Provenance& provenance);

/// What plays, sets or a law. Throws FileError when the file is not a model, or its parts do not fit together.
TissueModel read_model(const std::string& file);
TissueModel read_model(const Hdf5Reader& in);

}  // namespace tissue
