#pragma once

#include "mesh/shape.h"

namespace tissue {

/// A block in space, x, y and z up, its bottom at z = 0 held: nodes at the corners of the lattice's cells, x fastest, then y, then z. Each cell divides into six tetrahedra
/// (Kuhn 1960, IBM J. Res. Dev. 4: 518-524), all cells alike, so that neighbours fit.
/// Throws MismatchError for a lattice that is not of three axes, without cells, or with a size that is not positive.
Shape solid_block(const Lattice& lattice);

}  // namespace tissue
