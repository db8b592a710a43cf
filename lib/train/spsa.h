#pragma once

#include "train/optimizer.h"

namespace tissue {

/// Simultaneous perturbation for a loss whose square is quadratic: ours, where spsa_2008.h is the paper's.
///
/// It sees loss values only. Two facts make more of them than the paper could:
///  - q = L^2/2 is exactly quadratic and its curvature the same everywhere, so along any perturbation d
///    q(theta + c d) = q(theta) + c s + c^2 k/2 holds for every c, large ones too. k is measured once, from both sides;
///    from then on one loss value gives the slope s to rounding.
///  - if the +-1 perturbations are the N rows of a Hadamard matrix (N the power of two >= S) instead of independent
///    draws, one cycle of N slopes gives the whole gradient, by a fast Walsh-Hadamard transform, where N random ones
///    leave an error as large as the gradient (Bhatnagar, Fu, Marcus and Wang 2003, "Two-timescale simultaneous
///    perturbation stochastic approximation using deterministic perturbation sequences", ACM TOMACS 13, 180-209).
///    Moving every spring at once also averages the rounding of the loss over N values (Hotelling 1944, "Some
///    improvements in weighing and other experimental techniques", Ann. Math. Statist. 15, 297-306), which perturbing
///    them one by one does not. Each spring's column gets a random sign, so that every perturbation is a Bernoulli one.
/// Once, in the first S iterations, every spring is perturbed alone: its own curvature is the scale on which it moves
/// (columns of A differ by 10^4), and tells the springs the data says nothing about, which stay.
/// After each cycle theta goes one step of conjugate gradients, scaled by these curvatures, among the springs the box
/// does not hold, along the projected path (More and Toraldo 1991, "On the solution of large quadratic programming
/// problems with bound constraints", SIAM J. Optim. 1, 93-113); directions start afresh where that does not descend.
///
/// One iteration is two evaluations of the loss, as in the paper; theta moves once in about N/2 of them.
/// The loss never rises. Perturbed points leave the box by up to c; the result does not. It is made for a loss without
/// noise whose square is quadratic; spsa_2008.h asks for neither.
struct SpsaOptions {
    double perturbation = 1;          ///< c in units of E2: the paper's limit; any c is exact, a large one rounds least
    double zero_curvature = 1e-12;    ///< of the largest: below lies the rounding of the loss
    double gap_tolerance = 1e-3;      ///< own certificate at which it has `converged`: a twentieth of the goal of 2 %
};

class Spsa final : public Optimizer {
   public:
    explicit Spsa(const SpsaOptions& options = {}) : options_(options) {}
    std::string name() const override { return "spsa"; }

    /// rng chooses the signs, so its seed changes nothing but rounding. Status `converged`: its own certificate says gap
    /// <= gap_tolerance; `stalled`: it does not, and neither the conjugate direction nor the gradient descends any more.
    TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                          const StopCriteria& stop, gsl_rng* rng) const override;

   private:
    SpsaOptions options_;
};

}  // namespace tissue
