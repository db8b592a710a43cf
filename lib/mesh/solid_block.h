#pragma once

#include "mesh/shape.h"

namespace tissue {

/// A block in space with z up; its bottom at z = 0 is fixed. Nodes are the corners of the lattice's cells, x fastest,
/// then y, then z. Each cell is divided into six tetrahedra (Kuhn 1960, IBM J. Res. Dev. 4: 518-524). All cells are
/// divided alike, so that neighbours share their faces' diagonals.
/// Throws MismatchError if the lattice has not three axes, has no cells or a size that is not positive.
Shape solid_block(const Lattice& lattice);

}  // namespace tissue
