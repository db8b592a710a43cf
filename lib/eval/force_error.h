#pragma once

#include <vector>

#include "cases/load_path.h"
#include "eval/statistics.h"
#include "springs/spring_law.h"

namespace tissue {

/// Open-loop errors of one spring set at one FE state: the paper's own measure.
struct ForceError {
    double rel_loss;          ///< L(theta) / sqrt(f_fe' Q f_fe), (9); NaN where FE has no force
    double resolved_force_N;  ///< force at the loaded nodes along the push, the paper's Fig. 3
    double resolved_error;    ///< |model - FE| / |FE| of the resolved force; NaN where FE has none
};

/// contact: the surface point that was pushed; weight: Q, one entry a node (N).
ForceError force_error(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                       const SurfacePoint& contact, const Eigen::VectorXd& node_weight, const LoadPath& path,
                       const PathRecord& record);

/// Free nodes that carry the indenter in a record: one under a point, several under a patch. Of a record at rest none.
std::vector<int> loaded_nodes(const SpringMesh& mesh, const PathRecord& record);

/// As below, summed over nodes.
double resolved_force(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                      const std::vector<int>& nodes, const Eigen::Vector2d& direction, const NodeField& displacement);

/// Force of the spring mesh on its contact along the push when every node is where FE has it [N].
double resolved_force(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                      const SurfacePoint& contact, const Eigen::Vector2d& direction, const NodeField& displacement);

}  // namespace tissue
