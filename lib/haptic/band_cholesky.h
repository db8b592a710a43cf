#pragma once

#include <Eigen/Core>
#include <vector>

#include "haptic/realtime_mesh.h"

namespace tissue {

/// Cholesky factor of a symmetric banded matrix in storage that is made once: refilling, factoring and solving
/// allocate nothing. Order n, half bandwidth b; n b^2 operations.
class BandCholesky {
   public:
    BandCholesky(int order, int half_bandwidth);

    int order() const { return n_; }
    int half_bandwidth() const { return b_; }
    static double bytes(double order, double half_bandwidth) { return 8 * order * (half_bandwidth + 1); }

    void set_zero() noexcept;
    /// Entry on or below the diagonal, row >= column.
    double& at(int row, int column) noexcept {
        return a_[static_cast<std::size_t>(column) * static_cast<std::size_t>(b_ + 1) +
                  static_cast<std::size_t>(row - column)];
    }

    /// In place. False when the matrix is not positive definite (a pivot below 1e-10 of the largest diagonal entry).
    bool factor() noexcept;

    /// x (n) in place: A x = rhs.
    void solve(double* x) const noexcept;

   private:
    int n_, b_;
    std::vector<double> a_;  ///< column by column: diagonal, then what is below it
};

/// Where the free degrees of freedom of a mesh stand in a banded matrix. A law that treats both axes alike and apart
/// (isotropic) needs one number a node; others two.
struct FreeNumbering {
    explicit FreeNumbering(const RealtimeMesh& mesh);

    int per_node;             ///< 1 or 2
    std::vector<int> number;  ///< of a node among the free nodes, -1 where fixed (N)
    int order, half_bandwidth;
    std::vector<int> free_slots;  ///< slots with at least one free node
};

/// A += scale * K(theta) at u on the free nodes, A laid out by the numbering.
void add_stiffness(const RealtimeMesh& mesh, const FreeNumbering& numbering, const Eigen::VectorXd& theta,
                   const NodeColumns& u, double scale, bool convex, BandCholesky& A) noexcept;

}  // namespace tissue
