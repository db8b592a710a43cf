#pragma once

#include <string>
#include <vector>

#include "mesh/msh_file.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// A tissue of any shape.
/// In the plane: a closed outline, filled with triangles. Their corners are the springs' nodes and their edges the
/// springs. Finite elements are subdivisions of the triangles.
/// In space: a closed surface, filled with tetrahedra. The springs are those of a lattice in which the shape is
/// embedded (mesh/embedded_lattice.h). Displacements are compared at the shape's nodes. Finite elements have meshes of
/// their own (mesh/solid_shape.h).
struct Shape {
    NodeField nodes;                              ///< [m] (N x D)
    /// Triangles, counter-clockwise (T x 3), or tetrahedra of positive volume (T x 4).
    Cells simplices;
    std::vector<int> region;                      ///< of each simplex: 0 base material, else 1 + number of its region
    std::vector<std::array<int, 2>> fixed_edges;  ///< of the boundary, counter-clockwise; its other edges are free
    std::vector<std::array<int, 3>> fixed_facets = {};  ///< in space, instead of edges; normals out
    /// Elastic bed of each fixed facet, from 1; 0: rigidly fixed. Empty: all are rigidly fixed.
    std::vector<int> bed = {};

    bool is_solid() const { return nodes.cols() == 3; }
};

/// Corrections that make_shape made.
struct ShapeNotes {
    int turned = 0;   ///< triangles that ran clockwise, or inverted tetrahedra
    int dropped = 0;  ///< points without a triangle or tetrahedron
};

/// Makes a shape in the plane from a mesh. Triangles are turned counter-clockwise and points without a triangle are
/// dropped. Nodes are numbered along the shape's longest axis, so that the realtime core's matrices have narrow bands.
/// fixed, regions: names of physical curves and of physical surfaces; unit_m: the mesh's unit of length [m].
/// notes: if not null, gets the corrections.
/// Throws FileError with file, place and cause: no triangles; not in the plane; a triangle without area or in two
/// regions; overlapping triangles; an outline that is not one closed loop or meets itself; no group of a name (with the
/// names there are); a fixed group that is not on the outline or leaves no connected free surface.
Shape make_shape(const MshFile& mesh, const std::vector<std::string>& fixed, const std::vector<std::string>& regions,
                 double unit_m, ShapeNotes* notes = nullptr);

/// The shape as text in MSH 2.2, in metres: lines "fixed" 1 and "free" 2; triangles "tissue" 10 and its regions, which
/// are numbered from 11. In space: solid_to_msh of mesh/solid_shape.h.
std::string to_msh(const Shape& shape, const std::vector<std::string>& regions);

/// Reads a shape in the plane that to_msh wrote, with nodes in the order of the file. Throws FileError.
Shape read_shape(const std::string& file);

/// The shape's spring mesh, topology "edges": one spring an edge. The area of a spring in (7) is that of the triangles
/// at its edge. For (8) each triangle gives a third of its area to each corner. In space: solid_edge_mesh of
/// mesh/solid_shape.h.
SpringMesh edge_mesh(const Shape& shape);

/// The triangles or tetrahedra of a mesh as a shape. All of it is base material.
Shape shape_of(const SpringMesh& mesh);

/// An order of nodes that keeps neighbours close: along the longest principal axis of the positions (N x D), then along
/// the next. Result: indices of the positions in that order; result[0] is the first.
std::vector<int> order_along(const NodeField& places);

/// Tags of the physical groups with the wanted names. what: "surface", "curve" or "volume", for messages.
/// Throws FileError with the names there are if one is missing.
std::vector<int> group_tags(const std::vector<std::string>& wanted, const std::map<int, std::string>& names,
                            const std::string& what, const std::string& file);

}  // namespace tissue
