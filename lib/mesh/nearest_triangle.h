#pragma once

#include <vector>

#include "mesh/surface.h"

namespace tissue {

/// Nearest point of a surface, by a grid of boxes that know their triangles.
class NearestTriangle {
   public:
    explicit NearestTriangle(const Surface& surface);

    struct Place {
        Eigen::Index triangle;   ///< -1: none faces that way
        Eigen::Vector3d weight;  ///< of its nodes
        Eigen::Vector3d point_m;
        double distance_m;
    };
    /// Among triangles whose normal has a positive part along `outward`, to 78 degrees; a zero vector asks all.
    Place nearest(const Eigen::Vector3d& position_m, const Eigen::Vector3d& outward = Eigen::Vector3d::Zero()) const;

    const Eigen::Vector3d& normal(Eigen::Index triangle) const { return normal_[static_cast<std::size_t>(triangle)]; }

   private:
    Eigen::Vector3i box_of(const Eigen::Vector3d& position_m) const;
    std::size_t place_of(int i, int j, int k) const {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(count_.y()) + static_cast<std::size_t>(j)) * static_cast<std::size_t>(count_.x()) + static_cast<std::size_t>(i);
    }

    NodeField nodes_;
    Cells triangles_;
    std::vector<Eigen::Vector3d> normal_;
    Eigen::Vector3d low_m_;
    double box_m_;
    Eigen::Vector3i count_;
    std::vector<std::vector<int>> inside_;  ///< triangles that reach into each box
};

}  // namespace tissue
