#pragma once

#include "mesh/spring_mesh.h"

namespace tissue {

/// Points inside a mesh in space that move with it: each by what the tetrahedron in which it lies at rest moves by there, linear between its four nodes.
struct CarriedPoints {
    Cells node;        ///< of the mesh, for each point (V x 4)
    NodeField weight;  ///< of these, sum 1 (V x 4)
};

/// points (V x 3) [m] at rest. One in no tetrahedron, where the mesh is coarser than the tissue that it stands for, goes with the one in which its smallest weight
/// is largest, and that weight is then below 0. Throws MismatchError for a mesh in the plane.
CarriedPoints carried_points(const SpringMesh& mesh, const NodeField& points);

}  // namespace tissue
