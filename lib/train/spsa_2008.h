#pragma once

#include "train/optimizer.h"

namespace tissue {

/// The paper's optimiser (Sec. 3): simultaneous perturbation stochastic approximation, Spall 1998, "Implementation of
/// the simultaneous perturbation algorithm for stochastic optimization", IEEE Trans. Aerosp. Electron. Syst. 34,
/// 817-823. Iteration k = 0, 1, ... with Bernoulli perturbations Delta = +-1:
///     g   = (L(theta + c_k Delta) - L(theta - c_k Delta)) / (2 c_k) Delta
///     theta <- theta - a_k g, each spring's step at most max_step
///     a_k = a / (A + k + 1)^alpha, c_k = max(c / (k + 1)^gamma, c_min)
/// A spring that becomes negative is reset to its start, the others stay, and the gains begin again (k = 0): a restart.
/// A spring above the box is clipped (the paper limits the maximum and does not state how). The paper has no lower
/// limit except zero, so the iterations have none either. Zero is not a valid stiffness, so the result is projected
/// onto the box once, at the end. Learning curve and target use the projected point too.
/// L is differenced, not L^2, as in the paper. L^2 is quadratic, so the difference is the slope of L^2/2 along Delta
/// over the mean of the two losses: a large c shortens the steps and does not change their direction.
///
/// One iteration is two evaluations of the loss; nothing else of the loss is used.
struct Spsa2008Options {
    double alpha = 0.602;    ///< Spall 1998, sec. III: the smallest exponents that theory allows are best in practice
    double gamma = 0.101;    ///< same source
    double stability = 0.1;  ///< A over the number of iterations: same source, "10 percent (or less)"
    double first_perturbation = 1;         ///< c in units of E2: "limited to 0.75 in the first few iterations"
    double least_perturbation = 1. / 750;  ///< c_min in units of E2: "a lower bound of 0.001", over 0.75 N/m
    double max_step = 1;  ///< per spring and iteration, in units of E2: the paper's limit on the change of a spring
    /// Change of a spring in iteration 0, in units of E2; determines a (guideline of Spall 1998). Tuned once over the
    /// 18 cases of `paper` and `paper-axial` between 0.0002 and 0.5: smaller values leave a larger loss; larger values
    /// end sets by restarts (half of them at 0.005, all at 0.01).
    double first_step = 0.003;
    int gradient_estimates = 10;  ///< number of estimates for a from first_step; Spall's guideline: a few
    int max_restarts = 20;        ///< chosen here so that the training ends; the paper has restarts in 3 of 18 cases
};

class Spsa2008 final : public Optimizer {
   public:
    explicit Spsa2008(const Spsa2008Options& options = {}) : options_(options) {}
    std::string name() const override { return "spsa-2008"; }

    /// Status `restarts_exhausted` when a further restart would exceed max_restarts. theta is then the last one, with
    /// negative springs reset to their start.
    TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                          const StopCriteria& stop, gsl_rng* rng) const override;

   private:
    Spsa2008Options options_;
};

}  // namespace tissue
