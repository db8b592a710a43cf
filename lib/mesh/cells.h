#pragma once

#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

/// The pieces of tissue between the springs: a lattice's squares and a shape's triangles, counter-clockwise; in space an embedded lattice's cubes (C x 8, corners bit by bit: 1 along x,
/// 2 along y, 4 along z).
/// Throws MismatchError when the simplices of a lattice do not make up its cells.
Cells mesh_cells(const SpringMesh& mesh);

/// How many pieces keep their volume or area: cells of a lattice, of a shape in the plane what lies about each node.
Eigen::Index cell_count(const SpringMesh& mesh);

/// Area of each cell at rest [m^2] (C). In the plane.
Eigen::VectorXd cell_areas(const SpringMesh& mesh, const Cells& cells);

/// The cells around each node (N): lists of cells.
std::vector<std::vector<int>> node_stars(const SpringMesh& mesh, const Cells& cells);

/// In the plane the whole tissue, then its quarters: cells whose middles lie in one half of the box around the mesh, along x and along
/// y. A cell in the middle belongs to both sides, so that a mesh that mirrors itself has regions that do. Quarters without
/// cells are left out. Each a list of cells.
std::vector<std::vector<int>> cell_regions(const SpringMesh& mesh, const Cells& cells);

}  // namespace tissue
