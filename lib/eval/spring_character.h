#pragma once

#include <vector>

#include "cases/load_path.h"
#include "train/training_diagnostics.h"

namespace tissue {

/// Properties of spring sets that Sec. 3 of the paper expects, evaluated for one model. Distances are root mean squares
/// over springs in units of E2.
struct SpringCharacter {
    std::vector<double> near, far;        ///< |theta - theta0| of springs with an end in the 3 x 3 nodes about the
                                          ///< contact, and of the other springs; of each case (C)
    std::vector<double> magnitude_step;   ///< between the sets of neighbouring magnitudes of a path
    std::vector<double> angle_step;       ///< between the sets of directions <= 46 degrees apart at a contact
    int force_steps = 0;                  ///< pairs of neighbouring magnitudes
    int force_falls = 0;                  ///< pairs where the model's force falls while the FE force rises
    double smallest_eigenvalue = 0;       ///< of K with fixed nodes, smallest over the sets; in units of E2
    int singular_sets = 0;                  ///< sets with zero-energy modes: an eigenvalue below 1e-9 of the largest
};

/// theta [N/m]: one row for each case (C x S), or a single row for all. Eigenvalues are those of K at rest.
SpringCharacter spring_character(const TissueModel& model, const Cases& cases, const NodeField& theta);

/// One point of the Pareto front between a small nodal-force error and a small distance from the heuristic.
struct FrontPoint {
    double ridge;      ///< weight of |theta - theta0|^2, over the mean squared column of Q^(1/2) A
    double rel_loss;   ///< median over the cases
    double distance;   ///< median over the cases of the root mean square of theta - theta0, in units of E2
    int force_falls;   ///< SpringCharacter::force_falls
    double smallest_eigenvalue;
    int not_converged; ///< exact solutions whose LsqStatus is not `converged`
};

/// Exact minima of L^2 + ridge |theta - theta0|^2 inside the box [k_min_N_m, k_max_N_m], theta0 the heuristic, for
/// twelve values of ridge from 0 to 10. With the largest one theta stays close to the heuristic.
std::vector<FrontPoint> ridge_front(const TrainedModel& model, const Cases& cases, double k_min_N_m, double k_max_N_m);

}  // namespace tissue
