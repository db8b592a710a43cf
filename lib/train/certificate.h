#pragma once

#include <Eigen/Core>

#include "train/force_loss.h"
#include "train/optimizer.h"

namespace tissue {

/// What no spring set inside the box can beat, and how far from it a given one is. L^2/2 is convex, so its tangent
/// at any theta lies below it, and the tangent's minimum over the box, which is one term a spring, bounds it from
/// below: Frank and Wolfe 1956, "An algorithm for quadratic programming", Naval Research Logistics Quarterly 3, sec. 3;
/// Boyd and Vandenberghe, "Convex Optimization", 2004, sec. 3.1.3. It holds whoever found theta; it is sharp where
/// theta is optimal.

/// g = d(L^2/2)/dtheta = -(Q^(1/2) A)' residual (S) [N m].
Eigen::VectorXd loss_gradient(const ForceLoss& loss, const Eigen::VectorXd& theta);

/// The tangent's minimum over the box below its value at theta: sum_s max(g_s (theta_s - lo_s), g_s (theta_s - hi_s))
/// [N^2] >= 0; infinite when an infinite side of the box lies downhill. theta inside the box, gradient there (S).
double certificate_slack(const Eigen::VectorXd& gradient, const Eigen::VectorXd& theta, const Box& box);

/// L_lb [N]: L >= L_lb everywhere in the box. theta (S) [N/m] is projected into it first.
double loss_lower_bound(const ForceLoss& loss, const Eigen::VectorXd& theta, const Box& box);

/// gap = (L - L_lb) / max(L_lb, 0.05 sqrt(f_fe' Q f_fe)), not below zero (rounding): zero at the optimum, 0.02 when 2 %
/// may be left to gain. The floor keeps it meaningful where springs can meet the truth exactly.
/// loss, lower_bound, scale (ForceLoss::scale): all in one unit, newtons in every study.
double loss_gap(double loss, double lower_bound, double scale);

/// How far theta (S) is from the conditions of Karush, Kuhn and Tucker: the largest change of weighted force, as a part
/// of |target|, that moving one spring alone to its own best place inside the box would make. Zero at the optimum and
/// only there.
double kkt_residual(const ForceLoss& loss, const Eigen::VectorXd& theta, const Box& box);

}  // namespace tissue
