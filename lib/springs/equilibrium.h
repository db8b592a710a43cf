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

}  // namespace tissue
