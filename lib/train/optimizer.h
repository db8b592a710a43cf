#pragma once

#include <gsl/gsl_rng.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "train/force_loss.h"

namespace tissue {

/// Where a stiffness may lie: lo <= theta <= hi, element by element (S) [N/m].
struct Box {
    Eigen::VectorXd lo, hi;
};

/// Stop criteria of Fig. 5. An absent one does not stop anything.
struct StopCriteria {
    int iterations = 20000;                   ///< of origin: twice the range of the paper's Fig. 4
    std::optional<double> max_seconds;        ///< computation time [s]; makes the result depend on the machine
    std::optional<double> target_rel_loss;    ///< magnitude of error, L / sqrt(f_fe' Q f_fe)
};

enum class TrainStatus { iterations_done, time_out, target_met, converged, restarts_exhausted };

/// The status in the words of reports: "iterations_done", ...
const char* to_string(TrainStatus status);

/// One point of a learning curve (Fig. 4).
struct LearningPoint {
    int iteration;
    double loss;  ///< [N], at the parameters the optimiser would return there
};

struct TrainSummary {
    Eigen::VectorXd theta;               ///< (S) [N/m], inside the box
    double loss = 0;                     ///< L(theta) [N]
    int iterations = 0;                  ///< of all restarts together
    int evaluations = 0;                 ///< of the loss
    int restarts = 0;
    double seconds = 0;
    TrainStatus status = TrainStatus::iterations_done;
    std::vector<LearningPoint> curve;    ///< at iterations 0, 1, 2, 5, 10, 20, 50, ... and the last; plus 1000, 5000
};

/// A way to minimise the loss of one spring set over a box. It sees nothing of the loss but its value, except where
/// its description says so.
class Optimizer {
   public:
    virtual ~Optimizer() = default;
    virtual std::string name() const = 0;

    /// start: the heuristic's theta (S), inside the box. unit_N_m: E2, in which the paper's gains are measured.
    /// rng: this set's own stream; the result depends on nothing else. Non-convergence is a status.
    virtual TrainSummary minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box,
                                  double unit_N_m, const StopCriteria& stop, gsl_rng* rng) const = 0;
};

/// Names: "spsa-2008", "spsa". Throws MismatchError for an unknown one.
std::unique_ptr<Optimizer> make_optimizer(const std::string& name);

}  // namespace tissue
