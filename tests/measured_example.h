#pragma once

#include "example.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// The example's block with measured forces in place of an FE reference. A fifth of the contacts is for the test set, a
/// tenth for the validation set. The energy model is trained with almost no ridge.
const std::string& measured_study_text();
Study measured_study();

/// Its spring mesh.
SpringMesh measured_mesh();

}  // namespace tissue
