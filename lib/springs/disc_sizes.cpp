#include "springs/disc_sizes.h"

#include <algorithm>
#include <cmath>

namespace tissue {

DiscSizes::Between DiscSizes::between(double radius_m) const noexcept {
    const auto K = static_cast<std::size_t>(radii_m.size());
    std::size_t above = 0;
    while (above + 1 < K && radii_m[static_cast<Eigen::Index>(above)] < radius_m) ++above;
    if (above == 0) return {0, 0, 0};
    const double low = std::log(radii_m[static_cast<Eigen::Index>(above) - 1]), high = std::log(radii_m[static_cast<Eigen::Index>(above)]);
    return {above - 1, above, std::clamp((std::log(radius_m) - low) / (high - low), 0.0, 1.0)};
}

FacetTable DiscSizes::correction_at(double radius_m) const {
    if (correction.empty()) return {};
    const Between at = between(radius_m);
    if (at.above == 0) return correction.front();
    return {(1 - at.part) * correction[at.below].value + at.part * correction[at.above].value};
}

double DiscSizes::correction_at(double radius_m, Eigen::Index facet, const Eigen::Vector3d& weight) const noexcept {
    if (correction.empty()) return 0;
    const Between at = between(radius_m);
    return ((1 - at.part) * correction[at.below].at(facet, weight) + at.part * correction[at.above].at(facet, weight)) * std::min(1.0, radius_m / radii_m[0]);
}

Eigen::VectorXd with_means(const std::vector<double>& given_m) {
    Eigen::VectorXd radii_m(2 * static_cast<Eigen::Index>(given_m.size()) - 1);
    for (std::size_t k = 0; k < given_m.size(); ++k) {
        radii_m[2 * static_cast<Eigen::Index>(k)] = given_m[k];
        if (k > 0) radii_m[2 * static_cast<Eigen::Index>(k) - 1] = std::sqrt(given_m[k - 1] * given_m[k]);
    }
    return radii_m;
}

}  // namespace tissue
