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

/// Where a stiffness may lie: lo <= theta <= hi, element by element (S) [N/m].
struct Box {
    Eigen::VectorXd lo, hi;

    /// The nearest point of the box.
    Eigen::VectorXd project(const Eigen::VectorXd& theta) const { return theta.cwiseMax(lo).cwiseMin(hi); }
};

/// Stop criteria of Fig. 5. An absent one does not stop anything.
struct StopCriteria {
    int iterations = 20000;                 ///< of origin: twice the range of the paper's Fig. 4
    std::optional<double> max_seconds;      ///< computation time [s]; makes the result depend on the machine
    std::optional<double> target_rel_loss;  ///< magnitude of error, L / sqrt(f_fe' Q f_fe)
};

/// Why a training ended: what holds at its result.
enum class TrainStatus {
    converged,          ///< the optimiser's own criterion: of spsa, own gap <= gap_tolerance; of exact, kkt_residual <=
                        ///< kkt_tolerance; of nlopt, the last change of L^2/2 <= 1e-10 of it
    stalled,            ///< that does not hold, and no step the optimiser tries lowers L: at rounding, or against it
    target_met,         ///< L <= target_rel_loss sqrt(f_fe' Q f_fe)
    iterations_done,    ///< iterations >= StopCriteria::iterations (of exact: its own max_iterations)
    time_out,           ///< seconds >= max_seconds
    restarts_exhausted  ///< of spsa-2008: a spring < 0 after max_restarts restarts
};

/// The status in the words of reports: "iterations_done", ...
const char* to_string(TrainStatus status);

/// One point of a learning curve (Fig. 4).
struct LearningPoint {
    int iteration;
    double loss;  ///< [N], at the parameters the optimiser would return there
};

struct TrainSummary {
    Eigen::VectorXd theta;  ///< (S) [N/m], inside the box
    double loss = 0;        ///< L(theta) [N]
    int iterations = 0;     ///< of all restarts together
    int evaluations = 0;    ///< of the loss; the learning curve's own are not counted
    int restarts = 0;
    double seconds = 0;
    TrainStatus status = TrainStatus::iterations_done;
    std::vector<LearningPoint> curve;  ///< at iterations 0, 1, 2, 5, 10, 20, 50, ... and the last
};

/// A way to minimise the loss of one spring set over a box. It sees nothing of the loss but its value, except where
/// its description says so.
class Optimizer {
   public:
    virtual ~Optimizer() = default;
    virtual std::string name() const = 0;

    /// True when what it returns is the certified optimum, which need not be solved for again.
    virtual bool is_exact() const { return false; }

    /// start: the heuristic's theta (S), inside the box. unit_N_m: E2, in which the paper's gains are measured.
    /// rng: this set's own stream; the result depends on nothing else. Non-convergence is a status.
    /// Throws MismatchError when sizes disagree, the box is empty, start lies outside it or unit_N_m is not positive.
    virtual TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                                  const StopCriteria& stop, gsl_rng* rng) const = 0;
};

/// Every optimiser there is: "spsa-2008" (the paper's), "spsa" (ours), "exact" (bounded_lsq.h), "nlopt:NAME"
/// (nlopt_optimizer.h). They have no state.
const Registry<std::shared_ptr<const Optimizer>>& optimizers();

/// What `minimise` promises to refuse. Throws MismatchError.
void check_problem(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m);

/// The stop criteria and the learning curve, the same for every optimiser. Allocates nothing after construction.
class TrainMonitor {
   public:
    TrainMonitor(const StopCriteria& stop, double loss_scale);

    /// True when the learning curve has a point at this iteration.
    bool wants(int iteration) const { return iteration == next_; }
    void record(int iteration, double loss);

    /// The criterion that ends the training after this iteration, if one does.
    std::optional<TrainStatus> stop_after(int iteration, double loss) const;

    double seconds() const;

    /// Writes loss, iterations, seconds, status and curve, whose last point is the result's.
    void finish(TrainSummary& summary, int iterations, double loss, TrainStatus status);

   private:
    StopCriteria stop_;
    double target_;
    std::chrono::steady_clock::time_point begin_;
    int next_ = 0;
    std::vector<LearningPoint> curve_;
};

}  // namespace tissue
