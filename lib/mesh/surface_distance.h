#pragma once

#include <Eigen/Core>
#include <memory>

#include "mesh/msh_file.h"

namespace tissue {

/// Distance of positions from the triangles of a surface, by CGAL's AABB tree. Copies share the tree.
class SurfaceDistance {
   public:
    /// unit_m: the mesh's unit of length [m]. Throws FileError if no triangle of the mesh has an area.
    SurfaceDistance(const MshFile& mesh, double unit_m);

    /// Distance of a position [m], >= 0 also inside a closed surface. Safe to call from several threads.
    double operator()(const Eigen::Vector3d& place_m) const;

   private:
    struct Tree;
    std::shared_ptr<const Tree> tree_;
};

}  // namespace tissue
