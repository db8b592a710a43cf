#pragma once

#include <vector>

#include "cases/load_path.h"
#include "train/training_books.h"

namespace tissue {

/// What Sec. 3 promises of its springs, measured on one model's sets. Distances are root mean squares over springs in
/// units of E2.
struct SpringCharacter {
    std::vector<double> near, far;        ///< |theta - theta0| of springs with an end in the 3 x 3 nodes about the
                                          ///< contact, and of the others; one entry a case
    std::vector<double> magnitude_step;   ///< between the sets of neighbouring magnitudes of a path
    std::vector<double> angle_step;       ///< between the sets of neighbouring pushes (<= 46 degrees) of a contact
    int force_steps = 0;                  ///< neighbouring magnitudes with a model force at both
    int force_falls = 0;                  ///< of these, those where the model's force falls while FE's rises
    double smallest_eigenvalue = 0;       ///< of K under its supports, over the sets; in units of E2
    int floppy_sets = 0;                  ///< sets with an eigenvalue below 1e-9 of the largest: zero-energy modes
};

/// theta: one row a case (C x S) or a single row for all. Laws that are not linear are taken at rest for eigenvalues.
SpringCharacter spring_character(const TissueModel& model, const Cases& cases, const NodeField& theta);

/// One point of the front between fitting FE and staying near the heuristic.
struct FrontPoint {
    double ridge;      ///< weight of |theta - theta0|^2, over the mean squared column of Q^(1/2) A
    double rel_loss;   ///< median over the cases
    double distance;   ///< median over the cases of the root mean square of theta - theta0, in units of E2
    int force_falls;   ///< as in SpringCharacter
    double smallest_eigenvalue;
    int not_converged; ///< of its exact solutions, those whose LsqStatus is not `converged`
};

/// The exact solutions of L^2 + ridge |theta - theta0|^2 inside the box, from no ridge to one that holds the heuristic.
std::vector<FrontPoint> ridge_front(const TrainedModel& model, const Cases& cases, double k_min_N_m, double k_max_N_m);

}  // namespace tissue
