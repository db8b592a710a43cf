#pragma once

#include <vector>

#include "train/optimizer.h"

namespace tissue {

/// Names of the local, deterministic NLopt algorithms with bounds: "LD_LBFGS", "LD_MMA", "LN_BOBYQA", ...
const std::vector<std::string>& nlopt_algorithm_names();

/// An algorithm of NLopt (Johnson, "The NLopt nonlinear-optimization package"), for comparison. It minimises L^2/2 with
/// the columns of A scaled to unit length. Algorithms whose names begin with LD get the exact gradient. One iteration
/// is one evaluation. Further ends than the stop criteria: `converged` at a relative change of L^2/2 of 1e-10,
/// `stalled` where NLopt stops at rounding.
class NloptOptimizer final : public Optimizer {
   public:
    /// algorithm: one of nlopt_algorithm_names(), else throws MismatchError, which lists them.
    explicit NloptOptimizer(const std::string& algorithm);
    std::string name() const override { return "nlopt:" + algorithm_; }

    /// rng is not used. Springs with zero columns stay at their start.
    TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                          const StopCriteria& stop, gsl_rng* rng) const override;

   private:
    std::string algorithm_;
};

}  // namespace tissue
