#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "eval/closed_loop.h"
#include "eval/force_error.h"
#include "train/training_diagnostics.h"

namespace tissue {

/// One drawn contact, not used for training, at its own depth. Errors of all models against the FE reference.
struct DrawnContact {
    std::string name;
    Point contact_m, direction;           ///< contact at rest; unit vector of the tool displacement (D)
    double arc_m;                         ///< arc length along the free surface; two dimensions only, else NaN
    double angle_deg;                     ///< from the inward normal to the tool displacement; in space not signed
    double depth_m;                       ///< length of the tool displacement
    /// In space, else NaN. clearance_m: to where the free surface ends or turns (FreeSurface::clearance_m).
    /// thickness_m: of the tissue along the inward normal (FreeSurface::thickness_m).
    double clearance_m, thickness_m;
    Point fe_force_N;
    bool extrapolated;                    ///< outside the range of the training contacts (ForceTable::Entry)
    std::vector<ContactError> error;      ///< of each model, in the order of HeldOut::models
    double radius_m = 0;                  ///< of the disc; 0 in two dimensions
};

/// Drawn contacts of one role: validation (validation set), held_out (test set), held_out_full; in space also
/// held_out_WORD, such as held_out_near.
struct DrawnContacts {
    std::string role;
    std::vector<DrawnContact> contacts;
    std::vector<std::string> lost;        ///< "name: why", contacts without an FE reference
    std::vector<double> lost_radius_m = {};  ///< disc radius of each of these, in space

    std::vector<double> radii_m() const;               ///< disc radii, ascending; empty where all are equal
    DrawnContacts of_disc(double radius_m) const;      ///< the contacts of that disc radius, `lost` ones included
    int drawn() const { return static_cast<int>(contacts.size() + lost.size()); }
    ContactStatistics statistics(std::size_t model) const;  ///< over all drawn contacts
};

/// Discretisation error of the FE reference: load paths solved again on the finer mesh of the study (role "check").
struct DiscretisationCheck {
    Statistics difference{};              ///< |r_coarse - r_fine| / |r_fine|; no_reference: one of the two is missing
    std::vector<std::string> lost;        ///< "name: why", paths that end early on the finer mesh
    std::vector<std::string> unmatched;   ///< "name: why", cases without a counterpart on one of the two meshes

    bool empty() const { return difference.of() == 0 && lost.empty() && unmatched.empty(); }
};
/// Compares every check path at every load case of its training path, or at the depth of its drawn contact. Every check
/// is counted in `difference`, `lost` or `unmatched`.
DiscretisationCheck check_discretisation(const Cases& cases);

/// Force along the tool displacement against its length at one drawn contact: FE, and models in equilibrium.
struct DrawnCurve {
    std::string name;
    std::vector<double> magnitude_m, fe_N, learned_N, uniform_N;  ///< [m], [N]; NaN without an answer
};

/// Displacement field at one drawn contact, of the first model.
struct DrawnShape {
    std::string name;
    std::string which;                    ///< "median" or "largest" displacement error
    /// u of the tissue's nodes [m] (N x D), without those of an embedding lattice.
    NodeField displacement_m;
};

struct HeldOut {
    std::vector<std::string> models;      ///< the trained one first
    std::vector<DrawnContacts> roles;
    std::vector<DrawnCurve> curves;       ///< of the first six held_out contacts; their order is random (seed)
    std::vector<DrawnShape> shapes;       ///< of the held_out contacts with median and largest displacement error

    bool empty() const { return roles.empty(); }
    const DrawnContacts* role(const std::string& name) const;
};

/// Indentation errors of force and displacement at every drawn contact of the cases. Models:
///   learned            the trained energy model, with long-term moduli for measurements of tissue at rest
///                      (energy_model_of_cases); or the nearest spring set (Sec. 4.3)
///   force_table        no springs, force only: FE training forces and their mirror images, interpolated
///                      (eval/force_table.h)
///   untrained          the energy model before training: heuristic constants
///   heuristic_a_patch, heuristic_b_patch, uniform_patch
///                      beside an energy model: these springs without cells, under the untrained contact
///   one_set            beside spring sets: the single set with the least error over all training cases
///   repeat             measured cases: the mean of the other repeats of the same indentation, about the error that a
///                      perfect model would have; a row without repeats has no such error
///   heuristic_a, heuristic_b, uniform
///                      on the mesh and with the spring force of the model; with a suffix on other meshes or forces
/// In space the models are learned, force_table (eval/solid_force_table.h), untrained, heuristic_a_patch,
/// uniform_patch. with_baselines: false leaves out heuristic and uniform models. threads: does not change the result.
HeldOut evaluate_held_out(const TrainedModel& model, const Cases& cases, int threads, bool with_baselines = true);

}  // namespace tissue
