#include "springs/disc_sizes.h"

#include <algorithm>
#include <cmath>

namespace tissue {

FacetTable DiscSizes::correction_at(double radius_m) const {
    if (correction.empty()) return {};
    const auto K = static_cast<std::size_t>(radii_m.size());
    std::size_t above = 0;
    while (above + 1 < K && radii_m[static_cast<Eigen::Index>(above)] < radius_m) ++above;
    if (above == 0) return correction.front();
    const double low = std::log(radii_m[static_cast<Eigen::Index>(above) - 1]), high = std::log(radii_m[static_cast<Eigen::Index>(above)]);
    const double part = std::clamp((std::log(radius_m) - low) / (high - low), 0.0, 1.0);
    return {(1 - part) * correction[above - 1].value + part * correction[above].value};
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
