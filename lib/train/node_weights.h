#pragma once

#include "cases/load_path.h"
#include "study/study.h"

namespace tissue {

/// Diagonal of Q of (9), one entry for each node (N): high for the 3 x 3 nodes about the contact, lower elsewhere.
/// Values are drawn uniformly from the study's ranges (weight_near, weight_far), with the study's seed and the name of
/// the case. On a shape other than the block the near nodes are those within 1.2 mean spring lengths along each axis.
Eigen::VectorXd draw_node_weights(const Study& study, const SpringMesh& mesh, const LoadCase& load);

}  // namespace tissue
