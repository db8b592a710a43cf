#pragma once

#include "field.h"

namespace tissue {

/// A regular lattice of cubes over a solid, and the interpolation that moves the solid's own nodes with the lattice.
/// Only cubes with tissue are kept (mesh/embedded_lattice.h). The solid's nodes are the mesh's first, 0 to K - 1; the
/// lattice's nodes follow. The solid's nodes have no mass and no springs. With the lattice's displacement u a node of
/// the solid moves by sum_k weight_k u(corner_k), trilinear in the cube that contains it. The surface, where tools act
/// and errors are measured, is thus as fine as the solid's mesh, and the springs are as regular as the lattice.
struct Embedding {
    double spacing_m = 0;         ///< edge h of a cube
    Cells cubes;                  ///< lattice nodes of the corners, ordered as in mesh/cells.h (C x 8)
    Eigen::VectorXd fraction;     ///< part of each cube's volume that lies in the solid, > 0 (C)
    NodeField centroid;           ///< of that part, from corner 0 in cube edges (C x 3)
    Cells corner;                 ///< lattice nodes of the cube of each of the solid's nodes (K x 8)
    NodeField weight;             ///< trilinear weights of these, sum 1 (K x 8)

    bool empty() const { return corner.rows() == 0; }
    int node_count() const { return static_cast<int>(corner.rows()); }  ///< K

    /// Displacement of one of the solid's nodes, interpolated from the lattice's rows of u (N x 3).
    template <class Field>
    Eigen::Vector3d at(int node, const Field& u) const noexcept {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int k = 0; k < 8; ++k)
            for (int d = 0; d < 3; ++d) sum[d] += weight(node, k) * u(corner(node, k), d);
        return sum;
    }
    /// Sets the rows of all the solid's nodes in u (N x 3) from the lattice's rows. Allocates nothing.
    template <class Field>
    void interpolate(Field& u) const noexcept {
        for (int node = 0; node < node_count(); ++node) u.row(node) = at(node, u).transpose();
    }
    /// Distributes a force on one of the solid's nodes to the lattice's rows of f (N x 3): the transpose of at().
    /// Allocates nothing.
    template <class Field>
    void spread(int node, const Eigen::Vector3d& force, Field& f) const noexcept {
        for (int k = 0; k < 8; ++k) f.row(corner(node, k)) += weight(node, k) * force.transpose();
    }
};

}  // namespace tissue
