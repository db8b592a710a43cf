#pragma once

#include <optional>
#include <string>

#include "mesh/spring_mesh.h"

namespace tissue {

/// Why a mesh is invalid.
struct MeshFault {
    std::string part;  ///< "triangles", "boundary" or "fixed"; in space "tetrahedra", "facets" or "fixed"
    std::string why;
};

/// Checks orientation and connection of a mesh whose node numbers are already known to be in range. Result: the first
/// fault; nothing if the mesh is valid.
/// In the plane: triangles run counter-clockwise and have area. Their outer edges are the boundary's segments, each
/// once and counter-clockwise. The fixed nodes leave one connected free surface.
/// In space: tetrahedra have positive volume. The faces of one tetrahedron only are the facets, each once and with its
/// normal out. At least one facet has only fixed nodes, and at least one has none.
std::optional<MeshFault> mesh_fault(const SpringMesh& mesh);

/// The checks of triangles in the plane only. nodes [m] (N x 2), triangles (T x 3).
std::optional<MeshFault> triangle_fault(const NodeField& nodes, const Cells& triangles);

}  // namespace tissue
