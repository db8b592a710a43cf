#include "train/certificate.h"

#include <algorithm>
#include <cmath>

namespace tissue {

Eigen::VectorXd loss_gradient(const ForceLoss& loss, const Eigen::VectorXd& theta) {
    const Eigen::VectorXd residual = loss.target() - loss.matrix() * theta;
    return -(loss.matrix().transpose() * residual);
}

double certificate_slack(const Eigen::VectorXd& gradient, const Eigen::VectorXd& theta, const Box& box) {
    double slack = 0;
    for (Eigen::Index s = 0; s < gradient.size(); ++s) {
        if (gradient[s] > 0) slack += gradient[s] * (theta[s] - box.lo[s]);
        if (gradient[s] < 0) slack += gradient[s] * (theta[s] - box.hi[s]);
    }
    return slack;
}

double loss_lower_bound(const ForceLoss& loss, const Eigen::VectorXd& theta, const Box& box) {
    const Eigen::VectorXd inside = box.project(theta);
    const double value = loss(inside);
    const double bound = value * value / 2 - certificate_slack(loss_gradient(loss, inside), inside, box);
    return bound > 0 ? std::sqrt(2 * bound) : 0;
}

double loss_gap(double loss, double lower_bound, double scale) {
    if (!(loss > lower_bound)) return 0;  // also where there is no force at all
    return (loss - lower_bound) / std::max(lower_bound, 0.05 * scale);
}

}  // namespace tissue
