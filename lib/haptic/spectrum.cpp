#include "haptic/spectrum.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace tissue {
namespace {

/// y = M^-1/2 K M^-1/2 x on the free nodes; x vanishes on the others.
class ScaledStiffness {
   public:
    ScaledStiffness(const RealtimeMesh& mesh, const Eigen::VectorXd& theta)
        : mesh_(mesh), theta_(theta), root_(mesh.inverse_mass().cwiseSqrt()), force_(mesh.node_count(), mesh.dimension()) {}

    NodeColumns operator()(const NodeColumns& x) {
        NodeColumns y = root_.asDiagonal() * x;
        if (mesh_.law().linear_in_displacement()) {  // only in the plane, where rows are nodes
            mesh_.force(theta_, y, force_);
        } else {  // upper bound: each spring as an isotropic one
            force_.setZero();
            for (int slot : mesh_.slot_of_spring()) {
                const Eigen::Vector2i ends = mesh_.nodes_of_slot(slot);
                const Eigen::RowVectorXd pull = theta_[slot] * (y.row(ends[0]) - y.row(ends[1]));
                force_.row(ends[0]) += pull;
                force_.row(ends[1]) -= pull;
            }
        }
        return root_.asDiagonal() * force_;
    }

   private:
    const RealtimeMesh& mesh_;
    const Eigen::VectorXd& theta_;
    Eigen::VectorXd root_;
    NodeColumns force_;
};

/// The same for a tangent stiffness.
class ScaledTangent {
   public:
    ScaledTangent(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent)
        : tangent_(tangent), root_(mesh.inverse_mass().cwiseSqrt()) {}

    NodeColumns operator()(const NodeColumns& x) const {
        const NodeField y = root_.asDiagonal() * x;
        NodeField f(x.rows(), x.cols());
        Eigen::Map<Eigen::VectorXd>(f.data(), f.size()) = tangent_ * Eigen::Map<const Eigen::VectorXd>(y.data(), y.size());
        return root_.asDiagonal() * f;
    }

   private:
    const Eigen::SparseMatrix<double>& tangent_;
    Eigen::VectorXd root_;
};

/// A start vector without symmetry, the same in every run.
NodeColumns scattered_start(const RealtimeMesh& mesh) {
    NodeColumns x(mesh.node_count(), mesh.dimension());
    for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = std::sin(12.9898 * static_cast<double>(i + 1) + 1.0);
    for (int node = 0; node < mesh.node_count(); ++node)
        if (mesh.fixed(node)) x.row(node).setZero();
    return x;
}

/// Largest value of Lanczos' method plus its residual.
template <class Apply>
double largest_of(const RealtimeMesh& mesh, Apply apply) {
    constexpr int steps = 30;
    NodeColumns q = scattered_start(mesh), before = NodeColumns::Zero(mesh.node_count(), mesh.dimension());
    if (!(q.norm() > 0)) return 0;
    q /= q.norm();
    std::vector<double> alpha, beta;
    for (int step = 0; step < steps; ++step) {
        NodeColumns w = apply(q);
        alpha.push_back(w.cwiseProduct(q).sum());
        w -= alpha.back() * q;
        if (step > 0) w -= beta.back() * before;
        beta.push_back(w.norm());
        if (!(beta.back() > 1e-12 * alpha.front())) break;
        before = q;
        q = w / beta.back();
    }
    const auto n = static_cast<Eigen::Index>(alpha.size());
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
        T(i, i) = alpha[static_cast<std::size_t>(i)];
        if (i + 1 < n) T(i, i + 1) = T(i + 1, i) = beta[static_cast<std::size_t>(i)];
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(T);
    return solver.eigenvalues()[n - 1] + std::abs(beta.back() * solver.eigenvectors()(n - 1, n - 1));
}

/// Smallest eigenvalue by inverse iteration of a few vectors at once, since the slowest modes of a square block come in
/// pairs of equal frequency. solve(x): replaces x by K^-1 x. mass, x: of the free degrees of freedom.
template <class Solve>
double smallest_of(const Eigen::VectorXd& mass, const Solve& solve) {
    const Eigen::Index n = mass.size(), few = std::min<Eigen::Index>(4, n);
    Eigen::MatrixXd X(n, few);
    for (Eigen::Index k = 0; k < few; ++k)
        for (Eigen::Index i = 0; i < n; ++i) X(i, k) = 1 + 0.5 * std::sin(12.9898 * static_cast<double>(i + 1) * static_cast<double>(k + 1)) - (k > 0 && i % (k + 1) == 0 ? 2 : 0);
    double eigenvalue = 0;
    for (int step = 0; step < 200; ++step) {
        Eigen::MatrixXd MX = mass.asDiagonal() * X;
        const Eigen::LLT<Eigen::MatrixXd> own(X.transpose() * MX);
        if (own.info() != Eigen::Success) return eigenvalue;
        X = own.matrixU().solve<Eigen::OnTheRight>(X).eval();
        MX = mass.asDiagonal() * X;
        Eigen::MatrixXd Y = MX;
        for (Eigen::Index k = 0; k < few; ++k) {
            Eigen::VectorXd y = Y.col(k);
            solve(y);
            Y.col(k) = y;
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> inverse(MX.transpose() * Y);
        const double now = 1 / inverse.eigenvalues()[few - 1];
        X = Y * inverse.eigenvectors();
        if (std::abs(now - eigenvalue) < 1e-9 * now) return now;
        eigenvalue = now;
    }
    return eigenvalue;
}

}  // namespace

double largest_eigenvalue(const RealtimeMesh& mesh, const Eigen::VectorXd& theta) {
    return largest_of(mesh, ScaledStiffness(mesh, theta));
}

double largest_eigenvalue(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent) {
    return largest_of(mesh, ScaledTangent(mesh, tangent));
}

SlowestMode::SlowestMode(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent) {
    const int D = mesh.dimension();
    std::vector<int> number(static_cast<std::size_t>(tangent.rows()), -1);
    for (int node = 0; node < mesh.node_count(); ++node)
        for (int axis = 0; axis < D && !mesh.fixed(node); ++axis) {
            number[static_cast<std::size_t>(D * node + axis)] = static_cast<int>(node_.size());
            node_.push_back(node);
        }
    std::vector<Eigen::Triplet<double>> entries;
    for (int column = 0; column < tangent.outerSize(); ++column)
        for (Eigen::SparseMatrix<double>::InnerIterator it(tangent, column); it; ++it) {
            const int i = number[static_cast<std::size_t>(it.row())], j = number[static_cast<std::size_t>(column)];
            if (i >= 0 && j >= 0) entries.emplace_back(i, j, it.value());
        }
    const auto n = static_cast<Eigen::Index>(node_.size());
    Eigen::SparseMatrix<double> K(n, n);
    K.setFromTriplets(entries.begin(), entries.end());
    factor_.compute(K);
}

double SlowestMode::of(const Eigen::VectorXd& node_mass_kg) const {
    if (node_.empty() || factor_.info() != Eigen::Success || !(factor_.vectorD().minCoeff() > 0)) return 0;
    return smallest_of(node_mass_kg(node_), [&](Eigen::VectorXd& x) { x = factor_.solve(x).eval(); });
}

double smallest_eigenvalue(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent) { return SlowestMode(mesh, tangent).of(mesh.mass()); }

double smallest_eigenvalue(const RealtimeMesh& mesh, const Eigen::VectorXd& theta) {
    // in space the band of K would be wide
    if (mesh.dimension() == 3) return smallest_eigenvalue(mesh, mesh.stiffness_at_rest(theta));
    const FreeNumbering numbering(mesh);
    if (BandCholesky::bytes(numbering.order, numbering.half_bandwidth) > 1e9) return 0;
    BandCholesky K(numbering.order, numbering.half_bandwidth);
    add_stiffness(mesh, numbering, theta, NodeColumns::Zero(mesh.node_count(), 2), 1, false, K);
    if (numbering.order == 0 || !K.factor()) return 0;

    const int components = numbering.per_node;
    Eigen::VectorXd mass(numbering.order);
    for (int node = 0; node < mesh.node_count(); ++node) {
        const int n = numbering.number[static_cast<std::size_t>(node)];
        for (int c = 0; n >= 0 && c < components; ++c) mass[components * n + c] = mesh.mass()[node];
    }
    return smallest_of(mass, [&](Eigen::VectorXd& x) { K.solve(x.data()); });
}

}  // namespace tissue
