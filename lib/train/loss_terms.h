#pragma once

#include <optional>
#include <vector>

#include "cases/load_path.h"
#include "springs/spring_law.h"
#include "train/force_loss.h"

namespace tissue {

/// Parts of the objectives (objective.h).

/// Displacement and nodal forces that the springs should have at one load case, and the weight of each node.
struct Target {
    NodeField displacement;       ///< u [m] (N x D)
    NodeField force;              ///< f [N] (N x D)
    NodeField weight;             ///< diagonal of Q (N x D)
};

/// Target of the paper: u and f of the FE reference; every node has its weight, fixed nodes too. node_weight (N).
Target force_target(const LoadCase& load, const Eigen::VectorXd& node_weight);

/// Target with the contact force as the spring mesh has it: the whole force of the indenter acts at the two ends of the
/// contact's boundary segment, by their weights. The displacements of these ends are changed so that the contact has
/// the prescribed tool displacement. Fixed nodes have weight 0. node_weight (N).
Target contact_target(const SpringMesh& mesh, const LoadCase& load, const SurfacePoint& contact,
                      const Eigen::VectorXd& node_weight);

/// (9) for a target. law: spring force (10).
ForceLoss loss_of(const SpringMesh& mesh, const SpringLaw& law, const Target& target);

/// L^2 + ridge c |theta - theta0|^2. c is the mean squared column of the loss's matrix, so that ridge has no unit.
/// theta0 [N/m] (S).
ForceLoss with_ridge(const ForceLoss& loss, double ridge, const Eigen::VectorXd& theta0);

/// L^2 + factor^2 |G (A theta - f)|^2: adds the error of the contact's reaction. sensitivity: G (D x N*D),
/// contact_sensitivity of a fixed spring set. The residual stays linear in theta, so certificates hold.
ForceLoss with_reaction(const ForceLoss& loss, const SpringMesh& mesh, const SpringLaw& law, const Target& target,
                        const Eigen::MatrixXd& sensitivity, double factor);

/// Sum of (L_i / |target_i|)^2 over the losses with a target other than 0, as one loss: the triangular system with the
/// same minimum, from the Cholesky factor of the sum of normal matrices. A ridge of 1e-12 of the mean diagonal makes
/// the minimum unique. Absent when no loss has a target, or the factorisation fails.
std::optional<ForceLoss> joint_loss(const std::vector<ForceLoss>& losses);

}  // namespace tissue
