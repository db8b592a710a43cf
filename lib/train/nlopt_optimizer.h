#pragma once

#include <vector>

#include "train/optimizer.h"

namespace tissue {

/// The local, deterministic algorithms of NLopt that take bounds: "LD_LBFGS", "LD_MMA", "LN_BOBYQA", ...
const std::vector<std::string>& nlopt_algorithm_names();

/// An NLopt algorithm (Johnson, "The NLopt nonlinear-optimization package") beside ours. It minimises L^2/2, columns of
/// A scaled to unit length; those whose names begin with LD see the exact gradient. One iteration is one evaluation.
/// Stops at a relative change of L^2/2 of 1e-10 as well, `converged`, or where NLopt gives up at rounding, `stalled`.
class NloptOptimizer final : public Optimizer {
   public:
    /// Throws MismatchError for a name that nlopt_algorithm_names() has not, listing them.
    explicit NloptOptimizer(const std::string& algorithm);
    std::string name() const override { return "nlopt:" + algorithm_; }

    /// rng is not used. Springs whose columns are zero stay at their start.
    TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                          const StopCriteria& stop, gsl_rng* rng) const override;

   private:
    std::string algorithm_;
};

}  // namespace tissue
