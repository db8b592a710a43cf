#include "springs/equilibrium.h"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include <cmath>

namespace tissue {
namespace {

/// Numbers the free degrees of freedom; -1 marks those of fixed nodes.
std::vector<int> free_numbering(const SpringMesh& mesh, int& count) {
    const int D = mesh.dimension();
    std::vector<int> number(static_cast<std::size_t>(D * mesh.node_count()), 0);
    for (int node : mesh.fixed)
        for (int d = 0; d < D; ++d) number[static_cast<std::size_t>(D * node + d)] = -1;
    count = 0;
    for (int& n : number)
        if (n >= 0) n = count++;
    return number;
}

SparseMatrix free_block(const SparseMatrix& K, const std::vector<int>& number, int count) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(K.nonZeros()));
    for (int column = 0; column < K.outerSize(); ++column)
        for (SparseMatrix::InnerIterator it(K, column); it; ++it) {
            const int i = number[static_cast<std::size_t>(it.row())], j = number[static_cast<std::size_t>(column)];
            if (i >= 0 && j >= 0) entries.emplace_back(i, j, it.value());
        }
    SparseMatrix block(count, count);
    block.setFromTriplets(entries.begin(), entries.end());
    return block;
}

/// The contact's weights on the free degrees of freedom, one column an axis.
Eigen::MatrixXd contact_weights(const SpringMesh& mesh, const SurfacePoint& contact, const std::vector<int>& number,
                                int free_count) {
    const int D = mesh.dimension();
    Eigen::MatrixXd W = Eigen::MatrixXd::Zero(free_count, D);
    for (int end : {0, 1})
        for (int d = 0; d < D; ++d) {
            const int n = number[static_cast<std::size_t>(D * contact.node[end] + d)];
            if (n >= 0) W(n, d) += contact.weight[end];
        }
    return W;
}

using Factor = Eigen::SimplicialLDLT<SparseMatrix>;

/// False when K is not safely positive definite: its smallest pivot is lost in rounding, or negative.
bool factorise(Factor& factor, const SparseMatrix& K) {
    factor.compute(K);
    if (factor.info() != Eigen::Success) return false;
    const Eigen::VectorXd pivots = factor.vectorD();
    return pivots.minCoeff() > 1e-10 * pivots.maxCoeff();
}

}  // namespace

std::optional<Eigen::MatrixXd> contact_sensitivity(const SpringMesh& mesh, const SpringLaw& law,
                                                   const Eigen::VectorXd& theta, const SurfacePoint& contact,
                                                   const NodeField& u) {
    int free_count = 0;
    const std::vector<int> number = free_numbering(mesh, free_count);
    const Eigen::MatrixXd W = contact_weights(mesh, contact, number, free_count);
    Factor factor;
    if (!factorise(factor, free_block(law.stiffness(mesh, theta, u), number, free_count))) return std::nullopt;
    const Eigen::MatrixXd KW = factor.solve(W);
    const Eigen::MatrixXd free_part = (W.transpose() * KW).ldlt().solve(KW.transpose());
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(mesh.dimension(), u.size());
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] >= 0) G.col(static_cast<Eigen::Index>(i)) = free_part.col(number[i]);
    return G;
}

std::optional<Equilibrium> solve_equilibrium(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                                             const SurfacePoint& contact, const Eigen::VectorXd& push_m,
                                             std::string& reason) {
    const int D = mesh.dimension();
    int free_count = 0;
    const std::vector<int> number = free_numbering(mesh, free_count);

    const Eigen::MatrixXd W = contact_weights(mesh, contact, number, free_count);
    if (!(W.colwise().squaredNorm().minCoeff() > 0)) {
        reason = "the contact lies on the fixed edge";
        return std::nullopt;
    }

    Equilibrium state{NodeField::Zero(mesh.node_count(), D), Eigen::VectorXd::Zero(D)};
    const int steps = law.linear_in_displacement() ? 1 : 10;
    constexpr int max_newton = 30;
    constexpr double tolerance = 1e-10;  // largest out-of-balance force over the contact force
    Factor factor;
    for (int step = 1; step <= steps; ++step) {
        const Eigen::VectorXd target = push_m * step / steps;
        bool balanced = false;
        for (int iteration = 0; iteration < max_newton && !balanced; ++iteration) {
            const SparseMatrix K = free_block(law.stiffness(mesh, theta, state.displacement), number, free_count);
            if (!factorise(factor, K)) {
                reason = "the spring mesh has zero-energy modes or is unstable under its supports";
                return std::nullopt;
            }
            const Eigen::VectorXd internal =
                law.force_matrix(mesh, state.displacement) * theta;  // what the nodes are held with now
            Eigen::VectorXd residual(free_count);
            Eigen::VectorXd held = Eigen::VectorXd::Zero(D);
            for (std::size_t i = 0; i < number.size(); ++i)
                if (number[i] >= 0) residual[number[i]] = internal[static_cast<Eigen::Index>(i)];
            for (int end : {0, 1}) held += contact.weight[end] * state.displacement.row(contact.node[end]).transpose();

            // saddle point by its Schur complement: K du - W r = -residual, W' du = target - held
            const Eigen::MatrixXd KW = factor.solve(W);
            const Eigen::VectorXd Kr = factor.solve(residual);
            state.contact_force = (W.transpose() * KW).ldlt().solve(target - held + W.transpose() * Kr);
            const Eigen::VectorXd du = KW * state.contact_force - Kr;
            for (std::size_t i = 0; i < number.size(); ++i)
                if (number[i] >= 0) state.displacement.data()[i] += du[number[i]];
            if (law.linear_in_displacement()) {
                balanced = true;
            } else {
                const Eigen::VectorXd now = law.force_matrix(mesh, state.displacement) * theta;
                double worst = 0;
                for (std::size_t i = 0; i < number.size(); ++i)
                    if (number[i] >= 0)
                        worst = std::max(worst, std::abs(now[static_cast<Eigen::Index>(i)] -
                                                         W.row(number[i]).dot(state.contact_force)));
                balanced = worst <= tolerance * state.contact_force.norm();
                if (!std::isfinite(worst)) break;
            }
        }
        if (!balanced) {
            reason = fmt::format("Newton found no equilibrium at {:.3g} mm", 1e3 * target.norm());
            return std::nullopt;
        }
    }
    return state;
}

std::optional<std::vector<ContactResponse>> contact_responses(const SpringMesh& mesh, const SpringLaw& law,
                                                              const Eigen::VectorXd& theta,
                                                              const std::vector<SurfacePoint>& contacts,
                                                              const std::vector<Eigen::VectorXd>& pushes_m,
                                                              std::string& reason) {
    std::vector<ContactResponse> responses;
    if (!law.linear_in_displacement()) {
        for (std::size_t c = 0; c < contacts.size(); ++c) {
            const std::optional<Equilibrium> state = solve_equilibrium(mesh, law, theta, contacts[c], pushes_m[c], reason);
            if (!state) return std::nullopt;
            const std::optional<Eigen::MatrixXd> G = contact_sensitivity(mesh, law, theta, contacts[c], state->displacement);
            if (!G) {
                reason = "the spring mesh is unstable where it was pushed";
                return std::nullopt;
            }
            responses.push_back({*state, *G});
        }
        return responses;
    }

    const int D = mesh.dimension();
    int free_count = 0;
    const std::vector<int> number = free_numbering(mesh, free_count);
    const NodeField rest = NodeField::Zero(mesh.node_count(), D);
    Factor factor;
    if (!factorise(factor, free_block(law.stiffness(mesh, theta, rest), number, free_count))) {
        reason = "the spring mesh has zero-energy modes or is unstable under its supports";
        return std::nullopt;
    }
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        const Eigen::MatrixXd W = contact_weights(mesh, contacts[c], number, free_count);
        if (!(W.colwise().squaredNorm().minCoeff() > 0)) {
            reason = "the contact lies on the fixed edge";
            return std::nullopt;
        }
        const Eigen::MatrixXd KW = factor.solve(W);
        const auto compliance = (W.transpose() * KW).ldlt();
        const Eigen::MatrixXd G = compliance.solve(KW.transpose());
        ContactResponse r{{rest, compliance.solve(pushes_m[c])}, Eigen::MatrixXd::Zero(D, rest.size())};
        const Eigen::VectorXd u = KW * r.state.contact_force;
        for (std::size_t i = 0; i < number.size(); ++i) {
            if (number[i] < 0) continue;
            r.state.displacement.data()[i] = u[number[i]];
            r.sensitivity.col(static_cast<Eigen::Index>(i)) = G.col(number[i]);
        }
        responses.push_back(std::move(r));
    }
    return responses;
}

}  // namespace tissue
