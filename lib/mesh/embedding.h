#pragma once

#include "field.h"

namespace tissue {

/// A regular lattice of cubes laid over a solid, of which every cube that holds tissue is kept, and how the solid's own nodes move with it. The solid's nodes are
/// the mesh's first, 0 to K - 1; the lattice's follow. The solid's have no mass and no springs: with the lattice's displacement u a point of it moves by
/// sum_k weight_k u(corner_k), trilinear in the cube that it lies in. The surface, which is where tools touch and errors are measured, is thus as fine as the
/// solid's mesh, and springs are as regular as the lattice.
struct Embedding {
    double spacing_m = 0;         ///< edge h of a cube
    Cells cubes;                  ///< corners of each, bit by bit: 1 along x, 2 along y, 4 along z (C x 8)
    Eigen::VectorXd fraction;     ///< of each cube's volume that lies in the solid, > 0 (C)
    NodeField centroid;           ///< of that part, from corner 0 in edges (C x 3)
    Cells corner;                 ///< of each of the solid's nodes (K x 8)
    NodeField weight;             ///< of these, sum 1 (K x 8)

    bool empty() const { return corner.rows() == 0; }
    int node_count() const { return static_cast<int>(corner.rows()); }  ///< K

    /// What one of the solid's nodes has of the lattice's displacements (N x 3).
    template <class Field>
    Eigen::Vector3d at(int node, const Field& u) const noexcept {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int k = 0; k < 8; ++k)
            for (int d = 0; d < 3; ++d) sum[d] += weight(node, k) * u(corner(node, k), d);
        return sum;
    }
    /// Sets the rows of all of the solid's nodes from the lattice's. Allocates nothing.
    template <class Field>
    void interpolate(Field& u) const noexcept {
        for (int node = 0; node < node_count(); ++node) u.row(node) = at(node, u).transpose();
    }
    /// Adds a force on one of the solid's nodes to the lattice's, f (N x 3): the transpose of at(). Allocates nothing.
    template <class Field>
    void spread(int node, const Eigen::Vector3d& force, Field& f) const noexcept {
        for (int k = 0; k < 8; ++k) f.row(corner(node, k)) += weight(node, k) * force.transpose();
    }
};

}  // namespace tissue
