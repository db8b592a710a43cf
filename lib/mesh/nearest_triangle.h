#pragma once

#include <vector>

#include "mesh/surface.h"

namespace tissue {

/// Finds the nearest point of a surface, with a grid of boxes that list their triangles.
class NearestTriangle {
   public:
    explicit NearestTriangle(const Surface& surface);

    struct Place {
        Eigen::Index triangle;   ///< -1: no triangle has such a normal
        Eigen::Vector3d weight;  ///< of the triangle's nodes
        Eigen::Vector3d point_m;
        double distance_m;
    };
    /// The nearest point [m]. outward: a unit vector; only triangles with a normal within 78 degrees of it count. A
    /// zero vector, the default, takes all triangles.
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
    std::vector<std::vector<int>> inside_;  ///< triangles whose bounding box overlaps each box
};

}  // namespace tissue
