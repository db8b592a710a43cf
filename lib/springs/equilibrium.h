#pragma once

#include <optional>
#include <string>

#include "springs/spring_law.h"

namespace tissue {

/// Why there is, or is not, an equilibrium. f is what is left of the springs' forces at free nodes when the contact's is
/// taken off [N], R the largest force at any node, supports and contact included [N], p the pivots of the tangent on all
/// displacements that leave the contact where it is.
enum class EquilibriumStatus {
    balanced,           ///< largest |f| <= 1e-10 R, and smallest p > 1e-10 of the largest
    contact_fixed,      ///< the contact weighs on fixed nodes alone
    zero_energy_modes,  ///< at rest smallest |p| <= 1e-10 of the largest: part of the mesh moves for nothing
    unstable_at_rest,   ///< at rest a p < -1e-10 of the largest
    unstable,           ///< largest |f| <= 1e-10 R, but smallest p <= 1e-10 of the largest: no minimum of the energy
    inside_out,         ///< a minimum, but of a law whose smallest area ratio is <= 0: no tissue (PressStatus)
    not_converged,      ///< largest |f| > 1e-10 R after 100 iterations of a load step, or not finite
    no_contact          ///< in space: the lattice has no tissue near the contact
};

/// One line for people; empty for `balanced`.
std::string reason_of(EquilibriumStatus status);

/// Rest of a spring mesh whose contact has been pushed, everything else free to find its place.
struct Equilibrium {
    NodeField displacement;         ///< u [m] (N x D)
    Eigen::VectorXd contact_force;  ///< multiplier of the constraint [N] (D): the force of the indenter on the mesh
    EquilibriumStatus status;       ///< u and the force mean something when it is `balanced`, and only then

    explicit operator bool() const { return status == EquilibriumStatus::balanced; }
};

/// Holds the contact: weight(0) u_i + weight(1) u_j = push [m] (D), the mesh's fixed nodes at rest, and finds a minimum
/// of the springs' energy over the rest. The mesh need not be stable without its contact; it must be with it, at rest
/// and where it ends, or there is no answer, and no pseudo-inverse.
/// A law that is linear in displacement takes one solve. Others are pushed in ten load steps from rest; in each Newton's
/// method goes down in energy: where the tangent is not positive definite its diagonal is raised until it is, and a step
/// ends before the force along it has turned round.
/// Source: design of the closed-loop error; the multiplier is the force a hand feels.
Equilibrium solve_equilibrium(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                              const SurfacePoint& contact, const Eigen::VectorXd& push_m);

/// G (D x N*D): a nodal force residual e = A(u) theta - f [N] at a state u that holds the contact where it was pushed
/// changes the contact's reaction by G e [N]; exactly so for a law that is linear in displacement, to first order
/// otherwise. Zero for fixed nodes. Nothing where the mesh is not stable though its contact is held, or the contact lies
/// on fixed nodes.
std::optional<Eigen::MatrixXd> contact_sensitivity(const SpringMesh& mesh, const SpringLaw& law,
                                                   const Eigen::VectorXd& theta, const SurfacePoint& contact,
                                                   const NodeField& u);

}  // namespace tissue
