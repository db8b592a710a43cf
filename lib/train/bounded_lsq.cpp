#include "train/bounded_lsq.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "train/certificate.h"

namespace tissue {

BoundedLsqSummary solve_bounded_lsq(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box,
                                    const BoundedLsqOptions& options) {
    check_problem(loss, start, box, 1);
    const Eigen::VectorXd& b = loss.target();
    const Eigen::Index springs = start.size();

    // unit columns: x = norm theta; a silent one is taken out of the problem
    Eigen::VectorXd norm(springs);
    for (Eigen::Index s = 0; s < springs; ++s) norm[s] = loss.matrix().col(s).norm();
    const double silent = options.silent_column * (springs > 0 ? norm.maxCoeff() : 0);
    std::vector<Eigen::Index> heard;
    for (Eigen::Index s = 0; s < springs; ++s)
        if (norm[s] > silent) heard.push_back(s);
    const int n = static_cast<int>(heard.size());

    Eigen::VectorXd quiet = start;  // what the silent springs add to the force
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(loss.matrix().rows(), n);
    SparseMatrix B(loss.matrix().rows(), n);
    Eigen::VectorXd x(n), lo(n), hi(n);
    B.reserve(loss.matrix().nonZeros());
    for (int k = 0; k < n; ++k) {
        const Eigen::Index s = heard[k];
        quiet[s] = 0;
        x[k] = start[s] * norm[s], lo[k] = box.lo[s] * norm[s], hi[k] = box.hi[s] * norm[s];
        B.startVec(k);
        for (SparseMatrix::InnerIterator entry(loss.matrix(), s); entry; ++entry)
            B.insertBack(entry.row(), k) = entry.value() / norm[s];
    }
    B.finalize();
    const Eigen::VectorXd target = b - loss.matrix() * quiet;
    const Eigen::MatrixXd H = SparseMatrix(B.transpose() * B);
    const double scale = b.norm() > 0 ? b.norm() : 1;

    BoundedLsqSummary summary;
    Eigen::VectorXd residual = target - B * x, g = -(B.transpose() * residual), trial(n), step(n), moved(b.size());
    std::vector<int> free;
    Eigen::MatrixXd block;
    for (;; ++summary.iterations) {
        summary.kkt_residual = n > 0 ? ((x - g).cwiseMax(lo).cwiseMin(hi) - x).cwiseAbs().maxCoeff() / scale : 0;
        summary.converged = summary.kkt_residual <= options.kkt_tolerance;
        if (summary.converged || summary.iterations >= options.max_iterations) break;

        // Newton on the springs that the box does not hold
        free.clear();
        for (int k = 0; k < n; ++k)
            if (!(x[k] <= lo[k] && g[k] > 0) && !(x[k] >= hi[k] && g[k] < 0)) free.push_back(k);
        block = H(free, free);
        block.diagonal().array() += options.shift;
        step.setZero();
        step(free) = -Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(block).solve(g(free).eval());

        // along the projected path, halving until the loss falls by a part of what the slope promises
        double alpha = 1, gain = 0;
        for (int halvings = 0; halvings < 60; ++halvings, alpha /= 2) {
            trial = (x + alpha * step).cwiseMax(lo).cwiseMin(hi);
            trial -= x;
            moved = B * trial;
            gain = moved.dot(residual) - moved.squaredNorm() / 2;
            if (gain > 0 && gain >= -1e-4 * g.dot(trial)) break;
        }
        if (!(gain > 0)) break;  // at rounding
        x = (x + trial).cwiseMax(lo).cwiseMin(hi);
        residual = target - B * x;
        g = -(B.transpose() * residual);
    }

    summary.theta = start;
    for (int k = 0; k < n; ++k)
        summary.theta[heard[k]] = std::clamp(x[k] / norm[heard[k]], box.lo[heard[k]], box.hi[heard[k]]);
    summary.residual_norm = loss(summary.theta);
    return summary;
}

TrainSummary ExactOptimizer::minimise(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box,
                                      double unit_N_m, const StopCriteria& stop, gsl_rng*) const {
    check_problem(loss, start, box, unit_N_m);
    TrainMonitor monitor(stop, loss.scale());
    monitor.record(0, loss(start));
    const BoundedLsqSummary exact = solve_bounded_lsq(loss, start, box);
    TrainSummary summary;
    summary.theta = exact.theta;
    summary.evaluations = exact.iterations;
    monitor.finish(summary, exact.iterations, exact.residual_norm,
                   exact.converged ? TrainStatus::converged : TrainStatus::iterations_done);
    return summary;
}

}  // namespace tissue
