#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "haptic/band_cholesky.h"
#include "haptic/realtime_mesh.h"

namespace tissue {

/// The largest eigenvalue of M^-1 K(theta) [1/s^2] over the free nodes at rest, estimated from above: the Lanczos value
/// plus its residual. theta by slot [N/m]. The eigenvalue is convex in theta, so the largest one of several spring sets
/// bounds that of every moving average of them. A spring that turns is never stiffer than an isotropic one, which takes
/// its place here.
double largest_eigenvalue(const RealtimeMesh& mesh, const Eigen::VectorXd& theta);

/// The same for a tangent stiffness [N/m] (N*D x N*D), in the order of TissueEnergy::tangent.
double largest_eigenvalue(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent);

/// The smallest eigenvalue of M^-1 K for a tangent stiffness K [1/s^2]; 0 where K is not positive definite. K is
/// factored once, for any masses of the nodes.
class SlowestMode {
   public:
    SlowestMode(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent);
    double of(const Eigen::VectorXd& node_mass_kg) const;  ///< for these masses (N)

   private:
    std::vector<int> node_;  ///< node of each free degree of freedom
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
};

/// The same with the mesh's own masses.
double smallest_eigenvalue(const RealtimeMesh& mesh, const Eigen::SparseMatrix<double>& tangent);

/// The smallest eigenvalue of M^-1 K(theta) at rest [1/s^2], by inverse iteration. 0 where K is not positive definite,
/// since the mesh has zero-energy modes, and in the plane where the factor of K would need more than 1 GB.
double smallest_eigenvalue(const RealtimeMesh& mesh, const Eigen::VectorXd& theta);

}  // namespace tissue
