#pragma once

#include "field.h"

namespace tissue {

/// The four faces of a tetrahedron of positive volume, by its corners; their normals point out.
constexpr int tetrahedron_faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

/// Faces that one tetrahedron has alone (B x 3): the surface of what they fill, normals out where their volumes are positive.
/// tetrahedra (T x 4). Ordered by their node numbers.
Cells open_faces(const Cells& tetrahedra);

}  // namespace tissue
