#pragma once

#include <string>
#include <vector>

#include "mesh/held_region.h"
#include "mesh/shape.h"

namespace tissue {

/// A shape in space from a mesh with tetrahedra: turned to positive volume, points of no tetrahedron left out, nodes
/// numbered along the shape's longest axis. `fixed` and `regions` are names of physical surfaces and volumes, `fixed` regions too (mesh/held_region.h, whose reader `read` is), of which facets
/// with their middles there are held; beds: of each the bed that it lies on, from 1, or 0 (mesh/surface.h); unit_m [m] is the mesh's unit of length.
/// Throws FileError with file, place and cause: no tetrahedra, a sliver, tetrahedra that lie over each other, a surface that
/// is not one closed one without a hole through it or meets itself, no group of a name (with those there are), a fixed
/// group that is not on the surface, or that leaves nothing of it free.
Shape make_solid_shape(const MshFile& mesh, const std::vector<std::string>& fixed, const std::vector<std::string>& regions,
                       double unit_m, ShapeNotes* notes = nullptr, const HeldRegion::Reader& read = {}, const std::vector<int>& beds = {});

/// The shape as MSH 2.2 in metres: triangles "fixed" 1, "free" 2, and on beds "bed-1" 21, ..., tetrahedra "tissue" 10 and its regions 11, 12, ...
std::string solid_to_msh(const Shape& shape, const std::vector<std::string>& regions);

/// Reads what solid_to_msh wrote, nodes in the order of the file. Throws FileError.
Shape read_solid_shape(const std::string& file);

/// The shape's edges, surface and held nodes, for checks only: it has no topology, and no model has such a mesh.
SpringMesh solid_edge_mesh(const Shape& shape);

/// The tetrahedra of another mesh in space, as a shape.
Shape solid_shape_of(const SpringMesh& mesh);

}  // namespace tissue
