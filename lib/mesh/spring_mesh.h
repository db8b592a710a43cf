#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "field.h"

// Says the pkg-config file of an installed library. Eigen's arrays cross its border: both sides must allocate alike.
#ifdef TISSUE_EIGEN_ALIGNMENT
static_assert(EIGEN_DEFAULT_ALIGN_BYTES == TISSUE_EIGEN_ALIGNMENT,
              "libtissue was built for other vector instructions: compile both with the same -m flags");
#endif

namespace tissue {

/// The nodes and springs of Sec. 4, without stiffness: geometry alone.
struct SpringMesh {
    std::string topology;                      ///< a name of topologies(), mesh/topology.h
    NodeField nodes;                           ///< rest positions [m] (N x D)
    Eigen::Matrix<int, Eigen::Dynamic, 2> springs;    ///< node pair of each spring (S x 2)
    Eigen::Matrix<int, Eigen::Dynamic, 3> triangles;  ///< one triangulation of the tissue (T x 3)
    std::vector<int> boundary;                 ///< node loop, counter-clockwise; segment b joins b and b + 1
    std::vector<int> fixed;                    ///< nodes held at rest, ascending
    Eigen::VectorXd incident_area;             ///< sum of area(T_e) in (7) for each spring [m^2] (S)
    Eigen::VectorXd node_area;                 ///< sum of V_j / (4 thickness) in (8) for each node [m^2] (N)

    int node_count() const { return static_cast<int>(nodes.rows()); }
    int spring_count() const { return static_cast<int>(springs.rows()); }
    int dimension() const { return static_cast<int>(nodes.cols()); }
    double rest_length(int spring) const {
        return (nodes.row(springs(spring, 0)) - nodes.row(springs(spring, 1))).norm();
    }
};

/// A point of the outline, between the nodes of one boundary segment: x = weight(0) x_i + weight(1) x_j, the
/// paper's (16)-(17).
struct SurfacePoint {
    int node[2];
    double weight[2];
};

/// The block's lattice: (cells_x + 1) x (cells_y + 1) nodes, row by row from the bottom, bottom row fixed.
/// topology: a name of topologies() (mesh/topology.h). The triangles of (7) are half cells: an axis spring borders one a side, a
/// diagonal two.
/// Throws MismatchError for an unknown topology or a size that is not positive.
SpringMesh make_lattice(const std::string& topology, int cells_x, int cells_y, double width_m, double height_m);

/// The boundary segment and weights of a position [m] on the outline.
/// Throws MismatchError when it lies farther than 1e-6 of the mesh's size from it.
SurfacePoint locate_on_surface(const SpringMesh& mesh, const Eigen::Vector2d& position_m);

/// Index of the node at a position [m]. Throws MismatchError when there is none within 1e-6 of the mesh's size.
int node_at(const SpringMesh& mesh, const Eigen::Vector2d& position_m);

}  // namespace tissue
