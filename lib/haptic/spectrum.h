#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "haptic/band_cholesky.h"
#include "haptic/realtime_mesh.h"

namespace tissue {

/// The largest eigenvalue of M^-1 K(theta) [1/s^2] over the free nodes at rest, from above: Lanczos' value plus its
/// residual, so that it is never too small. theta by slot. It is convex in theta, so the largest of several spring
/// sets bounds every moving average of them. A spring that turns is never stiffer than an isotropic one: that bound is
/// taken for it.
double largest_eigenvalue(const RealtimeMesh& mesh, const Eigen::VectorXd& theta);

/// The same of a tangent, as TissueEnergy::tangent lays it out [N/m] (N*D x N*D).
double largest_eigenvalue(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent);

/// The smallest of that [1/s^2], 0 where it is not positive definite; of any masses of the same nodes, for one factorisation of the tangent.
class SlowestMode {
   public:
    SlowestMode(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent);
    double of(const Eigen::VectorXd& node_mass_kg) const;  ///< (N)

   private:
    std::vector<int> node_;  ///< of each free degree of freedom
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
};

/// Of the mesh's own masses.
double smallest_eigenvalue(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent);

/// The smallest eigenvalue of M^-1 K(theta) at rest [1/s^2] by inverse iteration, 0 when K is not positive definite:
/// the mesh can move for nothing.
double smallest_eigenvalue(const RealtimeMesh& mesh, const Eigen::VectorXd& theta);

}  // namespace tissue
