#pragma once

#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

/// Cells of tissue between the springs, as node numbers. In the plane: rectangles of a lattice (C x 4) or triangles of
/// a shape (C x 3), counter-clockwise. In space: cubes of an embedded lattice (C x 8); bits 1, 2 and 4 of a corner's
/// index are its steps along x, y and z from corner 0.
/// Throws MismatchError if the simplices of a lattice do not pair up to its cells.
Cells mesh_cells(const SpringMesh& mesh);

/// Number of cells that keep their area or volume: the cells of a lattice; one nodal area a node for a shape in the
/// plane.
Eigen::Index cell_count(const SpringMesh& mesh);

/// Rest area of each cell [m^2] (C), in the plane. cells: as mesh_cells returns them.
Eigen::VectorXd cell_areas(const SpringMesh& mesh, const Cells& cells);

/// Numbers of the cells around each node (N lists).
std::vector<std::vector<int>> node_stars(const SpringMesh& mesh, const Cells& cells);

/// Regions in the plane, each a list of cell numbers: first the whole tissue, then its quarters. A quarter has the
/// cells whose centroids lie in one half of the mesh's bounding box along x and in one half along y. A cell on a middle
/// line belongs to both halves, so that a symmetric mesh has symmetric regions. Empty quarters are left out.
std::vector<std::vector<int>> cell_regions(const SpringMesh& mesh, const Cells& cells);

}  // namespace tissue
