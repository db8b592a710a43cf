#pragma once

#include <string>
#include <vector>

#include "mesh/fixed_region.h"
#include "mesh/shape.h"

namespace tissue {

/// Makes a shape in space from a mesh of tetrahedra. Tetrahedra are turned to positive volume and points without a
/// tetrahedron are dropped. Nodes are numbered along the shape's longest axis.
/// fixed: names of physical surfaces, or regions of space (mesh/fixed_region.h); a region fixes the facets whose
/// centroids lie in it. regions: names of physical volumes. unit_m: the mesh's unit of length [m].
/// notes: if not null, gets the corrections. read: reads the file of a `within` region.
/// beds: elastic bed of each of `fixed`, from 1 (mesh/surface.h); 0 or an empty list: none.
/// Throws FileError with file, place and cause: no tetrahedra; a sliver; overlapping tetrahedra; a surface with a
/// cavity, a second piece or a hole through it, or one that meets itself; no group of a name (with the names there
/// are); a fixed group that is not on the surface or leaves no facet free; a region or bed without a facet.
Shape make_solid_shape(const MshFile& mesh, const std::vector<std::string>& fixed, const std::vector<std::string>& regions,
                       double unit_m, ShapeNotes* notes = nullptr, const FixedRegion::Reader& read = {}, const std::vector<int>& beds = {});

/// The shape as text in MSH 2.2, in metres: triangles "fixed" 1, "free" 2 and, on elastic beds, "bed-1" 21 and so on;
/// tetrahedra "tissue" 10 and its regions from 11.
std::string solid_to_msh(const Shape& shape, const std::vector<std::string>& regions);

/// Reads a shape that solid_to_msh wrote, with nodes in the order of the file. Throws FileError.
Shape read_solid_shape(const std::string& file);

/// The shape's edges as springs, its surface and its fixed nodes, for checks only. The mesh has no topology, and no
/// model uses it.
SpringMesh solid_edge_mesh(const Shape& shape);

/// The tetrahedra of a mesh in space as a shape. All of it is base material.
Shape solid_shape_of(const SpringMesh& mesh);

}  // namespace tissue
