#pragma once

#include "train/optimizer.h"

namespace tissue {

/// Optimiser "spsa": simultaneous perturbation for a loss whose square is quadratic. Developed here; spsa_2008.h is the
/// paper's method.
///
/// It uses values of the loss only. Two properties give more information from each value than the paper's method gets:
///  - q = L^2/2 is exactly quadratic, with constant curvature. Along any perturbation d,
///    q(theta + c d) = q(theta) + c s + c^2 k/2 for every c, also for large ones. The curvature k is measured once,
///    with +c and -c. After that one loss value gives the slope s to rounding.
///  - The +-1 perturbations are the N rows of a Hadamard matrix (N the power of two >= S) instead of independent draws.
///    One cycle of N slopes then gives the whole gradient by a fast Walsh-Hadamard transform. N random perturbations
///    leave an error as large as the gradient (Bhatnagar, Fu, Marcus and Wang 2003, "Two-timescale simultaneous
///    perturbation stochastic approximation using deterministic perturbation sequences", ACM TOMACS 13, 180-209).
///    Perturbing all springs at once also averages the rounding of the loss over N values (Hotelling 1944, "Some
///    improvements in weighing and other experimental techniques", Ann. Math. Statist. 15, 297-306), which perturbing
///    them one by one does not. Each spring's column has a random sign, so that every perturbation is a Bernoulli one.
/// In the first S iterations every spring is perturbed alone, once. Its curvature scales its steps (columns of A differ
/// by 10^4). A spring with zero curvature does not influence the loss and stays at its start.
/// After each cycle theta moves by one step of conjugate gradients, scaled by these curvatures, in the springs whose
/// bounds are inactive, along the projected path (More and Toraldo 1991, "On the solution of large quadratic
/// programming problems with bound constraints", SIAM J. Optim. 1, 93-113). The directions are restarted where such a
/// step does not lower the loss.
///
/// One iteration is two evaluations of the loss, as in the paper; theta moves once in about N/2 iterations.
/// The loss never rises. Perturbed points leave the box by up to c; the result does not. The method needs a loss
/// without noise and with a quadratic square; spsa_2008.h needs neither.
struct SpsaOptions {
    /// c in units of E2: the paper's limit; any c is exact, a large one has least rounding.
    double perturbation = 1;
    double zero_curvature = 1e-12;    ///< over the largest; smaller curvatures are rounding of the loss
    double gap_tolerance = 1e-3;      ///< gap of its own certificate for `converged`: a twentieth of the goal of 2 %
};

class Spsa final : public Optimizer {
   public:
    explicit Spsa(const SpsaOptions& options = {}) : options_(options) {}
    std::string name() const override { return "spsa"; }

    /// rng: draws the signs only, so its seed changes the result by rounding only. Status `converged`: the gap of its
    /// own certificate is <= gap_tolerance. `stalled`: it is not, and neither the conjugate direction nor the gradient
    /// lowers the loss.
    TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                          const StopCriteria& stop, gsl_rng* rng) const override;

   private:
    SpsaOptions options_;
};

}  // namespace tissue
