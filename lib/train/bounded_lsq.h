#pragma once

#include <Eigen/Core>

#include "train/optimizer.h"

namespace tissue {

/// min |b - B theta|^2 over lo <= theta <= hi, to rounding: the best spring set there is for one load case.
///
/// Projected Newton steps on the springs that are not held by the box (Bertsekas 1982, "Projected Newton methods for
/// optimization problems with simple constraints", SIAM J. Control Optim. 20, 221-246), columns scaled to unit length.
/// The free block's Cholesky factor is shifted by a multiple of the identity (Levenberg 1944; Marquardt 1963), which
/// falls while whole steps succeed and rises where the projected step does not lower the loss: so a B without full
/// column rank is solved too. The gradient always comes from the residual b - B theta, never from B'B, so the shift and
/// the squared condition of B'B cost iterations, not accuracy. Every step lowers the loss. Deterministic.
struct BoundedLsqOptions {
    int max_iterations = 500;      ///< well above what the 18 cases of `paper` need: 4-20 on grid4, 10-60 on grid8
    double kkt_tolerance = 1e-12;  ///< of kkt_residual: makes the bound sharp to 1e-10 where springs fit to 0.1 %
    double first_shift = 1e-3;     ///< of a unit diagonal; measured: fewer factorisations than 1e-11 or 1e-2
    double shift = 1e-11;          ///< the least: above rounding of the factor
    double zero_column = 1e-10;    ///< of the longest column: a shorter one is rounding of FE's u, and counts as zero
};

/// Why it stopped.
enum class LsqStatus {
    converged,       ///< kkt_residual <= kkt_tolerance
    stalled,         ///< kkt_residual > kkt_tolerance, and no step with a shift below 1e9 lowers the loss: at rounding
    iterations_done  ///< kkt_residual > kkt_tolerance, iterations >= max_iterations
};

struct BoundedLsqSummary {
    Eigen::VectorXd theta;     ///< (S), inside the box; a spring whose column is zero keeps its start
    double residual_norm = 0;  ///< |b - B theta|
    double kkt_residual = 0;   ///< see certificate.h; as a part of |b|
    int iterations = 0;
    LsqStatus status = LsqStatus::iterations_done;
};

/// loss gives B (rows x S, matrix()) and b (target()); start (S) inside the box.
/// Throws MismatchError when sizes disagree, the box is empty or start lies outside it.
BoundedLsqSummary solve_bounded_lsq(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box,
                                    const BoundedLsqOptions& options = {});

/// The status of the same name.
TrainStatus train_status(LsqStatus status);

/// The same behind the optimisers' interface, as "exact". It knows A, not only the loss, and takes the few iterations
/// it takes: rng and the stop criteria are not used.
class ExactOptimizer final : public Optimizer {
   public:
    std::string name() const override { return "exact"; }
    bool is_exact() const override { return true; }
    TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                          const StopCriteria& stop, gsl_rng* rng) const override;
};

}  // namespace tissue
