#include "springs/equilibrium.h"

#include <algorithm>
#include <cmath>

#include "springs/held_tangent.h"

namespace tissue {
namespace {

constexpr double tolerance = 1e-10;  // the 1e-10 of EquilibriumStatus
constexpr int load_steps = 10, max_newton = 100;

/// The contact's weights on the free degrees of freedom (F x D), one column per axis.
Eigen::MatrixXd contact_weights(const SpringMesh& mesh, const SurfacePoint& contact, const FreeNumbering& free) {
    const int D = mesh.dimension();
    Eigen::MatrixXd W = Eigen::MatrixXd::Zero(free.count, D);
    for (int end : {0, 1})
        for (int d = 0; d < D; ++d) {
            const int n = free.number[static_cast<std::size_t>(D * contact.node[end] + d)];
            if (n >= 0) W(n, d) += contact.weight[end];
        }
    return W;
}

bool weighs_on_free_nodes(const Eigen::MatrixXd& W) {
    return W.colwise().squaredNorm().minCoeff() > 0;
}

EquilibriumStatus at_rest(Definiteness d) {
    if (d == Definiteness::positive) return EquilibriumStatus::balanced;
    return d == Definiteness::flat ? EquilibriumStatus::zero_energy_modes : EquilibriumStatus::unstable_at_rest;
}

/// A mesh, spring law and stiffnesses with one contact prescribed.
struct HeldMesh {
    const SpringMesh& mesh;
    const SpringLaw& law;
    const Eigen::VectorXd& theta;
    const SurfacePoint& contact;
    FreeNumbering free;
    Eigen::MatrixXd W;

    FreeTangent tangent(const NodeField& u) const { return {law.stiffness(mesh, theta, u), free}; }

    Eigen::VectorXd nodal_forces(const NodeField& u) const { return law.force_matrix(mesh, u) * theta; }
    Eigen::VectorXd forces(const NodeField& u) const { return free.gather(nodal_forces(u)); }

    Eigen::VectorXd held_at(const NodeField& u) const {
        return contact.weight[0] * u.row(contact.node[0]).transpose() +
               contact.weight[1] * u.row(contact.node[1]).transpose();
    }

    /// Contact force r that minimises the residual of the given forces.
    Eigen::VectorXd contact_force(const Eigen::VectorXd& forces_N) const {
        return (W.transpose() * forces_N).cwiseQuotient(W.colwise().squaredNorm().transpose());
    }
};

/// A step towards the minimum: Newton's method where the tangent is positive definite, otherwise with a shifted tangent
/// that is.
HeldTangent::Step downhill(const HeldMesh& held, const FreeTangent& tangent, const Eigen::VectorXd& forces_N,
                           const Eigen::VectorXd& gap) {
    double shift = 0;
    for (int tries = 0; tries < 40; ++tries) {
        const HeldTangent t(tangent, held.W, shift);
        if (t.definiteness() == Definiteness::positive) return t.solve(forces_N, gap);
        shift = shift > 0 ? 2 * shift : 1e-4 * tangent.K.diagonal().cwiseAbs().maxCoeff();
    }
    // not finite: the caller stops
    return {Eigen::VectorXd::Constant(forces_N.size(), std::nan("")), gap};
}

/// Halves the step du until the slope of the energy at its end is at most half of that at its start, in magnitude; then
/// adds it to u. du leaves the contact where it is. The contact force does no work on du, but is subtracted to avoid
/// rounding errors.
void line_search(const HeldMesh& held, const Eigen::VectorXd& du, const Eigen::VectorXd& forces_N, NodeField& u) {
    const Eigen::VectorXd taken_up = held.W * held.contact_force(forces_N);
    const double slope = (forces_N - taken_up).dot(du);  // directional derivative of the energy, negative
    double length = 1;
    for (int halvings = 0; halvings < 30; ++halvings, length /= 2) {
        NodeField there = u;
        held.free.add(length * du, there);
        if ((held.forces(there) - taken_up).dot(du) <= 0.5 * std::abs(slope)) break;
    }
    held.free.add(length * du, u);
}

/// From the equilibrium at one load to that at the next; false if the iteration does not converge.
bool push_to(const HeldMesh& held, const Eigen::VectorXd& target, Equilibrium& state) {
    Eigen::VectorXd f = held.forces(state.displacement);
    for (int iteration = 0; iteration < max_newton; ++iteration) {
        const Eigen::VectorXd gap = iteration == 0 ? Eigen::VectorXd(target - held.held_at(state.displacement))
                                                   : Eigen::VectorXd::Zero(target.size());
        const HeldTangent::Step step = downhill(held, held.tangent(state.displacement), f, gap);
        if (!step.du.allFinite()) return false;
        // the first step moves the contact all the way to its target
        if (iteration == 0)
            held.free.add(step.du, state.displacement);
        else
            line_search(held, step.du, f, state.displacement);
        const Eigen::VectorXd nodal = held.nodal_forces(state.displacement);
        f = held.free.gather(nodal);
        state.contact_force = held.contact_force(f);
        const double worst = (f - held.W * state.contact_force).cwiseAbs().maxCoeff();
        if (!std::isfinite(worst)) return false;
        if (worst <= tolerance * std::max(state.contact_force.norm(), nodal.cwiseAbs().maxCoeff())) return true;
    }
    return false;
}

}  // namespace

std::string reason_of(EquilibriumStatus status) {
    switch (status) {
        case EquilibriumStatus::balanced: return "";
        case EquilibriumStatus::contact_fixed: return "the contact is on the fixed edge";
        case EquilibriumStatus::no_contact: return "the lattice has no tissue near the contact";
        case EquilibriumStatus::zero_energy_modes: return "the spring mesh has zero-energy modes, with the contact fixed";
        case EquilibriumStatus::unstable_at_rest: return "the spring mesh is unstable at rest, with the contact fixed";
        case EquilibriumStatus::unstable: return "the spring mesh is unstable under the indentation, with the contact fixed";
        case EquilibriumStatus::inverted: return "a cell of the tissue is inverted";
        case EquilibriumStatus::not_converged: return "Newton's method found no equilibrium";
    }
    return "";
}

Equilibrium solve_equilibrium(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                              const SurfacePoint& contact, const Eigen::VectorXd& push_m) {
    const int D = mesh.dimension();
    Equilibrium state{NodeField::Zero(mesh.node_count(), D), Eigen::VectorXd::Zero(D), EquilibriumStatus::contact_fixed};
    HeldMesh held{mesh, law, theta, contact, FreeNumbering(mesh), {}};
    held.W = contact_weights(mesh, contact, held.free);
    if (!weighs_on_free_nodes(held.W)) return state;

    const FreeTangent start = held.tangent(state.displacement);
    const HeldTangent tangent(start, held.W);
    state.status = at_rest(tangent.definiteness());
    if (!state) return state;
    if (law.linear_in_displacement()) {
        const HeldTangent::Step step = tangent.solve(Eigen::VectorXd::Zero(held.free.count), push_m);
        held.free.add(step.du, state.displacement);
        state.contact_force = step.force;
        return state;
    }
    for (int step = 1; step <= load_steps; ++step)
        if (!push_to(held, push_m * step / load_steps, state)) {
            state.status = EquilibriumStatus::not_converged;
            return state;
        }
    if (HeldTangent(held.tangent(state.displacement), held.W).definiteness() != Definiteness::positive)
        state.status = EquilibriumStatus::unstable;
    return state;
}

std::optional<Eigen::MatrixXd> contact_sensitivity(const SpringMesh& mesh, const SpringLaw& law,
                                                   const Eigen::VectorXd& theta, const SurfacePoint& contact,
                                                   const NodeField& u) {
    const FreeNumbering free(mesh);
    const Eigen::MatrixXd W = contact_weights(mesh, contact, free);
    if (!weighs_on_free_nodes(W)) return std::nullopt;
    const FreeTangent tangent(law.stiffness(mesh, theta, u), free);
    const HeldTangent held(tangent, W);
    if (held.definiteness() != Definiteness::positive) return std::nullopt;
    return free.scatter_columns(held.sensitivity());
}

}  // namespace tissue
