#pragma once

#include "example.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// The example's block, pressed by an instrument: a fifth of the contacts held out, a tenth to choose with.
Study measured_study();

/// Its spring mesh, 8-connected.
SpringMesh measured_mesh();

}  // namespace tissue
