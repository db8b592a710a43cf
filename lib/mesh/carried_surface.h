#pragma once

#include "mesh/msh_file.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// A surface that moves with a model in space and may be finer than the boundary of the model's mesh, for example the
/// segmented surface of an organ. Each vertex has the displacement of the boundary point nearest to it at rest,
/// interpolated between the three nodes of that point's facet. The offset from that point to the vertex does not
/// rotate.
struct CarriedSurface {
    NodeField vertices;  ///< rest positions [m] (V x 3)
    Cells facets;        ///< vertex numbers (F x 3)
    Cells node;          ///< three mesh nodes of each vertex (V x 3)
    NodeField weight;    ///< interpolation weights of these nodes, sum 1 (V x 3)

    /// Positions of the vertices [m] (V x 3). u: displacements of the mesh's nodes [m] (N x 3).
    NodeField moved(const NodeField& u) const;
};

/// Unit normals of the vertices (V x 3): facet normals weighted by area; 0 where they cancel.
NodeField vertex_normals(const NodeField& vertices, const Cells& facets);

/// Binds the triangles of a file to the boundary of a mesh in space. unit_m: the file's unit of length [m].
/// Points without a triangle are dropped. A surface whose normals point inwards is turned. Each vertex is bound to the
/// nearest facet whose normal is within 78 degrees of the vertex normal, or to the nearest facet if there is none.
/// Throws MismatchError for a mesh in the plane, for a file without triangles, and if a vertex is farther from the
/// boundary than 0.1 of the mesh's size: the file is then of another organ or in another unit.
CarriedSurface carried_surface(const SpringMesh& mesh, const MshFile& file, double unit_m);

/// The mesh's own boundary as a CarriedSurface. Throws MismatchError for a mesh in the plane.
CarriedSurface own_surface(const SpringMesh& mesh);

}  // namespace tissue
