#pragma once

#include "mesh/embedded_lattice.h"
#include "mesh/solid_block.h"

namespace tissue {

/// A block in a lattice of cubes as long as its cells are along x.
inline SpringMesh embedded_block(const Lattice& of) { return embedded_lattice(solid_block(of), of.size_m[0] / of.cells[0]); }

}  // namespace tissue
