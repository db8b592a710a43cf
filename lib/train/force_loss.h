#pragma once

#include <Eigen/Core>

#include "springs/spring_law.h"

namespace tissue {

/// The paper's (9) for one load case: L(theta) = sqrt((f_fe - A theta)' Q (f_fe - A theta)) [N], Q diagonal.
/// Convex in theta; L^2/2 is quadratic.
class ForceLoss {
   public:
    /// A [m] (N*D x S), force f_fe [N] (N*D), weight: the diagonal of Q (N*D), not negative.
    /// Throws MismatchError when the sizes disagree.
    ForceLoss(const SparseMatrix& A, const Eigen::VectorXd& force, const Eigen::VectorXd& weight);

    /// The loss with further rows, L^2 + |extra theta - wanted|^2, with the scale of this one. Used where a ridge or
    /// the reaction is minimised together with (9). extra (M x S), wanted (M).
    ForceLoss with_rows(const SparseMatrix& extra, const Eigen::VectorXd& wanted) const;

    /// L(theta) [N]; theta [N/m] (S). workspace: is resized to the number of rows; no other allocation.
    double operator()(const Eigen::VectorXd& theta, Eigen::VectorXd& workspace) const;
    double operator()(const Eigen::VectorXd& theta) const;

    /// sqrt(f_fe' Q f_fe) [N], the denominator of rel_loss: the loss at theta = 0 without added rows.
    double scale() const { return scale_; }

    /// L(theta) / scale; NaN where the case has no force.
    double relative(const Eigen::VectorXd& theta) const;

    /// Q^(1/2) A (N*D x S) and Q^(1/2) f_fe (N*D), so that L(theta) = |target - matrix theta|.
    const SparseMatrix& matrix() const { return matrix_; }
    const Eigen::VectorXd& target() const { return target_; }

   private:
    SparseMatrix matrix_;
    Eigen::VectorXd target_;
    double scale_;
};

}  // namespace tissue
