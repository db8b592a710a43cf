#pragma once

#include "cases/load_path.h"
#include "study/study.h"

namespace tissue {

/// The diagonal of Q of (9), one entry a node (N): high for the 3 x 3 nodes about the contact, lower elsewhere, both
/// drawn at random from the study's ranges, by its seed and the case's name. On a shape the nodes about the contact are
/// those as near as the next ones lie.
Eigen::VectorXd draw_node_weights(const Study& study, const SpringMesh& mesh, const LoadCase& load);

}  // namespace tissue
