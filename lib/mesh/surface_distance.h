#pragma once

#include <Eigen/Core>
#include <memory>

#include "mesh/msh_file.h"

namespace tissue {

/// How far places are from the triangles of a surface, by CGAL's tree of boxes. Copies share it.
class SurfaceDistance {
   public:
    /// unit_m [m] is the mesh's unit of length. Throws FileError for a mesh without a triangle that has an area.
    SurfaceDistance(const MshFile& mesh, double unit_m);

    /// >= 0, inside a closed surface too [m]. Any number of threads may ask at once.
    double operator()(const Eigen::Vector3d& place_m) const;

   private:
    struct Tree;
    std::shared_ptr<const Tree> tree_;
};

}  // namespace tissue
