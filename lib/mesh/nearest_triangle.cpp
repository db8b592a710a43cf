#include "mesh/nearest_triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/facet.h"

namespace tissue {

NearestTriangle::NearestTriangle(const Surface& surface) : nodes_(surface.nodes), triangles_(surface.triangles) {
    low_m_ = nodes_.colwise().minCoeff().transpose();
    const Eigen::Vector3d size = Eigen::Vector3d(nodes_.colwise().maxCoeff().transpose()) - low_m_;
    double area = 0;
    for (Eigen::Index t = 0; t < triangles_.rows(); ++t) {
        area += facet_measure(nodes_, triangles_, t);
        normal_.emplace_back(facet_normal(nodes_, triangles_, t));
    }
    box_m_ = std::max(2 * std::sqrt(area / static_cast<double>(triangles_.rows())), size.maxCoeff() / 60);
    for (int j = 0; j < 3; ++j) count_[j] = 1 + static_cast<int>(size[j] / box_m_);
    inside_.resize(static_cast<std::size_t>(count_.prod()));
    for (Eigen::Index t = 0; t < triangles_.rows(); ++t) {
        const Eigen::Vector3d a = nodes_.row(triangles_(t, 0)), b = nodes_.row(triangles_(t, 1)), c = nodes_.row(triangles_(t, 2));
        const Eigen::Vector3i from = box_of(a.cwiseMin(b).cwiseMin(c)), to = box_of(a.cwiseMax(b).cwiseMax(c));
        for (int k = from.z(); k <= to.z(); ++k)
            for (int j = from.y(); j <= to.y(); ++j)
                for (int i = from.x(); i <= to.x(); ++i) inside_[place_of(i, j, k)].push_back(static_cast<int>(t));
    }
}

Eigen::Vector3i NearestTriangle::box_of(const Eigen::Vector3d& position_m) const {
    Eigen::Vector3i box;
    for (int j = 0; j < 3; ++j) box[j] = static_cast<int>(std::clamp(std::floor((position_m[j] - low_m_[j]) / box_m_), 0.0, count_[j] - 1.0));
    return box;
}

NearestTriangle::Place NearestTriangle::nearest(const Eigen::Vector3d& position_m, const Eigen::Vector3d& outward) const {
    Place best{-1, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), std::numeric_limits<double>::infinity()};
    const Eigen::Vector3i middle = box_of(position_m);
    const bool any = outward.squaredNorm() == 0;
    for (int shell = 0; shell <= count_.maxCoeff(); ++shell) {
        const auto reach = [&](int j, int side) { return side < 0 ? std::max(middle[j] - shell, 0) : std::min(middle[j] + shell, count_[j] - 1); };
        for (int k = reach(2, -1); k <= reach(2, 1); ++k)
            for (int j = reach(1, -1); j <= reach(1, 1); ++j)
                for (int i = reach(0, -1); i <= reach(0, 1); ++i) {
                    if (std::max({std::abs(i - middle[0]), std::abs(j - middle[1]), std::abs(k - middle[2])}) != shell) continue;
                    for (int t : inside_[place_of(i, j, k)]) {
                        if (!any && normal_[static_cast<std::size_t>(t)].dot(outward) <= 0.2) continue;
                        const FacetPoint here = nearest_on_facet(nodes_, triangles_, t, position_m);
                        if (!(here.distance_m < best.distance_m)) continue;
                        best.triangle = t;
                        best.weight = here.weight;
                        best.distance_m = here.distance_m;
                    }
                }
        if (best.distance_m <= shell * box_m_) break;  // all further boxes are farther away
    }
    if (best.triangle >= 0)
        for (int i = 0; i < 3; ++i) best.point_m += best.weight[i] * nodes_.row(triangles_(best.triangle, i)).transpose();
    return best;
}

}  // namespace tissue
