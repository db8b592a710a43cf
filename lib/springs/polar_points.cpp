#include "springs/polar_points.h"

#include <cmath>

namespace tissue {

PolarPoints::PolarPoints(const SpringMesh& mesh, double radius_m, double reach)
    : search_(mesh.nodes, mesh.embedding.cubes, mesh.embedding.spacing_m), cubes_(mesh.embedding.cubes), light_(Eigen::VectorXd::Zero(mesh.node_count())), radius_m_(radius_m), reach_m_(reach * radius_m) {
    const double whole_m3 = std::pow(mesh.embedding.spacing_m, 3);
    for (int node = mesh.embedding.node_count(); node < mesh.node_count(); ++node) light_[node] = whole_m3 / mesh.node_measure[node];

    constexpr double pi = 3.14159265358979323846;
    constexpr int rings = 3;
    for (int k = 0; k < under + beyond; ++k) {
        const bool inside = k < under;
        const int in_ring = (inside ? under : beyond) / rings, of = inside ? k : k - under, ring = of / in_ring;
        const double low = inside ? 0 : 1, high = inside ? 1 : reach * reach;  // squares of radii
        const double away_m = radius_m * std::sqrt(low + (high - low) * (ring + 0.5) / rings), angle = 2 * pi * (of % in_ring + 0.5 * (ring % 2)) / in_ring;
        along_m_.row(k) << away_m * std::cos(angle), away_m * std::sin(angle);
    }
}

void PolarPoints::lay_mean(const SurfaceQuadric& surface, Footing& footing) const noexcept {
    footing.entries = footing.points = 0;
    double squares = 0;
    for (int k = 0; k < under; ++k) {
        const Eigen::Vector3d place_m = surface.at(along_m_.row(k).transpose());
        const CubeSearch::Found found = search_.at(place_m);
        const double x = (place_m - surface.place_m).norm() / radius_m_, phi = 1 - x * x / 2, left = left_at(found);
        if (!(left > 0)) continue;
        squares += left * phi * phi;
        for (int c = 0; c < 8; ++c) {
            const int node = cubes_(found.cube, c);
            int at = 0;
            while (at < footing.entries && footing.node[at] != node) ++at;
            if (at == footing.entries) footing.add(node, 0);
            footing.weight[at] += left * phi * found.weight[c];
        }
    }
    footing.means = footing.entries;
    double sum = 0, crowded = 0;
    for (int i = 0; i < footing.means; ++i) {
        footing.weight[i] /= squares;
        sum += footing.weight[i];
        crowded += footing.weight[i] * footing.weight[i] * light_[footing.node[i]];
    }
    footing.mean_sum = sum;
    footing.phase = 0;
    footing.crowd = footing.means > 0 ? std::log(8 * crowded / (sum * sum)) : 0;
}

}  // namespace tissue
