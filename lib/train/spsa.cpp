#include "train/spsa.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "train/certificate.h"

namespace tissue {
namespace {

/// In place: v_i <- sum_j H_ij v_j with Sylvester's Hadamard matrix; size a power of two.
void walsh_hadamard_transform(Eigen::VectorXd& v) {
    for (Eigen::Index half = 1; half < v.size(); half *= 2)
        for (Eigen::Index block = 0; block < v.size(); block += 2 * half)
            for (Eigen::Index i = block; i < block + half; ++i) {
                const double a = v[i], b = v[i + half];
                v[i] = a + b;
                v[i + half] = a - b;
            }
}

/// Row j of Sylvester's Hadamard matrix, by doubling: H_2N = (H_N H_N; H_N -H_N).
void hadamard_row(Eigen::Index j, Eigen::VectorXd& row) {
    row[0] = 1;
    for (Eigen::Index half = 1; half < row.size(); half *= 2) {
        const double sign = j & half ? -1 : 1;
        for (Eigen::Index i = 0; i < half; ++i) row[half + i] = sign * row[i];
    }
}

/// One training. The constructor allocates all vectors.
class Run {
   public:
    Run(const SpsaOptions& options, const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit,
        const StopCriteria& stop, gsl_rng* rng)
        : options_(options),
          loss_(loss),
          box_(box),
          monitor_(stop, loss.scale()),
          c_(options.perturbation * unit),
          theta_(start),
          trial_(start),
          gradient_(start.size()),
          curvature_(start.size()),
          scaled_(start.size()),
          previous_gradient_(Eigen::VectorXd::Zero(start.size())),
          step_(Eigen::VectorXd::Zero(start.size())),
          direction_(start.size()),
          signs_(start.size()),
          workspace_(loss.target().size()) {
        Eigen::Index order = 1;
        while (order < start.size()) order *= 2;
        row_.resize(order);
        slopes_.resize(order);
        row_curvature_ = Eigen::VectorXd::Constant(order, -1);  // -1: not measured yet
        const double middle = (static_cast<double>(gsl_rng_max(rng)) + static_cast<double>(gsl_rng_min(rng))) / 2;
        for (double& sign : signs_) sign = static_cast<double>(gsl_rng_get(rng)) > middle ? 1 : -1;
    }

    TrainSummary run() {
        const double first = loss_(theta_, workspace_);
        value_ = first * first / 2;
        monitor_.record(0, first);
        status_ = monitor_.stop_after(0, first);

        bool measured = !status_ && measure_each_spring();
        while (measured && !status_) {
            if (certified_gap() <= options_.gap_tolerance)
                status_ = TrainStatus::converged;
            else if (!move() && !status_)  // not when a stop criterion ended the step
                status_ = TrainStatus::stalled;
            measured = !status_ && measure_gradient();
        }

        TrainSummary summary;
        summary.theta = theta_;
        summary.evaluations = evaluations_;
        monitor_.finish(summary, iterations(), std::sqrt(2 * value_), *status_);
        return summary;
    }

   private:
    int iterations() const { return (evaluations_ + 1) / 2; }

    /// q at a point. Counts evaluations, and checks the stop criteria after every second one.
    double evaluate(const Eigen::VectorXd& point) {
        const double value = loss_(point, workspace_);
        if (++evaluations_ % 2 == 0) {
            const double reached = std::sqrt(2 * value_);
            if (monitor_.wants(iterations())) monitor_.record(iterations(), reached);
            if (!status_) status_ = monitor_.stop_after(iterations(), reached);
        }
        return value * value / 2;
    }

    /// Slope and curvature of q along each spring alone. False when a stop criterion ended it early.
    bool measure_each_spring() {
        for (Eigen::Index s = 0; s < theta_.size() && !status_; ++s) {
            trial_ = theta_;
            trial_[s] = theta_[s] + c_;
            const double plus = evaluate(trial_);
            trial_[s] = theta_[s] - c_;
            const double minus = evaluate(trial_);
            gradient_[s] = (plus - minus) / (2 * c_);
            curvature_[s] = (plus - 2 * value_ + minus) / (c_ * c_);
        }
        const double zero = options_.zero_curvature * curvature_.maxCoeff();
        for (double& curvature : curvature_)
            if (!(curvature > zero)) curvature = 0;
        return !status_;
    }

    /// Gradient at theta from one cycle of simultaneous perturbations. False when a stop criterion ended it early.
    bool measure_gradient() {
        for (Eigen::Index j = 0; j < slopes_.size() && !status_; ++j) {
            hadamard_row(j, row_);
            direction_ = c_ * signs_.cwiseProduct(row_.head(theta_.size()));
            trial_ = theta_ + direction_;
            const double plus = evaluate(trial_) - value_;
            if (row_curvature_[j] < 0) {
                trial_ = theta_ - direction_;
                row_curvature_[j] = std::max(plus + evaluate(trial_) - value_, 0.0);
            }
            slopes_[j] = (plus - row_curvature_[j] / 2) / c_;
        }
        if (status_) return false;
        walsh_hadamard_transform(slopes_);
        gradient_ = signs_.cwiseProduct(slopes_.head(theta_.size())) / static_cast<double>(slopes_.size());
        return true;
    }

    double certified_gap() {
        for (Eigen::Index s = 0; s < gradient_.size(); ++s)
            if (curvature_[s] == 0) gradient_[s] = 0;
        const double bound = value_ - certificate_slack(gradient_, theta_, box_);
        return loss_gap(std::sqrt(2 * value_), bound > 0 ? std::sqrt(2 * bound) : 0, loss_.scale());
    }

    /// True for a spring that the loss depends on and whose bounds are inactive.
    bool is_free(Eigen::Index s) const {
        return curvature_[s] > 0 && !(theta_[s] <= box_.lo[s] && gradient_[s] > 0) &&
               !(theta_[s] >= box_.hi[s] && gradient_[s] < 0);
    }

    /// One step of projected conjugate gradients. False when no direction lowers the loss or a stop criterion holds.
    bool move() {
        for (Eigen::Index s = 0; s < theta_.size(); ++s) {
            scaled_[s] = is_free(s) ? gradient_[s] / curvature_[s] : 0;
            if (!is_free(s)) step_[s] = 0;
        }
        // Hestenes and Stiefel's factor, clamped at zero (a restart, as with Polak and Ribiere's)
        const double along = step_.dot(gradient_) - step_.dot(previous_gradient_);
        const double change = scaled_.dot(gradient_) - scaled_.dot(previous_gradient_);
        const double factor = along > 0 ? std::max(change / along, 0.0) : 0;
        direction_ = factor * step_ - scaled_;
        previous_gradient_ = gradient_;
        if (factor > 0 && descend()) return true;
        direction_ = -scaled_;
        return descend();
    }

    /// Line search along the projected direction_; stores the step in step_. False when the loss does not fall, or when
    /// a stop criterion ended the search before it fell.
    bool descend() {
        const double slope = gradient_.dot(direction_);
        if (status_ || !(slope < 0)) return false;
        trial_ = theta_ + direction_;
        const double curvature = 2 * (evaluate(trial_) - value_ - slope);
        double alpha = curvature > 0 ? -slope / curvature : 1;
        for (int tries = 0; tries < 20 && !status_; ++tries, alpha /= 3) {
            trial_ = (theta_ + alpha * direction_).cwiseMax(box_.lo).cwiseMin(box_.hi);
            const double value = evaluate(trial_);
            if (!(value < value_)) continue;
            if (status_) {  // a stop criterion holds: keep this point
                theta_ = trial_;
                value_ = value;
                return true;
            }
            // q along the chord follows from its slope and end value: go to its minimum inside the box
            step_ = trial_ - theta_;
            const double chord_slope = gradient_.dot(step_), chord_curvature = 2 * (value - value_ - chord_slope);
            if (chord_curvature > 0) step_ *= std::min(-chord_slope / chord_curvature, longest(step_));
            trial_ = (theta_ + step_).cwiseMax(box_.lo).cwiseMin(box_.hi);
            const double lowest = evaluate(trial_);
            if (!(lowest < value_)) return false;  // rounding
            step_ = trial_ - theta_;
            theta_ = trial_;
            value_ = lowest;
            return true;
        }
        return false;
    }

    /// The multiple of a step that reaches the boundary of the box.
    double longest(const Eigen::VectorXd& step) const {
        double multiple = std::numeric_limits<double>::infinity();
        for (Eigen::Index s = 0; s < step.size(); ++s)
            if (step[s] != 0)
                multiple = std::min(multiple, ((step[s] > 0 ? box_.hi[s] : box_.lo[s]) - theta_[s]) / step[s]);
        return multiple;
    }

    const SpsaOptions options_;
    const ForceLoss& loss_;
    const Box& box_;
    TrainMonitor monitor_;
    const double c_;    // perturbation [N/m]
    double value_ = 0;  // q at theta
    int evaluations_ = 0;
    std::optional<TrainStatus> status_;  // set when the training ends

    Eigen::VectorXd theta_, trial_;         // (S)
    Eigen::VectorXd gradient_, curvature_;  // of q (S); curvature 0: the loss does not depend on the spring
    Eigen::VectorXd scaled_, previous_gradient_, step_, direction_;  // of the conjugate gradients (S)
    Eigen::VectorXd signs_;                                          // random +-1 (S)
    Eigen::VectorXd row_, slopes_, row_curvature_;                   // of a cycle (N)
    Eigen::VectorXd workspace_;
};

}  // namespace

TrainSummary Spsa::minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                            const StopCriteria& stop, gsl_rng* rng) const {
    check_problem(loss, start, box, unit_N_m);
    return Run(options_, loss, start, box, unit_N_m, stop, rng).run();
}

}  // namespace tissue
