#pragma once

#include "example.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// The example's block, pressed by an instrument in place of finite elements: a fifth of the contacts held out, a tenth
/// to choose with, a law with next to no ridge.
const std::string& measured_study_text();
Study measured_study();

/// Its spring mesh.
SpringMesh measured_mesh();

}  // namespace tissue
