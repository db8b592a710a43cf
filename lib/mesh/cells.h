#pragma once

#include "mesh/spring_mesh.h"

namespace tissue {

/// Corner nodes of cells, one row a cell, counter-clockwise (C x 3 or C x 4).
using Cells = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The pieces of tissue between the springs: a lattice's squares, a shape's triangles.
/// Throws MismatchError when the triangles of a lattice do not pair up to its squares.
Cells mesh_cells(const SpringMesh& mesh);

/// Area of each cell at rest [m^2] (C).
Eigen::VectorXd cell_areas(const SpringMesh& mesh, const Cells& cells);

}  // namespace tissue
