#pragma once

#include <optional>
#include <string>

#include "springs/spring_law.h"

namespace tissue {

/// Outcome of the search for an equilibrium. f: residual of the springs' forces at free nodes after subtraction of the
/// contact force [N]. R: largest force at any node, supports and contact included [N]. p: pivots of the tangent on all
/// displacements that leave the contact where it is.
enum class EquilibriumStatus {
    balanced,           ///< max |f| <= 1e-10 R, and min p > 1e-10 max |p|
    contact_fixed,      ///< the contact has weights on fixed nodes only
    zero_energy_modes,  ///< at rest min |p| <= 1e-10 max |p|: the mesh has zero-energy modes
    unstable_at_rest,   ///< at rest some p < -1e-10 max |p|
    unstable,           ///< max |f| <= 1e-10 R, but min p <= 1e-10 max |p|: not a minimum of the energy
    /// of an energy model: a minimum with an inverted cell, area or volume ratio <= 0 (SolverStatus)
    inverted,
    not_converged,      ///< max |f| > 1e-10 R after 100 iterations of a load step, or f not finite
    no_contact          ///< in space: the lattice has no tissue near the contact
};

/// Message of one line; empty for `balanced`.
std::string reason_of(EquilibriumStatus status);

/// Equilibrium of a spring mesh with a prescribed displacement of one contact; all other free nodes are in equilibrium.
struct Equilibrium {
    NodeField displacement;         ///< u [m] (N x D)
    /// multiplier of the constraint [N] (D): force of the indenter on the mesh
    Eigen::VectorXd contact_force;
    /// displacement and force are valid only if it is `balanced`
    EquilibriumStatus status;

    explicit operator bool() const { return status == EquilibriumStatus::balanced; }
};

/// Prescribes the contact, weight(0) u_i + weight(1) u_j = push_m [m] (D), and u = 0 at fixed nodes, and finds a
/// minimum of the springs' energy. theta: stiffnesses [N/m] (S). The mesh need not be stable without the contact
/// constraint. With it, it must be stable at rest and at the end; otherwise the status says why there is no result. No
/// pseudo-inverse is used.
/// A law that is linear in displacement takes one solve. Others take ten load steps from rest with Newton's method.
/// Where the tangent is not positive definite, its diagonal is raised until it is. The line search of each step bounds
/// the energy's slope at the step's end.
/// Source: design of the indentation error; the multiplier is the force that a hand feels.
Equilibrium solve_equilibrium(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                              const SurfacePoint& contact, const Eigen::VectorXd& push_m);

/// Sensitivity G (D x N*D) of the contact force: a nodal force residual e = A(u) theta - f [N] at a state u with
/// prescribed contact changes the contact's reaction by G e [N]. It is exact for a law that is linear in displacement,
/// otherwise of first order. Columns of fixed nodes are zero. Empty where the mesh is not stable with prescribed
/// contact, or where the contact has weights on fixed nodes only.
std::optional<Eigen::MatrixXd> contact_sensitivity(const SpringMesh& mesh, const SpringLaw& law,
                                                   const Eigen::VectorXd& theta, const SurfacePoint& contact,
                                                   const NodeField& u);

}  // namespace tissue
