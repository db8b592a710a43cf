#include "train/bounded_lsq.h"

#include <lapacke.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "train/certificate.h"

namespace tissue {
namespace {

constexpr double armijo = 1e-4;        // the usual part of the slope's promise; Bertsekas 1982 asks for one in (0, 1/2)
constexpr double largest_shift = 1e9;  // of a unit diagonal: steps below rounding

}  // namespace

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
    Eigen::VectorXd residual = target - B * x, g = -(B.transpose() * residual), step(n), change(n), moved(b.size());
    std::vector<int> loose;
    Eigen::MatrixXd block;
    Eigen::VectorXd newton;
    double shift = options.first_shift;
    for (;; ++summary.iterations) {
        summary.kkt_residual = n > 0 ? ((x - g).cwiseMax(lo).cwiseMin(hi) - x).cwiseAbs().maxCoeff() / scale : 0;
        summary.converged = summary.kkt_residual <= options.kkt_tolerance;
        if (summary.converged || summary.iterations >= options.max_iterations) break;

        // the springs that the box does not hold
        loose.clear();
        for (int k = 0; k < n; ++k)
            if (!(x[k] <= lo[k] && g[k] > 0) && !(x[k] >= hi[k] && g[k] < 0)) loose.push_back(k);

        // their Newton step, projected; a shorter one, then a larger shift, until the loss falls by a part of what the
        // slope promises. Far enough up the shift makes it a short step of projected gradients, which always does.
        bool lower = false, whole = false;
        while (!lower && shift < largest_shift) {
            block = H(loose, loose);
            block.diagonal().array() += shift;
            step.setZero();
            newton = -g(loose);
            // LAPACK's Cholesky: several times faster than Eigen's at this size
            const auto m = static_cast<lapack_int>(loose.size());
            if (LAPACKE_dposv(LAPACK_COL_MAJOR, 'U', m, 1, block.data(), std::max(m, 1), newton.data(),
                              std::max(m, 1)) != 0) {
                shift *= 10;
                continue;
            }
            step(loose) = newton;
            for (double part = 1; !lower && part > 0.01; part /= 2) {
                change = (x + part * step).cwiseMax(lo).cwiseMin(hi) - x;
                moved = B * change;
                const double gain = moved.dot(residual) - moved.squaredNorm() / 2;
                lower = gain > 0 && gain >= -armijo * g.dot(change);
                whole = part == 1;
            }
            if (!lower) shift *= 10;
        }
        if (!lower) break;  // at rounding
        if (whole) shift = std::max(shift / 10, options.shift);
        x = (x + change).cwiseMax(lo).cwiseMin(hi);
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
