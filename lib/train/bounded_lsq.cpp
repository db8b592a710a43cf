#include "train/bounded_lsq.h"

#include <lapacke.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "train/certificate.h"

namespace tissue {
namespace {

constexpr double armijo = 1e-4;        // required part of the predicted decrease; Bertsekas 1982: in (0, 1/2)
constexpr double largest_shift = 1e9;  // over the unit diagonal; steps are then below rounding

}  // namespace

BoundedLsqSummary solve_bounded_lsq(const ForceLoss& loss, const Eigen::VectorXd& start, const Box& box,
                                    const BoundedLsqOptions& options) {
    check_problem(loss, start, box, 1);
    const Eigen::VectorXd& b = loss.target();
    const Eigen::Index springs = start.size();

    // unit columns: x = norm theta; zero columns are removed from the problem
    Eigen::VectorXd norm(springs);
    for (Eigen::Index s = 0; s < springs; ++s) norm[s] = loss.matrix().col(s).norm();
    const double zero = options.zero_column * (springs > 0 ? norm.maxCoeff() : 0);
    std::vector<Eigen::Index> kept;
    for (Eigen::Index s = 0; s < springs; ++s)
        if (norm[s] > zero) kept.push_back(s);
    const int n = static_cast<int>(kept.size());

    Eigen::VectorXd left_out = start;  // theta of the removed columns
    SparseMatrix B(loss.matrix().rows(), n);
    Eigen::VectorXd x(n), lo(n), hi(n);
    B.reserve(loss.matrix().nonZeros());
    for (int k = 0; k < n; ++k) {
        const Eigen::Index s = kept[k];
        left_out[s] = 0;
        x[k] = start[s] * norm[s], lo[k] = box.lo[s] * norm[s], hi[k] = box.hi[s] * norm[s];
        B.startVec(k);
        for (SparseMatrix::InnerIterator entry(loss.matrix(), s); entry; ++entry)
            B.insertBack(entry.row(), k) = entry.value() / norm[s];
    }
    B.finalize();
    const Eigen::VectorXd target = b - loss.matrix() * left_out;
    const Eigen::MatrixXd H = SparseMatrix(B.transpose() * B);
    const double scale = b.norm() > 0 ? b.norm() : 1;

    BoundedLsqSummary summary;
    Eigen::VectorXd residual = target - B * x, g = -(B.transpose() * residual), step(n), change(n), moved(b.size());
    std::vector<int> inactive;
    Eigen::MatrixXd block;
    Eigen::VectorXd newton;
    double shift = options.first_shift;
    for (;; ++summary.iterations) {
        summary.kkt_residual = n > 0 ? ((x - g).cwiseMax(lo).cwiseMin(hi) - x).cwiseAbs().maxCoeff() / scale : 0;
        if (summary.kkt_residual <= options.kkt_tolerance) {
            summary.status = LsqStatus::converged;
            break;
        }
        if (summary.iterations >= options.max_iterations) {
            summary.status = LsqStatus::iterations_done;
            break;
        }

        inactive.clear();
        for (int k = 0; k < n; ++k)
            if (!(x[k] <= lo[k] && g[k] > 0) && !(x[k] >= hi[k] && g[k] < 0)) inactive.push_back(k);

        // Projected Newton step of the inactive springs. It is shortened, then the shift is raised, until the loss
        // falls by the Armijo part of the predicted decrease. With a large shift the step is a short projected gradient
        // step, which satisfies the condition except at rounding.
        bool lower = false, whole = false;
        while (!lower && shift < largest_shift) {
            block = H(inactive, inactive);
            block.diagonal().array() += shift;
            step.setZero();
            newton = -g(inactive);
            // LAPACK's Cholesky: several times faster than Eigen's at this size
            const auto m = static_cast<lapack_int>(inactive.size());
            if (LAPACKE_dposv(LAPACK_COL_MAJOR, 'U', m, 1, block.data(), std::max(m, 1), newton.data(),
                              std::max(m, 1)) != 0) {
                shift *= 10;
                continue;
            }
            for (lapack_int k = 0; k < m; ++k) step[inactive[static_cast<std::size_t>(k)]] = newton[k];
            for (double part = 1; !lower && part > 0.01; part /= 2) {
                change = (x + part * step).cwiseMax(lo).cwiseMin(hi) - x;
                moved = B * change;
                const double gain = moved.dot(residual) - moved.squaredNorm() / 2;
                lower = gain > 0 && gain >= -armijo * g.dot(change);
                whole = part == 1;
            }
            if (!lower) shift *= 10;
        }
        if (!lower) {
            summary.status = LsqStatus::stalled;
            break;
        }
        if (whole) shift = std::max(shift / 10, options.shift);
        x = (x + change).cwiseMax(lo).cwiseMin(hi);
        residual = target - B * x;
        g = -(B.transpose() * residual);
    }

    summary.theta = start;
    for (int k = 0; k < n; ++k)
        summary.theta[kept[k]] = std::clamp(x[k] / norm[kept[k]], box.lo[kept[k]], box.hi[kept[k]]);
    summary.residual_norm = loss(summary.theta);
    return summary;
}

TrainStatus train_status(LsqStatus status) {
    switch (status) {
        case LsqStatus::converged:
            return TrainStatus::converged;
        case LsqStatus::stalled:
            return TrainStatus::stalled;
        case LsqStatus::iterations_done:
            break;
    }
    return TrainStatus::iterations_done;
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
    monitor.finish(summary, exact.iterations, exact.residual_norm, train_status(exact.status));
    return summary;
}

}  // namespace tissue
