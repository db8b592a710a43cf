#include "mesh/cube_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "error.h"

namespace tissue {

CubeWeights cube_weights(const Eigen::Vector3d& at) noexcept {
    CubeWeights weight;
    for (int k = 0; k < 8; ++k) {
        weight[k] = 1;
        for (int d = 0; d < 3; ++d) weight[k] *= (k >> d & 1) ? at[d] : 1 - at[d];
    }
    return weight;
}

CubeSearch::CubeSearch(const NodeField& nodes, const Cells& cubes, double spacing_m) : spacing_m_(spacing_m) {
    constexpr double most_places = 1e6;  // embedded_lattice makes boxes of at most 200,000
    const NodeField low = nodes(cubes.col(0), Eigen::all);
    origin_m_ = low.colwise().minCoeff().transpose();
    const NodeField place = (low.rowwise() - origin_m_.transpose()) / spacing_m;
    const Eigen::RowVector3d size = place.colwise().maxCoeff().array().round() + 1;
    if (!(size.prod() <= most_places)) throw MismatchError(fmt::format("cubes of {:g} mm are in a box of {:g} cubes; at most {:g} are possible", 1e3 * spacing_m, size.prod(), most_places));
    for (std::size_t d = 0; d < 3; ++d) size_[d] = static_cast<int>(size[static_cast<Eigen::Index>(d)]);
    cube_.assign(static_cast<std::size_t>(size.prod()), -1);
    for (Eigen::Index c = 0; c < cubes.rows(); ++c) {
        const Eigen::RowVector3d whole = place.row(c).array().round();
        for (int k = 0; k < 8; ++k) {
            const Eigen::RowVector3d corner = whole + Eigen::RowVector3d(k & 1, k >> 1 & 1, k >> 2);
            if (!(((nodes.row(cubes(c, k)) - origin_m_.transpose()) / spacing_m - corner).cwiseAbs().maxCoeff() < 1e-6))
                throw MismatchError(fmt::format("corner {} of cube {} is not on a lattice of {:g} mm", k, c, 1e3 * spacing_m));
        }
        cube_[index({static_cast<int>(whole[0]), static_cast<int>(whole[1]), static_cast<int>(whole[2])})] = static_cast<int>(c);
    }
}

std::size_t CubeSearch::index(const std::array<int, 3>& place) const noexcept { return static_cast<std::size_t>((place[2] * size_[1] + place[1]) * size_[0] + place[0]); }

int CubeSearch::cube_at(const std::array<int, 3>& place) const noexcept {
    for (std::size_t d = 0; d < 3; ++d)
        if (place[d] < 0 || place[d] >= size_[d]) return -1;
    return cube_[index(place)];
}

CubeSearch::Found CubeSearch::at(const Eigen::Vector3d& place_m) const noexcept {
    const Eigen::Vector3d local = (place_m - origin_m_) / spacing_m_;
    std::array<int, 3> here{}, best{};
    for (std::size_t d = 0; d < 3; ++d)  // clamped just outside the box, so that it fits an int
        here[d] = static_cast<int>(std::floor(std::clamp(local[static_cast<Eigen::Index>(d)], -2.0, size_[d] + 1.0)));
    Found found;
    found.cube = cube_at(here);
    best = here;
    if (found.cube < 0) {
        // the cube over the nearest face: if it has tissue and no other face is as near, all other cubes are farther
        std::array<int, 3> over = here;
        double nearest = std::numeric_limits<double>::infinity();
        bool alone = false;
        for (std::size_t d = 0; d < 3; ++d) {
            const double at = local[static_cast<Eigen::Index>(d)];
            for (const auto& [away, step] : {std::pair(at - here[d], -1), std::pair(here[d] + 1 - at, 1)}) {
                if (away == nearest) alone = false;
                if (!(away < nearest) || away < 0) continue;
                nearest = away;
                alone = true;
                over = here;
                over[d] += step;
            }
        }
        if (const int cube = alone ? cube_at(over) : -1; cube >= 0) {
            found.cube = cube;
            found.away = nearest;
            found.weight = cube_weights(local - Eigen::Vector3d(over[0], over[1], over[2]));
            return found;
        }
        double least = std::numeric_limits<double>::infinity();
        for (int around = 0; around < 27; ++around) {
            const std::array<int, 3> place{here[0] + around % 3 - 1, here[1] + around / 3 % 3 - 1, here[2] + around / 9 - 1};
            const int cube = cube_at(place);
            if (cube < 0) continue;
            const Eigen::Vector3d low(place[0], place[1], place[2]);
            const double away = (local - local.cwiseMax(low).cwiseMin((low.array() + 1).matrix())).norm();
            if (away >= least) continue;
            least = away;
            found.cube = cube;
            best = place;
        }
        if (found.cube < 0) return found;
        found.away = least;
    }
    found.weight = cube_weights(local - Eigen::Vector3d(best[0], best[1], best[2]));
    return found;
}

}  // namespace tissue
