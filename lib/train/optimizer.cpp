#include "train/optimizer.h"

#include <fmt/format.h>

#include "error.h"
#include "study/kinds.h"
#include "train/bounded_lsq.h"
#include "train/nlopt_optimizer.h"
#include "train/spsa.h"
#include "train/spsa_2008.h"

namespace tissue {

const char* to_string(TrainStatus status) {
    switch (status) {
        case TrainStatus::converged:
            return "converged";
        case TrainStatus::stalled:
            return "stalled";
        case TrainStatus::target_met:
            return "target_met";
        case TrainStatus::iterations_done:
            return "iterations_done";
        case TrainStatus::time_out:
            return "time_out";
        case TrainStatus::restarts_exhausted:
            return "restarts_exhausted";
    }
    return "unknown";
}

const Registry<std::shared_ptr<const Optimizer>>& optimizers() {
    static const Registry<std::shared_ptr<const Optimizer>> all = [] {
        std::vector<std::shared_ptr<const Optimizer>> list = {
            std::make_shared<Spsa2008>(),
            std::make_shared<Spsa>(),
            std::make_shared<ExactOptimizer>(),
        };
        for (const std::string& algorithm : nlopt_algorithm_names())
            list.push_back(std::make_shared<NloptOptimizer>(algorithm));
        return Registry<std::shared_ptr<const Optimizer>>("optimizer", list,
                                                          [](const auto& optimizer) { return optimizer->name(); });
    }();
    return all;
}

std::vector<std::string> optimizer_names() { return optimizers().names(); }

void check_problem(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m) {
    const Eigen::Index springs = loss.matrix().cols();
    if (start.size() != springs || box.lo.size() != springs || box.hi.size() != springs)
        throw MismatchError(fmt::format("training: the loss has {} springs, the start {}, the box {} and {}", springs,
                                        start.size(), box.lo.size(), box.hi.size()));
    for (Eigen::Index s = 0; s < springs; ++s) {
        if (!(box.lo[s] <= box.hi[s]))
            throw MismatchError(
                fmt::format("training: the box of spring {} is empty: {} to {} N/m", s, box.lo[s], box.hi[s]));
        if (!(start[s] >= box.lo[s] && start[s] <= box.hi[s]))
            throw MismatchError(fmt::format("training: spring {} starts at {} N/m, outside its box {} to {} N/m", s,
                                            start[s], box.lo[s], box.hi[s]));
    }
    if (!(unit_N_m > 0)) throw MismatchError(fmt::format("training: E2 = {} N/m is not positive", unit_N_m));
}

TrainMonitor::TrainMonitor(const StopCriteria& stop, double loss_scale)
    : stop_(stop), target_(stop.target_rel_loss.value_or(0) * loss_scale), begin_(std::chrono::steady_clock::now()) {
    curve_.reserve(40);  // three points for each decade and the last one: enough for any int
}

void TrainMonitor::record(int iteration, double loss) {
    curve_.push_back({iteration, loss});
    if (iteration < next_) return;
    // next point: 1, 2 or 5 of a decade
    int decade = 1;
    while (decade <= next_ / 10) decade *= 10;
    next_ = next_ == 0 ? 1 : next_ == decade ? 2 * decade : next_ == 2 * decade ? 5 * decade : 10 * decade;
}

std::optional<TrainStatus> TrainMonitor::stop_after(int iteration, double loss) const {
    if (stop_.target_rel_loss && loss <= target_) return TrainStatus::target_met;
    if (iteration >= stop_.iterations) return TrainStatus::iterations_done;
    if (stop_.max_seconds && seconds() >= *stop_.max_seconds) return TrainStatus::time_out;
    return std::nullopt;
}

double TrainMonitor::seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

void TrainMonitor::finish(TrainSummary& summary, int iterations, double loss, TrainStatus status) {
    if (curve_.empty() || curve_.back().iteration < iterations) curve_.push_back({iterations, loss});
    summary.loss = loss;
    summary.iterations = iterations;
    summary.seconds = seconds();
    summary.status = status;
    summary.curve = std::move(curve_);
}

}  // namespace tissue
