#pragma once

#include <string>
#include <vector>

#include "mesh/msh_file.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// Any closed outline in the plane, filled with triangles: their corners are the springs' nodes, their edges the
/// springs, and finite elements are their parts. Or any closed surface in space, filled with tetrahedra: springs are of a lattice that it is embedded in
/// (mesh/embedded_lattice.h), displacements are compared at its nodes, and finite elements have meshes of their own (mesh/solid_shape.h).
struct Shape {
    NodeField nodes;                              ///< [m] (N x D)
    Cells simplices;                              ///< triangles, counter-clockwise (T x 3); tetrahedra of positive volume (T x 4)
    std::vector<int> region;                      ///< of each: 0 the base material, else 1 + its named region
    std::vector<std::array<int, 2>> fixed_edges;  ///< of the boundary, counter-clockwise; the rest of it is free
    std::vector<std::array<int, 3>> fixed_facets = {};  ///< in space, in place of edges: normals out
    std::vector<int> bed = {};                          ///< of each of those the bed that it lies on, from 1; 0: none, it does not move. Empty: none of all

    bool is_solid() const { return nodes.cols() == 3; }
};

/// What was put right on the way.
struct ShapeNotes {
    int turned = 0;   ///< triangles that ran clockwise, tetrahedra that were inside out
    int dropped = 0;  ///< points that belong to none of them
};

/// A shape from a mesh: triangles turned counter-clockwise, points of no triangle left out, nodes numbered along the
/// shape's longest axis, so that the realtime core's bands are narrow. `fixed` and `regions` are names of physical
/// curves and surfaces; unit_m [m] is the mesh's unit of length.
/// Throws FileError with file, place and cause: no triangles, not in the plane, a triangle without area, triangles that
/// lie over each other, an outline that is not one closed loop or meets itself, no group of a name (with those there
/// are), a fixed group that is not on the outline, or that leaves no connected free surface.
Shape make_shape(const MshFile& mesh, const std::vector<std::string>& fixed, const std::vector<std::string>& regions,
                 double unit_m, ShapeNotes* notes = nullptr);

/// The shape as MSH 2.2 in metres: lines "fixed" 1 and "free" 2, triangles "tissue" 10 and its regions 11, 12, ...
std::string to_msh(const Shape& shape, const std::vector<std::string>& regions);

/// Reads what to_msh wrote, nodes in the order of the file. Throws FileError.
Shape read_shape(const std::string& file);

/// The shape's spring mesh, topology "edges": one spring an edge; (7)'s areas are the triangles on it, and (8)'s give
/// each corner a third. In space mesh/solid_shape.h's.
SpringMesh edge_mesh(const Shape& shape);

/// The triangles or tetrahedra of another mesh, as a shape.
Shape shape_of(const SpringMesh& mesh);

/// Numbers of nodes that keep neighbours close to each other: along the longest axis of the places (N x D), then along the
/// next. Returns which of them stands where: the first is result[0].
std::vector<int> order_along(const NodeField& places);

/// Tags of the physical groups with these names, for messages of a "surface", "curve" or "volume" of a file.
/// Throws FileError with the names there are.
std::vector<int> group_tags(const std::vector<std::string>& wanted, const std::map<int, std::string>& names,
                            const std::string& what, const std::string& file);

}  // namespace tissue
