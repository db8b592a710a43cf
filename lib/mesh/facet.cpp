#include "mesh/facet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace tissue {
namespace {

/// Normal of a triangle, as long as twice its area [m^2].
Eigen::Vector3d twice_area(const NodeField& nodes, const Cells& facets, Eigen::Index f) {
    const Eigen::RowVector3d a = nodes.row(facets(f, 0)), b = nodes.row(facets(f, 1)), c = nodes.row(facets(f, 2));
    return (b - a).cross(c - a).transpose();
}

}  // namespace

FacetPoint nearest_on_facet(const NodeField& nodes, const Cells& facets, Eigen::Index facet, const Point& position_m) {
    const auto on_segment = [&](int i, int j) {  // the weights of i and j are the first two
        const Point from = nodes.row(facets(facet, i)).transpose(), along = nodes.row(facets(facet, j)).transpose() - from;
        const double w = std::clamp((position_m - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
        return FacetPoint{(from + w * along - position_m).norm(), {1 - w, w, 0}};
    };
    if (facets.cols() == 2) return on_segment(0, 1);

    const Eigen::Vector3d a = nodes.row(facets(facet, 0)), b = nodes.row(facets(facet, 1)), c = nodes.row(facets(facet, 2));
    const Eigen::Vector3d normal = twice_area(nodes, facets, facet), p = position_m;
    const double square = normal.squaredNorm();
    const double wa = (c - b).cross(p - b).dot(normal) / square, wb = (a - c).cross(p - c).dot(normal) / square, wc = 1 - wa - wb;
    if (wa >= 0 && wb >= 0 && wc >= 0) return {std::abs((p - a).dot(normal)) / std::sqrt(square), {wa, wb, wc}};
    FacetPoint best{std::numeric_limits<double>::infinity(), {}};
    for (const auto& [i, j] : {std::pair(0, 1), {1, 2}, {2, 0}}) {
        const FacetPoint side = on_segment(i, j);
        if (!(side.distance_m < best.distance_m)) continue;
        best = {side.distance_m, Eigen::Vector3d::Zero()};
        best.weight[i] = side.weight[0];
        best.weight[j] = side.weight[1];
    }
    return best;
}

Point facet_normal(const NodeField& nodes, const Cells& facets, Eigen::Index facet) {
    if (facets.cols() == 3) return twice_area(nodes, facets, facet).normalized();
    const Eigen::RowVector2d along = nodes.row(facets(facet, 1)) - nodes.row(facets(facet, 0));
    return Eigen::Vector2d(along.y(), -along.x()).normalized();
}

double facet_measure(const NodeField& nodes, const Cells& facets, Eigen::Index facet) {
    if (facets.cols() == 3) return twice_area(nodes, facets, facet).norm() / 2;
    return (nodes.row(facets(facet, 1)) - nodes.row(facets(facet, 0))).norm();
}

}  // namespace tissue
