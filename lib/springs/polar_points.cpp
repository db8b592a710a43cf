#include "springs/polar_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace tissue {

PolarPoints::PolarPoints(const SpringMesh& mesh, double reach)
    : search_(mesh.nodes, mesh.embedding.cubes, mesh.embedding.spacing_m), cubes_(mesh.embedding.cubes), reach_(reach), spacing_m_(mesh.embedding.spacing_m) {
    Eigen::Vector3d fixed_area = Eigen::Vector3d::Zero();  // twice the area vector of the fixed surface, outward
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        const auto facet = mesh.facets.row(f);
        if (!std::all_of(facet.begin(), facet.end(), [&](int node) { return std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), node); })) continue;
        const Eigen::Vector3d a = mesh.nodes.row(facet[0]), b = mesh.nodes.row(facet[1]), c = mesh.nodes.row(facet[2]);
        fixed_area += (b - a).cross(c - a);
    }
    if (!(fixed_area.norm() > 0)) fixed_area = -Eigen::Vector3d::UnitZ();
    axes_ = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), -fixed_area).toRotationMatrix();

    constexpr double pi = 3.14159265358979323846;
    constexpr int rings = 3;
    for (int k = 0; k < under + beyond; ++k) {
        const bool inside = k < under;
        const int in_ring = (inside ? under : beyond) / rings, of = inside ? k : k - under, ring = of / in_ring;
        const double low = inside ? 0 : 1, high = inside ? 1 : reach * reach;  // squared radii
        const double angle = 2 * pi * (of % in_ring + 0.5 * (ring % 2)) / in_ring;
        away_[k] = std::sqrt(low + (high - low) * (ring + 0.5) / rings);
        direction_.row(k) << std::cos(angle), std::sin(angle);
        area_[k] = (high - low) / (inside ? under : beyond);
    }
}

Eigen::Matrix<double, 3, 2> PolarPoints::tangents(const Eigen::Vector3d& inward) const noexcept {
    // The third axis is rotated to the outward normal by the smallest angle, and the first two with it.
    const Eigen::Vector3d n = axes_.transpose() * -inward;
    const double a = 1 / std::max(1e-12, 1 + n.z()), across = -n.x() * n.y() * a;
    Eigen::Matrix<double, 3, 2> turned;
    turned.col(0) << 1 - n.x() * n.x() * a, across, -n.x();
    turned.col(1) << across, 1 - n.y() * n.y() * a, -n.y();
    return axes_ * turned;
}

void PolarPoints::lay_mean(const SurfaceQuadric& surface, double radius_m, Footing& footing) const noexcept {
    footing.entries = footing.points = 0;
    const double mean_m = this->mean_m(radius_m), reach_m = reach_ * radius_m;
    double sum = 0;
    for (int k = 0; k < under + beyond; ++k) {
        const Eigen::Vector3d place_m = surface.at(mean_m / reach_m * along_m(k, radius_m));
        const CubeSearch::Found found = search_.at(place_m);
        const double weight = left_at(found) * area_[k] * quartic_kernel((place_m - surface.place_m).norm() / mean_m);
        if (!(weight > 0)) continue;
        sum += weight;
        for (int c = 0; c < 8; ++c) {
            const int node = cubes_(found.cube, c);
            int at = 0;
            while (at < footing.entries && footing.node[at] != node) ++at;
            if (at == footing.entries) footing.add(node, 0);
            footing.weight[at] += weight * found.weight[c];
        }
    }
    footing.means = footing.entries;
    for (int i = 0; i < footing.means; ++i) footing.weight[i] *= total / sum;
}

}  // namespace tissue
