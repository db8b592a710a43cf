#pragma once

#include <Eigen/Core>

#include "train/force_loss.h"
#include "train/optimizer.h"

namespace tissue {

/// Certified lower bound of the loss over all spring sets inside the box, and the distance of a given set from it.
/// L^2/2 is convex, so its tangent at any theta lies below it. The minimum of the tangent over the box (one term for
/// each spring) is therefore a lower bound of L^2/2: Frank and Wolfe 1956, "An algorithm for quadratic programming",
/// Naval Research Logistics Quarterly 3, sec. 3; Boyd and Vandenberghe, "Convex Optimization", 2004, sec. 3.1.3. The
/// bound holds for any theta, by whatever method it was found, and is sharp where theta is optimal.

/// g = d(L^2/2)/dtheta = -(Q^(1/2) A)' residual [N m] (S), at theta [N/m] (S).
Eigen::VectorXd loss_gradient(const ForceLoss& loss, const Eigen::VectorXd& theta);

/// Value of the tangent at theta minus its minimum over the box: sum_s max(g_s (theta_s - lo_s), g_s (theta_s - hi_s))
/// [N^2] >= 0. Infinite where the tangent falls towards an infinite bound. theta [N/m] (S): inside the box; gradient
/// (S): at theta.
double certificate_slack(const Eigen::VectorXd& gradient, const Eigen::VectorXd& theta, const Box& box);

/// L_lb [N]: L >= L_lb everywhere in the box. theta [N/m] (S) is projected onto the box first.
double loss_lower_bound(const ForceLoss& loss, const Eigen::VectorXd& theta, const Box& box);

/// gap = (L - L_lb) / max(L_lb, 0.05 sqrt(f_fe' Q f_fe)), clamped at 0 against rounding. 0 at the optimum; 0.02: the
/// loss may be reduced by up to 2 %. The floor of 5 % keeps the gap meaningful where springs can match the FE reference
/// exactly. loss, lower_bound, scale (ForceLoss::scale): in the same unit, newtons in every study.
double loss_gap(double loss, double lower_bound, double scale);

}  // namespace tissue
