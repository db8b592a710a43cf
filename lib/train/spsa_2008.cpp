#include "train/spsa_2008.h"

#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

void draw_bernoulli(gsl_rng* rng, Eigen::VectorXd& delta) {
    const double middle = (static_cast<double>(gsl_rng_max(rng)) + static_cast<double>(gsl_rng_min(rng))) / 2;
    for (double& entry : delta) entry = static_cast<double>(gsl_rng_get(rng)) > middle ? 1 : -1;
}

}  // namespace

TrainSummary Spsa2008::minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box, double unit_N_m,
                                const StopCriteria& stop, gsl_rng* rng) const {
    check_problem(loss, start, box, unit_N_m);
    TrainMonitor monitor(stop, loss.scale());
    TrainSummary summary;
    Eigen::VectorXd theta = start, delta(start.size()), trial(start.size()), workspace(loss.target().size());

    // slope of L along Delta; every entry of the gradient estimate is + or - this value
    const auto slope_along = [&](double c) {
        trial = theta + c * delta;
        const double plus = loss(trial, workspace);
        trial = theta - c * delta;
        summary.evaluations += 2;
        return (plus - loss(trial, workspace)) / (2 * c);
    };
    const auto projected_loss = [&] {
        trial = theta.cwiseMax(box.lo).cwiseMin(box.hi);
        return loss(trial, workspace);
    };

    // a from first_step: a / (A + 1)^alpha * mean |g| = first_step
    const double first_c = options_.first_perturbation * unit_N_m;
    const double A = options_.stability * stop.iterations;
    double mean = 0;
    for (int estimate = 0; estimate < options_.gradient_estimates; ++estimate) {
        draw_bernoulli(rng, delta);
        mean += std::abs(slope_along(first_c)) / options_.gradient_estimates;
    }
    const double a = mean > 0 ? options_.first_step * unit_N_m * std::pow(A + 1, options_.alpha) / mean : 0;
    const double max_step = options_.max_step * unit_N_m;
    const double least_c = options_.least_perturbation * unit_N_m;

    int iteration = 0, k = 0;
    double reached = loss(theta, workspace);
    monitor.record(0, reached);
    std::optional<TrainStatus> status = monitor.stop_after(0, reached);
    while (!status) {
        const double a_k = a / std::pow(A + k + 1, options_.alpha);
        const double c_k = std::max(first_c / std::pow(k + 1, options_.gamma), least_c);
        draw_bernoulli(rng, delta);
        const double step = std::clamp(a_k * slope_along(c_k), -max_step, max_step);
        theta -= step * delta;
        ++iteration, ++k;

        bool negative = false;
        for (Eigen::Index s = 0; s < theta.size(); ++s) {
            if (theta[s] < 0) {
                theta[s] = start[s];
                negative = true;
            }
            theta[s] = std::min(theta[s], box.hi[s]);
        }
        if (negative) {
            if (summary.restarts == options_.max_restarts)
                status = TrainStatus::restarts_exhausted;
            else
                ++summary.restarts, k = 0;
        }

        // loss of the result so far, for the learning curve or the target
        const bool wanted = monitor.wants(iteration);
        if (wanted || stop.target_rel_loss) reached = projected_loss();
        if (stop.target_rel_loss) ++summary.evaluations;
        if (wanted) monitor.record(iteration, reached);
        if (!status) status = monitor.stop_after(iteration, reached);
    }

    reached = projected_loss();
    summary.theta = trial;
    monitor.finish(summary, iteration, reached, *status);
    return summary;
}

}  // namespace tissue
