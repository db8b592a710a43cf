#pragma once

#include <Eigen/Core>
#include <vector>

#include "haptic/realtime_mesh.h"

namespace tissue {

/// Cholesky factor of a symmetric banded matrix of order n and half bandwidth b, in n b^2 operations. The storage is
/// allocated once: refilling, factoring and solving allocate nothing.
class BandCholesky {
   public:
    BandCholesky(int order, int half_bandwidth);

    int half_bandwidth() const { return b_; }
    /// Storage of such a matrix [bytes].
    static double bytes(double order, double half_bandwidth) { return 8 * order * (half_bandwidth + 1); }

    void set_zero() noexcept;
    /// Entry on or below the diagonal (row >= column), before factor().
    double& at(int row, int column) noexcept {
        return a_[static_cast<std::size_t>(column) * static_cast<std::size_t>(b_ + 1) +
                  static_cast<std::size_t>(row - column)];
    }

    /// Factors in place. Returns false when the matrix is not positive definite: a pivot is at most 1e-10 of the
    /// largest diagonal entry.
    bool factor() noexcept;

    /// Solves A x = rhs in place, after factor(). x (n) holds rhs on entry.
    void solve(double* x) const noexcept;

   private:
    int n_, b_;
    std::vector<double> a_;  ///< column by column: the diagonal entry, then the b entries below it
};

/// Numbering of the free degrees of freedom of a mesh in a banded matrix. One unknown per node is enough where the
/// stiffness of the mesh's SpringLaw is the same along both axes and does not couple them (`isotropic`). Otherwise a
/// node has two unknowns.
struct FreeNumbering {
    explicit FreeNumbering(const RealtimeMesh& mesh);

    int per_node;             ///< 1 or 2
    std::vector<int> number;  ///< index of each node among the free nodes, -1 where it is fixed (N)
    int order, half_bandwidth;  ///< of the matrix
    std::vector<int> free_slots;  ///< slots with at least one free node
};

/// Adds scale * K(theta) at the displacement u to A, on the free nodes. A is laid out by the numbering.
/// theta by slot [N/m] (P), u [m] (N x 2). `convex`: see RealtimeMesh::unit_stiffness.
void add_stiffness(const RealtimeMesh& mesh, const FreeNumbering& numbering, const Eigen::VectorXd& theta,
                   const NodeColumns& u, double scale, bool convex, BandCholesky& A) noexcept;

}  // namespace tissue
