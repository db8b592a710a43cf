#pragma once

#include "mesh/msh_file.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// A surface that moves with a model in space and is finer than its boundary, such as the one that an organ was segmented to. A vertex moves by what the
/// nearest point of the boundary at rest moves by, interpolated between the three nodes of its facet. Its offset from there does not turn.
struct CarriedSurface {
    NodeField vertices;  ///< [m], at rest (V x 3)
    Cells facets;        ///< of vertices (F x 3)
    Cells node;          ///< of the mesh, for each vertex (V x 3)
    NodeField weight;    ///< of these, sum 1 (V x 3)

    /// Places of the vertices [m] for displacements of the mesh's nodes, u (N x 3).
    NodeField moved(const NodeField& u) const;
};

/// Unit normals of the vertices (V x 3), each facet counted by its area; 0 where they cancel.
NodeField vertex_normals(const NodeField& vertices, const Cells& facets);

/// The triangles of a file carried by a mesh in space. unit_m [m]: of the file's numbers. Points that no triangle has are left out; a surface that points inwards is turned. Each vertex is
/// carried by the nearest facet that faces the same way as it does, or the nearest one where none does.
/// Throws MismatchError for a mesh in the plane, a file without triangles, and where a vertex is farther from the boundary than 0.1 of the mesh's size: another organ, or another unit.
CarriedSurface carried_surface(const SpringMesh& mesh, const MshFile& file, double unit_m);

/// The mesh's own boundary, carried by itself.
CarriedSurface own_surface(const SpringMesh& mesh);

}  // namespace tissue
