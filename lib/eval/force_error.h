#pragma once

#include <vector>

#include "cases/load_path.h"
#include "eval/statistics.h"
#include "springs/spring_law.h"

namespace tissue {

/// Nodal-force errors (open loop) of one spring set at one FE state: the paper's measure.
struct ForceError {
    double rel_loss;          ///< L(theta) / sqrt(f_fe' Q f_fe), (9); NaN where FE has no force
    double resolved_force_N;  ///< force at the loaded nodes along the tool displacement, the paper's Fig. 3
    double resolved_error;    ///< |model - FE| / |FE| of the resolved force; NaN where it is 0 in FE
};

/// law: spring force (10); theta [N/m] (S); contact: surface point under the tool, used where no free node is loaded;
/// node_weight: Q, one entry for each node (N); path, record: the FE state.
ForceError force_error(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                       const SurfacePoint& contact, const Eigen::VectorXd& node_weight, const LoadPath& path,
                       const PathRecord& record);

/// Free nodes on which the FE indenter acts in a record: one under a point, several under a patch, none at rest.
std::vector<int> loaded_nodes(const SpringMesh& mesh, const PathRecord& record);

/// Sum over `nodes` of the external force along `direction` (unit vector) that holds `displacement` (N x 2) [N].
double resolved_force(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                      const std::vector<int>& nodes, const Eigen::Vector2d& direction, const NodeField& displacement);

/// The same at the ends of the contact's boundary segment: force of the tool on the spring mesh along the tool
/// displacement [N], with every node at its FE position.
double resolved_force(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                      const SurfacePoint& contact, const Eigen::Vector2d& direction, const NodeField& displacement);

}  // namespace tissue
