#include "train/nlopt_optimizer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlopt.hpp>

#include "error.h"

namespace tissue {
namespace {

struct Named {
    const char* name;
    nlopt::algorithm algorithm;
};

// Left out: global and random algorithms (NLopt's random generator is not a Stream), algorithms without bounds, and
// LN_COBYLA, whose simplex of 221 points took minutes without a result.
constexpr Named algorithms[] = {
    {"LD_LBFGS", nlopt::LD_LBFGS},
    {"LD_MMA", nlopt::LD_MMA},
    {"LD_CCSAQ", nlopt::LD_CCSAQ},
    {"LD_SLSQP", nlopt::LD_SLSQP},
    {"LD_VAR1", nlopt::LD_VAR1},
    {"LD_VAR2", nlopt::LD_VAR2},
    {"LD_TNEWTON_PRECOND_RESTART", nlopt::LD_TNEWTON_PRECOND_RESTART},
    {"LN_BOBYQA", nlopt::LN_BOBYQA},
    {"LN_SBPLX", nlopt::LN_SBPLX},
    {"LN_NELDERMEAD", nlopt::LN_NELDERMEAD},
};

/// L^2/2 in the scaled stiffness x = norm theta. Stores the best point, because NLopt returns none when it throws.
struct Objective {
    const ForceLoss& loss;
    const Eigen::VectorXd& norm;
    TrainMonitor& monitor;
    Eigen::VectorXd theta, residual, gradient, best_theta;
    double best_loss;
    int evaluations = 0;

    static double evaluate(const std::vector<double>& x, std::vector<double>& slope, void* self) {
        return static_cast<Objective*>(self)->value(x, slope);
    }

    double value(const std::vector<double>& x, std::vector<double>& slope) {
        const Eigen::Index springs = norm.size();
        theta = Eigen::Map<const Eigen::VectorXd>(x.data(), springs).cwiseQuotient(norm);
        const double reached = loss(theta, residual);
        if (!slope.empty()) {
            gradient.noalias() = loss.matrix().transpose() * residual;
            Eigen::Map<Eigen::VectorXd>(slope.data(), springs) = -gradient.cwiseQuotient(norm);
        }
        if (reached < best_loss) {
            best_loss = reached;
            best_theta = theta;
        }
        if (monitor.wants(++evaluations)) monitor.record(evaluations, best_loss);
        return reached * reached / 2;
    }
};

}  // namespace

const std::vector<std::string>& nlopt_algorithm_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const Named& named : algorithms) all.push_back(named.name);
        return all;
    }();
    return names;
}

NloptOptimizer::NloptOptimizer(const std::string& algorithm) : algorithm_(algorithm) {
    const auto& names = nlopt_algorithm_names();
    if (std::find(names.begin(), names.end(), algorithm) == names.end())
        throw MismatchError(fmt::format("optimizer 'nlopt:{}' is not known; allowed after 'nlopt:': {}", algorithm,
                                        fmt::join(names, ", ")));
}

TrainSummary NloptOptimizer::minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box,
                                      double unit_N_m, const StopCriteria& stop, gsl_rng*) const {
    check_problem(loss, start, box, unit_N_m);
    TrainMonitor monitor(stop, loss.scale());
    const Eigen::Index springs = start.size();

    // a spring with a zero column is not scaled, and its bounds are set to its start
    Eigen::VectorXd norm(springs), lo = box.lo, hi = box.hi;
    for (Eigen::Index s = 0; s < springs; ++s) norm[s] = loss.matrix().col(s).norm();
    const double longest = springs > 0 ? norm.maxCoeff() : 0;
    for (Eigen::Index s = 0; s < springs; ++s)
        if (!(norm[s] > 1e-10 * longest)) {
            norm[s] = 1;
            lo[s] = hi[s] = start[s];
        }

    const double first = loss(start);
    monitor.record(0, first);
    TrainSummary summary;
    summary.theta = start;
    if (const auto status = monitor.stop_after(0, first)) {
        monitor.finish(summary, 0, first, *status);
        return summary;
    }

    Objective objective{loss, norm, monitor, start, loss.target(), start, start, first};
    nlopt::algorithm algorithm = nlopt::LD_LBFGS;
    for (const Named& named : algorithms)
        if (algorithm_ == named.name) algorithm = named.algorithm;
    const auto scaled = [&](const Eigen::VectorXd& theta) {
        const Eigen::VectorXd x = theta.cwiseProduct(norm);
        return std::vector<double>(x.data(), x.data() + springs);
    };
    nlopt::opt search(algorithm, static_cast<unsigned>(springs));
    search.set_lower_bounds(scaled(lo));
    search.set_upper_bounds(scaled(hi));
    search.set_min_objective(&Objective::evaluate, &objective);
    search.set_maxeval(stop.iterations);
    search.set_ftol_rel(1e-10);
    if (stop.max_seconds) search.set_maxtime(*stop.max_seconds);
    if (stop.target_rel_loss) search.set_stopval(std::pow(*stop.target_rel_loss * loss.scale(), 2) / 2);

    TrainStatus status = TrainStatus::converged;
    try {
        std::vector<double> x = scaled(start);
        double value = 0;
        switch (search.optimize(x, value)) {
            case nlopt::STOPVAL_REACHED:
                status = TrainStatus::target_met;
                break;
            case nlopt::MAXEVAL_REACHED:
                status = TrainStatus::iterations_done;
                break;
            case nlopt::MAXTIME_REACHED:
                status = TrainStatus::time_out;
                break;
            default:
                break;
        }
    } catch (const nlopt::roundoff_limited&) {
        status = TrainStatus::stalled;
    } catch (const std::runtime_error&) {  // "generic failure": LD_LBFGS where its line search ends at rounding
        status = TrainStatus::stalled;
    }
    summary.theta = box.project(objective.best_theta);
    summary.evaluations = objective.evaluations;
    monitor.finish(summary, objective.evaluations, loss(summary.theta), status);
    return summary;
}

}  // namespace tissue
