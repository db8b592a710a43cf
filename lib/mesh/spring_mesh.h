#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "field.h"
#include "mesh/embedding.h"

// The pkg-config file of an installed library defines this macro. Eigen's arrays cross the library's interface, so both
// sides must allocate with the same alignment.
#ifdef TISSUE_EIGEN_ALIGNMENT
static_assert(EIGEN_DEFAULT_ALIGN_BYTES == TISSUE_EIGEN_ALIGNMENT,
              "libtissue was built for other vector instructions: compile both with the same -m flags");
#endif

namespace tissue {

/// Longest side of the nodes' bounding box [m]. nodes: positions [m] (N x D).
double size_m(const NodeField& nodes);

/// Nodes, springs and cells of a spring mesh (Sec. 4 of the paper): geometry only, no stiffness.
struct SpringMesh {
    std::string topology;                      ///< a name of topologies() (mesh/topology.h)
    NodeField nodes;                           ///< rest positions [m] (N x D)
    Eigen::Matrix<int, Eigen::Dynamic, 2> springs;    ///< node pair of each spring (S x 2)
    Cells simplices;                           ///< the tissue divided into triangles, counter-clockwise (T x 3); in
                                               ///< space into tetrahedra of positive volume (T x 4)
    Cells facets;                              ///< boundary: segments, counter-clockwise, each starting where the one
                                               ///< before ends (B x 2); in space triangles, normals out (B x 3)
    std::vector<int> fixed;                    ///< fixed nodes, ascending
    Eigen::VectorXd incident_measure;          ///< sum of area(T_e) in (7) for each spring [m^2]; in space of
                                               ///< volumes [m^3] (S)
    Eigen::VectorXd node_measure;              ///< sum of V_j / (4 thickness) in (8) for each node [m^2]; in space of
                                               ///< V_j / 8 [m^3], 0 at an embedded solid's own nodes (N)
    Embedding embedding;                       ///< of a solid in a lattice; empty for other meshes

    /// Rest positions of the tissue's own nodes [m]: all nodes (N x D), but only the first K of an embedded solid.
    auto own_nodes() const { return nodes.topRows(embedding.empty() ? nodes.rows() : embedding.node_count()); }
    /// Number of point supports: one for each fixed node of an embedded solid, else 0.
    int support_count() const { return embedding.empty() ? 0 : static_cast<int>(fixed.size()); }
    /// Longest side of the bounding box of the tissue's own nodes [m].
    double size_m() const { return tissue::size_m(own_nodes()); }
    int node_count() const { return static_cast<int>(nodes.rows()); }
    int spring_count() const { return static_cast<int>(springs.rows()); }
    int dimension() const { return static_cast<int>(nodes.cols()); }
    bool is_solid() const { return dimension() == 3; }

    /// In the plane: the boundary's nodes in order, counter-clockwise. Segment b joins entries b and b + 1.
    std::vector<int> loop() const;
    /// Length of a spring at rest [m].
    double rest_length(int spring) const {
        return (nodes.row(springs(spring, 0)) - nodes.row(springs(spring, 1))).norm();
    }
};

/// Whether positions [m] are those of the mesh's own nodes (own_nodes), up to 1e-9 relative.
bool has_nodes(const SpringMesh& mesh, const NodeField& places);

/// A point of the outline on the boundary segment of nodes i and j: x = weight[0] x_i + weight[1] x_j, (16)-(17) of the
/// paper.
struct SurfacePoint {
    int node[2];
    double weight[2];
};

/// Segments of a closed loop of nodes, as facets (B x 2).
Cells loop_facets(const std::vector<int>& loop);

/// A block's number of cells and size [m] along each axis (D). The last axis points up.
struct Lattice {
    std::vector<int> cells;
    std::vector<double> size_m;

    int dimension() const { return static_cast<int>(cells.size()); }
};

/// Spring mesh of a block in the plane: cells + 1 nodes along each axis, the first axis fastest, the bottom row fixed.
/// In space use embedded_lattice(solid_block(lattice), spacing_m).
/// topology: a name of topologies() (mesh/topology.h). The triangles of (7) are half cells. An axis spring borders one
/// on each side that has tissue, a diagonal spring borders two.
/// Throws MismatchError for an unknown topology, for one of another dimension or without a block's lattice, for less
/// than one cell, and for a size that is not positive.
SpringMesh make_lattice(const std::string& topology, const Lattice& lattice);
SpringMesh make_lattice(const std::string& topology, int cells_x, int cells_y, double width_m, double height_m);

/// In the plane: the boundary segment and weights of a position [m] on the outline.
/// Throws MismatchError if the position is farther than 1e-6 of the mesh's size from the outline.
SurfacePoint locate_on_surface(const SpringMesh& mesh, const Eigen::Vector2d& position_m);

/// Throws MismatchError if a position [m] (D) is farther than 1e-6 of the mesh's size from the surface.
void check_on_surface(const SpringMesh& mesh, const Point& position_m);

/// Number of the node at a position [m] (D). Throws MismatchError if there is none within 1e-6 of the mesh's size.
int node_at(const SpringMesh& mesh, const Point& position_m);

}  // namespace tissue
