#pragma once

#include "mesh/spring_mesh.h"

namespace tissue {

/// Points inside a mesh in space that move with the mesh. The displacement of a point is interpolated linearly between
/// the four nodes of the tetrahedron that contains the point at rest.
struct CarriedPoints {
    Cells node;        ///< four mesh nodes of each point (V x 4)
    NodeField weight;  ///< interpolation weights of these nodes, sum 1 (V x 4)
};

/// Finds the tetrahedron of each point. points: rest positions [m] (V x 3).
/// A point lies in no tetrahedron where the mesh is coarser than the tissue's surface. It then gets the tetrahedron in
/// which its smallest weight is largest; that weight is below 0.
/// Throws MismatchError for a mesh in the plane.
CarriedPoints carried_points(const SpringMesh& mesh, const NodeField& points);

}  // namespace tissue
