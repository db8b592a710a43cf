#pragma once

#include "mesh/spring_mesh.h"

namespace tissue {

/// A block in space: nodes with x fastest, then y, then z, which points up; the layer at z = 0 is fixed. Springs are the
/// edges of the cells, the diagonals of their faces and their body diagonals (topology "grid26").
///
/// Each cell divides into six tetrahedra about one of its four body diagonals (Kuhn 1960, IBM J. Res. Dev. 4: 518-524). What
/// (7) sums for a spring is the mean over the four ways to do so: of a cell's volume 1/4 for an edge, 1/6 for a diagonal of a
/// face, 1/4 for one of the body, from every cell that has the spring. Springs inside add up to 6 of a cell's volume, as
/// six tetrahedra with six edges each do.
/// simplices are the tetrahedra of one division, the same in every cell, so that neighbours fit; a node's measure is an
/// eighth of each cell at it.
/// Throws MismatchError for a size that is not positive.
SpringMesh solid_lattice(const Lattice& lattice);

/// What (7) gives a spring of the volume of a cell that has it: by the number of axes it runs along, 1 to 3.
double spring_share(int axes);

}  // namespace tissue
