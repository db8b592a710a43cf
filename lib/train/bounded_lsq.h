#pragma once

#include <Eigen/Core>

#include "train/optimizer.h"

namespace tissue {

/// min |b - B theta|^2 over lo <= theta <= hi, to rounding: the best spring set there is for one load case.
///
/// Projected Newton steps on the springs that are not held by the box (Bertsekas 1982, "Projected Newton methods for
/// optimization problems with simple constraints", SIAM J. Control Optim. 20, 221-246), columns scaled to unit length,
/// the free block's Cholesky factor shifted by a trace of the identity (Levenberg 1944), so that a B without full
/// column rank is solved too; the gradient always comes from the residual b - B theta, never from B'B, so that the
/// conditioning is B's in the result. Every step lowers the loss; the limit satisfies the optimality conditions.
/// Deterministic.
struct BoundedLsqOptions {
    int max_iterations = 200;         ///< well above what the 18 cases of `paper` needed: 4-14 on grid4, 6-52 on grid8
    double kkt_tolerance = 1e-12;     ///< of kkt_residual: what makes the bound sharp to 1e-10 where springs fit to 0.1 %
    double shift = 1e-11;             ///< of the unit diagonal: above rounding of the factor, below what the loss feels
    double silent_column = 1e-10;     ///< a column this much shorter than the longest says nothing: rounding of FE's u
};

struct BoundedLsqSummary {
    Eigen::VectorXd theta;      ///< (S), inside the box; where the data says nothing about a spring: its start
    double residual_norm = 0;   ///< |b - B theta|
    double kkt_residual = 0;    ///< see certificate.h; as a part of |b|
    int iterations = 0;
    bool converged = false;     ///< kkt_residual <= kkt_tolerance
};

/// loss gives B (rows x S, matrix()) and b (target()); start (S) inside the box.
/// Throws MismatchError when sizes disagree, the box is empty or start lies outside it.
BoundedLsqSummary solve_bounded_lsq(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box,
                                    const BoundedLsqOptions& options = {});

/// The same behind the optimisers' interface, as "exact". It knows A, not only the loss; rng and E2 are not used, of the
/// stop criteria none: it takes what it takes.
class ExactOptimizer final : public Optimizer {
   public:
    std::string name() const override { return "exact"; }
    TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                          const StopCriteria& stop, gsl_rng* rng) const override;
};

}  // namespace tissue
