#pragma once

#include <string>

#include "mesh/shape.h"
#include "registry.h"

namespace tissue {

/// A topology: which nodes springs join. `name` is also SpringMesh::topology of the meshes that it makes.
struct Topology {
    const char* name;
    int dimension;

    /// Makes the spring mesh of a block's lattice (make_lattice). Null in space: springs there follow the cubes of an
    /// embedded lattice.
    SpringMesh (*on_lattice)(const Lattice& lattice);

    /// Makes the spring mesh of any shape. spacing_m: cube edge of an embedded lattice [m]; not used by "edges". Null
    /// where springs follow the cells of a block's lattice.
    SpringMesh (*on_shape)(const Shape& shape, double spacing_m);

    bool needs_lattice() const { return on_shape == nullptr; }
};

/// All topologies:
///   grid4     springs along the axes of a block's lattice, as in the paper
///   grid8     grid4 and both diagonals of every cell
///   edges     the edges of any mesh of triangles
///   embedded  in space: a lattice in which any solid is embedded, a block too (mesh/embedded_lattice.h)
const Registry<Topology>& topologies();

/// Whether a mesh's springs follow the cells of a block's lattice.
bool on_lattice(const SpringMesh& mesh);

/// Whether a mesh's springs follow the cells of a block's lattice or of an embedded one. Otherwise they are edges of
/// triangles.
bool has_cells(const SpringMesh& mesh);

/// Whether every facet of the boundary lies in a plane of the mesh's bounding box.
bool is_box(const SpringMesh& mesh);

}  // namespace tissue
