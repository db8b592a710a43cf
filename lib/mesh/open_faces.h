#pragma once

#include "field.h"

namespace tissue {

/// Corners of the four faces of a tetrahedron. The normals point out if its volume is positive.
constexpr int tetrahedron_faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

/// Faces that belong to one tetrahedron only (B x 3): the surface of the volume that the tetrahedra (T x 4) fill. The
/// normals point out if the volumes are positive. The faces are ordered by their node numbers.
Cells open_faces(const Cells& tetrahedra);

}  // namespace tissue
