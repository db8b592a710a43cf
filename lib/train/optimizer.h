#pragma once


#include <Eigen/Core>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gsl.h"
#include "registry.h"
#include "train/force_loss.h"

namespace tissue {

/// Bounds of the stiffness: lo <= theta <= hi for each entry [N/m] (S).
struct Box {
    Eigen::VectorXd lo, hi;

    /// The nearest point of the box.
    Eigen::VectorXd project(const Eigen::VectorXd& theta) const { return theta.cwiseMax(lo).cwiseMin(hi); }
};

/// Stop criteria of Fig. 5. An absent one is not used.
struct StopCriteria {
    int iterations = 20000;                 ///< default: twice the range of the paper's Fig. 4
    std::optional<double> max_seconds;      ///< computation time [s]; makes the result depend on the machine
    std::optional<double> target_rel_loss;  ///< relative error L / sqrt(f_fe' Q f_fe)
};

/// Why a training ended, with the condition that holds at its result.
enum class TrainStatus {
    converged,          ///< criterion of the optimiser. spsa: gap of its own certificate <= gap_tolerance; exact:
                        ///< kkt_residual <= kkt_tolerance; nlopt: last relative change of L^2/2 <= 1e-10
    stalled,            ///< not converged, but no step that the optimiser tries lowers L (rounding)
    target_met,         ///< L <= target_rel_loss sqrt(f_fe' Q f_fe)
    iterations_done,    ///< iterations >= StopCriteria::iterations; exact: >= BoundedLsqOptions::max_iterations
    time_out,           ///< seconds >= max_seconds
    restarts_exhausted  ///< spsa-2008: a spring < 0 after max_restarts restarts
};

/// The name of the status in files and reports: "iterations_done", ...
const char* to_string(TrainStatus status);

/// One point of a learning curve (Fig. 4).
struct LearningPoint {
    int iteration;
    double loss;  ///< L [N] of the result, if the training ended here
};

struct TrainSummary {
    Eigen::VectorXd theta;  ///< [N/m] (S), inside the box
    double loss = 0;        ///< L(theta) [N]
    int iterations = 0;     ///< over all restarts
    int evaluations = 0;    ///< of the loss, without those for the learning curve
    int restarts = 0;
    double seconds = 0;
    TrainStatus status = TrainStatus::iterations_done;
    std::vector<LearningPoint> curve;  ///< at iterations 0, 1, 2, 5, 10, 20, 50, ... and the last
};

/// Minimises the loss of one spring set over a box. Optimisers use values of the loss only, unless their documentation
/// states otherwise.
class Optimizer {
   public:
    virtual ~Optimizer() = default;
    virtual std::string name() const = 0;

    /// True when the result is the certified optimum.
    virtual bool is_exact() const { return false; }

    /// start [N/m] (S): theta of the heuristic, inside the box. unit_N_m: E2, the unit of the paper's gains.
    /// rng: random stream of this set, the only source of randomness. Non-convergence is a status.
    /// Throws MismatchError when sizes disagree, the box is empty, start lies outside it or unit_N_m is not positive.
    virtual TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                                  const StopCriteria& stop, gsl_rng* rng) const = 0;
};

/// All optimisers: "spsa-2008" (the paper's), "spsa" (spsa.h), "exact" (bounded_lsq.h), "nlopt:NAME"
/// (nlopt_optimizer.h). They have no state.
const Registry<std::shared_ptr<const Optimizer>>& optimizers();

/// Checks the arguments of `minimise`. Throws MismatchError as documented there.
void check_problem(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m);

/// Stop criteria and learning curve, the same for every optimiser. record() and stop_after() do not allocate.
class TrainMonitor {
   public:
    /// loss_scale: ForceLoss::scale [N]. Time is measured from here on.
    TrainMonitor(const StopCriteria& stop, double loss_scale);

    /// True when the learning curve has a point at this iteration.
    bool wants(int iteration) const { return iteration == next_; }
    void record(int iteration, double loss);

    /// The stop criterion that holds after this iteration, if one does. loss [N].
    std::optional<TrainStatus> stop_after(int iteration, double loss) const;

    double seconds() const;

    /// Fills loss, iterations, seconds, status and curve. The last point of the curve is the result.
    void finish(TrainSummary& summary, int iterations, double loss, TrainStatus status);

   private:
    StopCriteria stop_;
    double target_;
    std::chrono::steady_clock::time_point begin_;
    int next_ = 0;
    std::vector<LearningPoint> curve_;
};

}  // namespace tissue
