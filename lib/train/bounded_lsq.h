#pragma once

#include <Eigen/Core>

#include "train/optimizer.h"

namespace tissue {

/// Options of solve_bounded_lsq: min |b - B theta|^2 over lo <= theta <= hi, solved to rounding. The minimum is the
/// certified optimum, the best spring set for one load case.
///
/// Method: projected Newton steps in the springs whose bounds are inactive (Bertsekas 1982, "Projected Newton methods
/// for optimization problems with simple constraints", SIAM J. Control Optim. 20, 221-246), columns scaled to unit
/// length. A multiple of the identity is added to the block of the inactive springs before its Cholesky factorisation
/// (Levenberg 1944; Marquardt 1963). This shift falls while whole steps succeed, and rises where the projected step
/// does not lower the loss; a B without full column rank can therefore be solved too. The gradient is computed from the
/// residual b - B theta, never from B'B, so the shift and the squared condition number of B'B cost iterations but no
/// accuracy. Every step lowers the loss. Deterministic.
struct BoundedLsqOptions {
    int max_iterations = 500;      ///< well above the 4-20 (grid4) and 10-60 (grid8) of the 18 cases of `paper`
    double kkt_tolerance = 1e-12;  ///< for kkt_residual; the bound is then sharp to 1e-10 where springs fit to 0.1 %
    double first_shift = 1e-3;     ///< over the unit diagonal; measured: fewer factorisations than with 1e-11 or 1e-2
    double shift = 1e-11;          ///< smallest shift, above the rounding of the factor
    /// Over the longest column: shorter ones are rounding of the FE u, and count as zero.
    double zero_column = 1e-10;
};

/// Why the solver stopped.
enum class LsqStatus {
    converged,       ///< kkt_residual <= kkt_tolerance
    stalled,         ///< kkt_residual > kkt_tolerance, but no step with a shift below 1e9 lowers the loss: rounding
    iterations_done  ///< kkt_residual > kkt_tolerance, iterations >= max_iterations
};

struct BoundedLsqSummary {
    Eigen::VectorXd theta;     ///< [N/m] (S), inside the box; a spring with a zero column keeps its start
    double residual_norm = 0;  ///< |b - B theta|
    /// Residual of the Karush-Kuhn-Tucker conditions: the largest change of B theta, over |b|, when one spring alone
    /// moves to its own optimum inside the box. Zero at the optimum and only there.
    double kkt_residual = 0;
    int iterations = 0;
    LsqStatus status = LsqStatus::iterations_done;
};

/// loss: gives B (rows x S) as matrix() and b (rows) as target(). start [N/m] (S): inside the box.
/// Throws MismatchError when sizes disagree, the box is empty or start lies outside it.
BoundedLsqSummary solve_bounded_lsq(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box,
                                    const BoundedLsqOptions& options = {});

/// The TrainStatus of the same name.
TrainStatus train_status(LsqStatus status);

/// solve_bounded_lsq as an Optimizer, named "exact". It uses the matrix A, not only values of the loss. It does not use
/// rng and the stop criteria, because it needs few iterations.
class ExactOptimizer final : public Optimizer {
   public:
    std::string name() const override { return "exact"; }
    bool is_exact() const override { return true; }
    TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                          const StopCriteria& stop, gsl_rng* rng) const override;
};

}  // namespace tissue
