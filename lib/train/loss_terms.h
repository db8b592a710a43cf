#pragma once

#include <optional>
#include <vector>

#include "cases/load_path.h"
#include "springs/spring_law.h"
#include "train/force_loss.h"

namespace tissue {

/// The parts that objectives (objective.h) are made of.

/// What the springs are asked to hold at one load case, and how much each node counts.
struct Target {
    NodeField displacement;       ///< u [m] (N x D)
    NodeField force;              ///< f [N] (N x D)
    NodeField weight;             ///< diagonal of Q (N x D)
};

/// The paper's: u and f where FE has them, every node counts by its weight (N), supports too.
Target force_target(const LoadCase& load, const Eigen::VectorXd& node_weight);

/// The force a hand feels: the whole force of the indenter acts at the contact, on the ends of its boundary segment by
/// their weights, because that is how the spring mesh will be held; those ends are moved so that the contact stands
/// exactly where it was pushed. Supports carry what they must and do not count.
Target contact_target(const SpringMesh& mesh, const LoadCase& load, const SurfacePoint& contact,
                      const Eigen::VectorXd& node_weight);

ForceLoss loss_of(const SpringMesh& mesh, const SpringLaw& law, const Target& target);

/// L^2 + ridge c |theta - theta0|^2, c the mean squared column of the loss's matrix, so that ridge is a pure number.
ForceLoss with_ridge(const ForceLoss& loss, double ridge, const Eigen::VectorXd& theta0);

/// L^2 + factor^2 |G (A theta - f)|^2: the error of the contact's reaction itself, seen through a fixed compliance G
/// (contact_sensitivity of some spring set). Still linear in theta, so certificates hold for it.
ForceLoss with_reaction(const ForceLoss& loss, const SpringMesh& mesh, const SpringLaw& law, const Target& target,
                        const Eigen::MatrixXd& sensitivity, double factor);

/// Several losses as one: sum of (L_i / |target_i|)^2 over those that have a target, as the triangular system with the same
/// minimum, by the Cholesky factor of the sum of their normal matrices. Where several spring sets are equally good, a
/// ridge of 1e-12 of the mean diagonal chooses. Nothing when no loss has a target, or the factor does not exist.
std::optional<ForceLoss> joint_loss(const std::vector<ForceLoss>& losses);

}  // namespace tissue
