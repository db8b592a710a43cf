#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "eval/closed_loop.h"
#include "eval/force_error.h"
#include "train/training_books.h"

namespace tissue {

/// One drawn contact that no set was trained on, at its own depth.
struct DrawnContact {
    std::string name;
    Point contact_m, direction;           ///< at rest; unit vector of the push (D)
    double arc_m;                         ///< in the plane: place along the surface
    double angle_deg;                     ///< of the push off the inward normal; in space not signed
    double depth_m;                       ///< length of the push
    double clearance_m, thickness_m;      ///< in space, as of FreeSurface: to where the free surface ends or turns; of the tissue straight in
    Point fe_force_N;
    bool extrapolated;                    ///< outside what the sets were trained on
    std::vector<ContactError> error;      ///< of each model, in closed loop
    double radius_m = 0;                  ///< of the disc, in space
};

/// One role of drawn contacts: validation, held_out or held_out_full.
struct DrawnContacts {
    std::string role;
    std::vector<DrawnContact> contacts;
    std::vector<std::string> lost;        ///< "name: why", contacts at which FE has no answer
    std::vector<double> lost_radius_m = {};  ///< of their discs, in space

    std::vector<double> radii_m() const;               ///< of the discs, ascending; none where all have one
    DrawnContacts of_disc(double radius_m) const;      ///< those contacts alone, lost ones too
    int drawn() const { return static_cast<int>(contacts.size() + lost.size()); }
    ContactStatistics statistics(std::size_t model) const;  ///< of all that were drawn
};

/// The truth's own error: pushes solved again on the finer mesh of the study.
struct TruthCheck {
    Statistics difference{};              ///< |r_coarse - r_fine| / |r_fine| at load cases or drawn contacts; no_reference: one of both is missing
    std::vector<std::string> lost;        ///< "name: why", pushes that have no answer on the finer mesh at their depth
    std::vector<std::string> unmatched;   ///< "name: why", those with nothing on the study's mesh to compare with

    bool empty() const { return difference.of() == 0 && lost.empty() && unmatched.empty(); }
};
/// Every check at every load case of its training path, or at its drawn contact's depth: each is in `difference`, `lost`
/// or `unmatched`.
TruthCheck check_truth(const Cases& cases);

/// Force along the push against its length at one drawn contact: FE, and models in closed loop.
struct DrawnCurve {
    std::string name;
    std::vector<double> magnitude_m, fe_N, learned_N, uniform_N;  ///< NaN where there is no answer
};

/// Where the tissue's nodes go at one drawn contact, as the first of the models has it.
struct DrawnShape {
    std::string name;
    std::string which;                    ///< median or largest, of the shape errors of all contacts
    NodeField displacement_m;             ///< u of the tissue's own nodes [m] (N x D)
};

struct HeldOut {
    std::vector<std::string> models;      ///< learned first
    std::vector<DrawnContacts> roles;
    std::vector<DrawnCurve> curves;       ///< of the first held_out contacts, which were drawn by seed
    std::vector<DrawnShape> shapes;       ///< at the held_out contacts with the median and the largest shape error

    bool empty() const { return roles.empty(); }
    const DrawnContacts* role(const std::string& name) const;
};

/// Closed-loop errors at every drawn contact of the cases, force and shape:
///   learned            the model's law, of readings at rest what is left of it after long; or the nearest of its sets, Sec. 4.3
///   force_table        no springs and no shape: FE's own forces and their mirror images, interpolated (eval/force_table.h)
///   untrained          of a law: its heuristic, with nothing learned
///   heuristic_a_patch, heuristic_b_patch, uniform_patch  of a law: those springs alone, without cells, under its contact
///   one_set            of sets: the single one that serves all training cases best
///   repeat             measured cases: what the same push's other repeats say: about what a perfect model would leave; a row measured once has
///                      nothing to compare with
///   heuristic_a, heuristic_b, uniform, on the model's mesh and law, and with a suffix on the others
/// In space there are learned, force_table (eval/solid_force_table.h), untrained, heuristic_a_patch and uniform_patch.
/// with_baselines = false leaves out heuristic and uniform ones.
HeldOut evaluate_held_out(const TrainedModel& model, const Cases& cases, int threads, bool with_baselines = true);

}  // namespace tissue
