#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "field.h"
#include "mesh/embedding.h"

// Says the pkg-config file of an installed library. Eigen's arrays cross its border: both sides must allocate alike.
#ifdef TISSUE_EIGEN_ALIGNMENT
static_assert(EIGEN_DEFAULT_ALIGN_BYTES == TISSUE_EIGEN_ALIGNMENT,
              "libtissue was built for other vector instructions: compile both with the same -m flags");
#endif

namespace tissue {

/// Longest side of the box about all nodes [m] (N x D).
double size_m(const NodeField& nodes);

/// The nodes and springs of Sec. 4, without stiffness: geometry alone.
struct SpringMesh {
    std::string topology;                      ///< a name of topologies(), mesh/topology.h
    NodeField nodes;                           ///< rest positions [m] (N x D)
    Eigen::Matrix<int, Eigen::Dynamic, 2> springs;    ///< node pair of each spring (S x 2)
    Cells simplices;                           ///< one division of the tissue: triangles, counter-clockwise (T x 3); in
                                               ///< space tetrahedra of positive volume (T x 4)
    Cells facets;                              ///< its boundary: segments, counter-clockwise, each beginning where the one
                                               ///< before ends (B x 2); in space triangles whose normals point out (B x 3)
    std::vector<int> fixed;                    ///< nodes held at rest, ascending
    Eigen::VectorXd incident_measure;          ///< sum of area(T_e) in (7) for each spring [m^2], in space of volumes [m^3] (S)
    Eigen::VectorXd node_measure;              ///< sum of V_j / (4 thickness) in (8) for each node [m^2], in space of V_j / 8 [m^3] (N)
    Embedding embedding;                       ///< of a solid in a lattice; empty of other meshes. Its own nodes have no measure

    /// Places of the tissue's own nodes [m]: all, but of an embedded solid without its lattice's (K x D).
    auto own_nodes() const { return nodes.topRows(embedding.empty() ? nodes.rows() : embedding.node_count()); }
    /// Supports at points: one a held node of an embedded solid, else none.
    int support_count() const { return embedding.empty() ? 0 : static_cast<int>(fixed.size()); }
    /// Longest side of the box about the tissue's own nodes [m].
    double size_m() const { return tissue::size_m(own_nodes()); }
    int node_count() const { return static_cast<int>(nodes.rows()); }
    int spring_count() const { return static_cast<int>(springs.rows()); }
    int dimension() const { return static_cast<int>(nodes.cols()); }
    bool is_solid() const { return dimension() == 3; }

    /// In the plane: the boundary's nodes in order, counter-clockwise; segment b joins b and b + 1.
    std::vector<int> loop() const;
    double rest_length(int spring) const {
        return (nodes.row(springs(spring, 0)) - nodes.row(springs(spring, 1))).norm();
    }
};

/// Whether places are those of the mesh's nodes, of an embedded solid of its own [m] (N x D).
bool has_nodes(const SpringMesh& mesh, const NodeField& places);

/// A point of the outline, between the nodes of one boundary segment: x = weight(0) x_i + weight(1) x_j, the
/// paper's (16)-(17).
struct SurfacePoint {
    int node[2];
    double weight[2];
};

/// Facets of a closed node loop: its segments (B x 2).
Cells loop_facets(const std::vector<int>& loop);

/// A block's cells along each axis, the last of which points up, and its size [m] (D).
struct Lattice {
    std::vector<int> cells;
    std::vector<double> size_m;

    int dimension() const { return static_cast<int>(cells.size()); }
};

/// The block's lattice: cells + 1 nodes along each axis, the first axis fastest, bottom row or layer fixed.
/// topology: a name of topologies() (mesh/topology.h). The triangles of (7) are half cells: an axis spring borders one a side, a
/// diagonal two. In the plane; in space: embedded_lattice(solid_block(lattice), spacing_m).
/// Throws MismatchError for an unknown topology, one of another dimension, or a size that is not positive.
SpringMesh make_lattice(const std::string& topology, const Lattice& lattice);
SpringMesh make_lattice(const std::string& topology, int cells_x, int cells_y, double width_m, double height_m);

/// The boundary segment and weights of a position [m] on the outline.
/// Throws MismatchError when it lies farther than 1e-6 of the mesh's size from it. In the plane.
SurfacePoint locate_on_surface(const SpringMesh& mesh, const Eigen::Vector2d& position_m);

/// Throws MismatchError when a position [m] (D) lies farther than 1e-6 of the mesh's size from its surface.
void check_on_surface(const SpringMesh& mesh, const Point& position_m);

/// Index of the node at a position [m] (D). Throws MismatchError when there is none within 1e-6 of the mesh's size.
int node_at(const SpringMesh& mesh, const Point& position_m);

}  // namespace tissue
