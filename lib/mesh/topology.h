#pragma once

#include <string>

#include "mesh/shape.h"
#include "registry.h"

namespace tissue {

/// Which nodes springs join. What a maker makes bears the name.
struct Topology {
    const char* name;
    int dimension;

    /// The springs of a block's lattice: make_lattice; null in space, where springs follow cubes of their own.
    SpringMesh (*on_lattice)(const Lattice& lattice);

    /// Those of any shape, spacing_m long where they are of an embedded lattice; null where springs follow the cells of a lattice.
    SpringMesh (*on_shape)(const Shape& shape, double spacing_m);

    bool needs_lattice() const { return on_shape == nullptr; }
};

/// Every topology there is, in one line each:
///   grid4  the axis springs of a lattice: the paper's
///   grid8  both diagonals of every cell as well
///   edges  the edges of any mesh of triangles
///   embedded in space: a lattice of springs that any solid is embedded in, a block as well (mesh/embedded_lattice.h)
const Registry<Topology>& topologies();

/// Whether a mesh's springs follow the cells of a block's lattice.
bool on_lattice(const SpringMesh& mesh);

/// Whether springs follow cells, of a block's lattice or an embedded one. Otherwise they are the edges of triangles.
bool has_cells(const SpringMesh& mesh);

/// Whether all of the boundary lies on the planes of the box about it.
bool is_box(const SpringMesh& mesh);

}  // namespace tissue
