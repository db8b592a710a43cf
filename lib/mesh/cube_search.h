#pragma once

#include <array>
#include <vector>

#include "mesh/embedding.h"

namespace tissue {

/// Trilinear weights of a cube's corners at a place in it, from corner 0 in edges; extrapolated outside it.
using CubeWeights = Eigen::Matrix<double, 1, 8>;
CubeWeights cube_weights(const Eigen::Vector3d& at) noexcept;

/// Which cube of an embedded lattice a place lies in.
class CubeSearch {
   public:
    CubeSearch() = default;
    /// nodes: of the mesh that the cubes are of (N x 3) [m]. Throws MismatchError for cubes that are not whole ones of one lattice with this spacing, or lie in a box of more than a million.
    CubeSearch(const NodeField& nodes, const Cells& cubes, double spacing_m);

    struct Found {
        int cube = -1;       ///< -1: neither here nor among the cubes around is there one with tissue
        double away = 0;     ///< from it, in edges
        CubeWeights weight;  ///< of its corners there, sum 1
    };
    /// The cube at a place [m]; where there is none, the nearest of the 26 around it. At a place equally near two of them the weights jump. Allocates nothing.
    Found at(const Eigen::Vector3d& place_m) const noexcept;

   private:
    std::size_t index(const std::array<int, 3>& place) const noexcept;
    int cube_at(const std::array<int, 3>& place) const noexcept;

    Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
    double spacing_m_ = 1;
    std::array<int, 3> size_{};
    std::vector<int> cube_;  ///< of each place of the box about them, along x first; -1: none
};

}  // namespace tissue
