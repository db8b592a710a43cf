#pragma once

#include <optional>
#include <string>

#include "springs/spring_law.h"

namespace tissue {

/// Rest of a spring mesh whose contact has been pushed, everything else free to find its place.
struct Equilibrium {
    NodeField displacement;         ///< u [m] (N x D)
    Eigen::VectorXd contact_force;  ///< multiplier of the constraint [N] (D): the force of the indenter on the mesh
};

/// Holds the contact: weight(0) u_i + weight(1) u_j = push [m] (D), the mesh's fixed nodes at rest, and solves for the
/// rest. Returns nothing, and says why in `reason`, when the free mesh has zero-energy modes or is unstable, or when
/// Newton (laws that turn with the tissue) finds no equilibrium: there is no answer, and no pseudo-inverse.
/// Source: design of the closed-loop error; the multiplier is the force a hand feels.
std::optional<Equilibrium> solve_equilibrium(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                                             const SurfacePoint& contact, const Eigen::VectorXd& push_m,
                                             std::string& reason);

/// G (D x N*D): a nodal force residual e = A(u) theta - f [N] at a state u that holds the contact where it was pushed
/// changes the contact's reaction by G e [N]; exactly so for a law that is linear in displacement, to first order
/// otherwise. Zero for fixed nodes. Nothing when the mesh has zero-energy modes or is unstable there.
std::optional<Eigen::MatrixXd> contact_sensitivity(const SpringMesh& mesh, const SpringLaw& law,
                                                   const Eigen::VectorXd& theta, const SurfacePoint& contact,
                                                   const NodeField& u);

/// An equilibrium and its compliance.
struct ContactResponse {
    Equilibrium state;
    Eigen::MatrixXd sensitivity;  ///< G of contact_sensitivity at that state (D x N*D)
};

/// solve_equilibrium and contact_sensitivity for many contacts of one mesh, push by push; a law that is linear in
/// displacement is factorised once for all. Nothing, and why, as soon as one has no answer.
std::optional<std::vector<ContactResponse>> contact_responses(const SpringMesh& mesh, const SpringLaw& law,
                                                              const Eigen::VectorXd& theta,
                                                              const std::vector<SurfacePoint>& contacts,
                                                              const std::vector<Eigen::VectorXd>& pushes_m,
                                                              std::string& reason);

}  // namespace tissue
