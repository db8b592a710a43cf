#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>

#include "gsl.h"
#include "mesh/spring_mesh.h"
#include "springs/heuristic.h"
#include "springs/spring_law.h"
#include "train/certificate.h"
#include "train/optimizer.h"

namespace tissue::test {

inline Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, gsl_rng* rng) {
    Eigen::MatrixXd m(rows, columns);
    for (double& entry : m.reshaped()) entry = 2 * gsl_rng_uniform(rng) - 1;
    return m;
}

/// |b - B theta| as a loss, Q = 1.
inline ForceLoss plain_loss(const Eigen::MatrixXd& B, const Eigen::VectorXd& b) {
    return ForceLoss(B.sparseView(), b, Eigen::VectorXd::Ones(b.size()));
}

inline Box make_box(Eigen::Index springs, double lo, double hi) {
    return {Eigen::VectorXd::Constant(springs, lo), Eigen::VectorXd::Constant(springs, hi)};
}

struct Problem {
    ForceLoss loss;
    Box box;
    Eigen::VectorXd start, optimum;
};

/// A problem with full column rank and known optimum: a third of the springs at lo = 1 with positive gradient, a third
/// at hi = 3 with negative gradient, the rest inside with zero gradient. The gradient g gives the residual r = -B
/// (B'B)^-1 g, and b = B theta + r.
inline Problem problem_with_active_bounds(Eigen::Index rows, Eigen::Index springs, unsigned long seed) {
    const tissue::Rng rng = tissue::seeded_rng(seed);
    const Eigen::MatrixXd B = random_matrix(rows, springs, rng.get());
    Eigen::VectorXd optimum(springs), gradient(springs);
    for (Eigen::Index s = 0; s < springs; ++s) {
        optimum[s] = s % 3 == 0 ? 1 : s % 3 == 1 ? 3 : 1.5 + gsl_rng_uniform(rng.get());
        gradient[s] = (s % 3 == 0 ? 1 : s % 3 == 1 ? -1 : 0) * (0.1 + gsl_rng_uniform(rng.get()));
    }
    const Eigen::VectorXd residual = -B * (B.transpose() * B).ldlt().solve(gradient);
    return {plain_loss(B, B * optimum + residual), make_box(springs, 1, 3), Eigen::VectorXd::Constant(springs, 2),
            optimum};
}

/// A lattice with random displacements and the forces of a known spring set. If `optimum` is in the box its residual is
/// zero; where springs outnumber the rows, other sets have zero residual too. start: all springs 1 N/m, box 0.05 to 40.
inline Problem lattice_problem(const std::string& topology, const std::string& law, int cells, unsigned long seed,
                               double softest = 0.3) {
    const tissue::Rng rng = tissue::seeded_rng(seed);
    const SpringMesh mesh = make_lattice(topology, cells, cells, 0.1, 0.1);
    NodeField u = 0.003 * random_matrix(mesh.node_count(), 2, rng.get());
    for (int node : mesh.fixed) u.row(node).setZero();
    const SparseMatrix A = make_spring_law(law)->force_matrix(mesh, u);
    Eigen::VectorXd truth(mesh.spring_count());
    for (double& theta : truth) theta = softest + 2 * gsl_rng_uniform(rng.get());
    return {ForceLoss(A, A * truth, Eigen::VectorXd::Constant(u.size(), 0.9)), make_box(truth.size(), 0.05, 40),
            Eigen::VectorXd::Ones(truth.size()), truth};
}

/// BoundedLsqSummary::kkt_residual at any theta [N/m] (S), by its definition.
inline double kkt_residual(const ForceLoss& loss, const Eigen::VectorXd& theta, const Box& box) {
    const Eigen::VectorXd gradient = loss_gradient(loss, theta);
    double largest = 0;
    for (Eigen::Index s = 0; s < theta.size(); ++s) {
        const double norm = loss.matrix().col(s).norm();
        if (norm > 0) largest = std::max(largest, norm * std::abs(std::clamp(theta[s] - gradient[s] / (norm * norm), box.lo[s], box.hi[s]) - theta[s]));
    }
    return largest / loss.target().norm();
}

}  // namespace tissue::test
