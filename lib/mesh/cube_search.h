#pragma once

#include <array>
#include <vector>

#include "mesh/embedding.h"

namespace tissue {

/// Trilinear weights of a cube's eight corners at a position. at: position from corner 0, in cube edges; outside the
/// cube the weights extrapolate.
using CubeWeights = Eigen::Matrix<double, 1, 8>;
CubeWeights cube_weights(const Eigen::Vector3d& at) noexcept;

/// Finds the cube of an embedded lattice that contains a position.
class CubeSearch {
   public:
    CubeSearch() = default;
    /// nodes: of the mesh [m] (N x 3); cubes: nodes of the corners (C x 8); spacing_m: edge of a cube [m].
    /// Throws MismatchError if the cubes are not whole cubes of one lattice with this spacing, or if their bounding box
    /// has room for more than a million cubes.
    CubeSearch(const NodeField& nodes, const Cells& cubes, double spacing_m);

    struct Found {
        int cube = -1;       ///< -1: no cube with tissue here or among the 26 around
        double away = 0;     ///< distance from that cube, in edges; 0 inside
        CubeWeights weight;  ///< of its corners at the position, sum 1
    };
    /// The cube at a position [m], or the nearest of the 26 around it if there is none. The weights are discontinuous
    /// where two of these are equally near. Allocates nothing.
    Found at(const Eigen::Vector3d& place_m) const noexcept;

   private:
    std::size_t index(const std::array<int, 3>& place) const noexcept;
    int cube_at(const std::array<int, 3>& place) const noexcept;

    Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
    double spacing_m_ = 1;
    std::array<int, 3> size_{};
    std::vector<int> cube_;  ///< number of the cube at each cell of the bounding box, x fastest; -1: none
};

}  // namespace tissue
