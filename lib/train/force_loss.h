#pragma once

#include <Eigen/Core>

#include "springs/spring_law.h"

namespace tissue {

/// The paper's (9) for one load case: L(theta) = sqrt((f_fe - A theta)' Q (f_fe - A theta)) [N], Q diagonal.
/// Convex in theta; L^2/2 is quadratic.
class ForceLoss {
   public:
    /// A (N*D x S) [m], force f_fe (N*D) [N], weight: the diagonal of Q (N*D), not negative.
    /// Throws MismatchError when the sizes disagree.
    ForceLoss(const SparseMatrix& A, const Eigen::VectorXd& force, const Eigen::VectorXd& weight);

    /// The loss with more rows, L^2 + |extra theta - wanted|^2, reported in the unit of this one: what is minimised where a ridge
    /// or more stands beside (9). extra (M x S), wanted (M).
    ForceLoss with_rows(const SparseMatrix& extra, const Eigen::VectorXd& wanted) const;

    /// L(theta) [N]; theta (S) [N/m]. Allocates nothing after the first call of `workspace`'s size.
    double operator()(const Eigen::VectorXd& theta, Eigen::VectorXd& workspace) const;
    double operator()(const Eigen::VectorXd& theta) const;

    /// sqrt(f_fe' Q f_fe) [N], the unit of rel_loss: the loss of no springs at all, before any rows were added.
    double scale() const { return scale_; }

    /// L(theta) / scale; NaN where the case has no force, to which nothing is relative.
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
