#pragma once

#include "springs/tissue_model.h"

namespace tissue {

/// An energy model on any mesh in space, for a disc of radius 7 mm. All its constants differ, so that a test detects
/// swapped constants. It has no FE reference.
TissueModel solid_model_example(const SpringMesh& mesh);

}  // namespace tissue
