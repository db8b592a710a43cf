#pragma once

#include <Eigen/Core>
#include <array>
#include <map>

#include "mesh/msh_file.h"

namespace tissue {

/// Surface of a ball, normals out: an octahedron with points on the sphere. divisions: how many times each facet is
/// divided into four.
inline MshFile ball_surface(const Eigen::Vector3d& centre, double radius, int divisions) {
    MshFile file;
    file.file = "ball.stl";
    std::vector<Eigen::Vector3d> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<std::array<int, 3>> facets{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int d = 0; d < divisions; ++d) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int i, int j) {
            const auto [place, made] = middles.emplace(std::minmax(i, j), static_cast<int>(points.size()));
            if (made) points.push_back((points[static_cast<std::size_t>(i)] + points[static_cast<std::size_t>(j)]).normalized());
            return place->second;
        };
        std::vector<std::array<int, 3>> finer;
        for (const auto& [i, j, k] : facets) {
            const int a = middle(i, j), b = middle(j, k), c = middle(k, i);
            for (const auto& f : {std::array{i, a, c}, {a, j, b}, {c, b, k}, {a, b, c}}) finer.push_back(f);
        }
        facets = finer;
    }
    for (const Eigen::Vector3d& p : points) {
        const Eigen::Vector3d at = centre + radius * p;
        file.points.push_back({at[0], at[1], at[2]});
    }
    for (const auto& [i, j, k] : facets) file.triangles.push_back({0, {i, j, k}, 0});
    return file;
}

}  // namespace tissue
