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

    /// Sets the solid's rows from the lattice's: of displacements or velocities (N x .), row by row or column by column. Allocates nothing.
    template <class Field>
    void interpolate(Field& u) const noexcept {
        for (Eigen::Index d = 0; d < u.cols(); ++d)
            for (Eigen::Index i = 0; i < corner.rows(); ++i) {
                double sum = 0;
                for (int k = 0; k < 8; ++k) sum += weight(i, k) * u(corner(i, k), d);
                u(i, d) = sum;
            }
    }
};

}  // namespace tissue
