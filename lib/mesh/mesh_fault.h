#pragma once

#include <optional>
#include <string>

#include "mesh/spring_mesh.h"

namespace tissue {

/// Why a mesh is none that a study makes.
struct MeshFault {
    std::string part;  ///< "triangles", "boundary" or "fixed"; in space "tetrahedra", "facets" or "fixed"
    std::string why;
};

/// Orientation and connection of a mesh whose indices are nodes already; nothing when all is well.
/// Triangles run counter-clockwise and have area; their outer edges are the boundary's segments, each once and
/// counter-clockwise; the fixed nodes leave one connected free surface.
/// In space tetrahedra have positive volume; the faces that one of them has alone are the facets, each once and with its
/// normal out; fixed nodes hold some facet whole and leave others free.
std::optional<MeshFault> mesh_fault(const SpringMesh& mesh);

/// The same of triangles alone.
std::optional<MeshFault> triangle_fault(const NodeField& nodes, const Cells& triangles);

}  // namespace tissue
