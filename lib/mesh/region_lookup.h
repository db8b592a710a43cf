#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mesh/shape.h"

namespace tissue {

/// Which of some physical volumes of a mesh of tetrahedra a place lies in: finite elements, which have a mesh a path, ask the
/// shape's own.
class RegionLookup {
   public:
    /// regions: names of physical volumes; unit_m [m] is the mesh's unit of length.
    /// Throws FileError where the mesh has no tetrahedra, or no volume of a name.
    RegionLookup(const MshFile& mesh, const std::vector<std::string>& regions, double unit_m);
    /// The same of a shape in space.
    explicit RegionLookup(const Shape& shape);

    /// 0 in none of them, else 1 + its number. A place a little outside, where a curved surface is divided otherwise, has the
    /// region of the tetrahedron from whose faces' planes it is least far.
    int at(const Eigen::Vector3d& position_m) const;
    /// The region of the tetrahedron that has the place inside; nothing where none has.
    std::optional<int> inside(const Eigen::Vector3d& position_m) const;

   private:
    struct Tetrahedron {
        Eigen::Vector3d low_m, high_m, origin_m;
        Eigen::Matrix<double, 4, 3> inward;  ///< unit normals of its faces, into it, the first of the one without the origin,
        double far_m;                        ///< which lies so far from there
        int region;
    };
    void add(const Eigen::Matrix<double, 4, 3>& corners_m, int region);
    void sort();

    static double out_of_m(const Tetrahedron& t, const Eigen::Vector3d& position_m);  ///< 0 inside

    std::vector<Tetrahedron> tetrahedra_;  ///< by low_m.x()
    double longest_m_ = 0;                 ///< of them along x
};

/// A mesh of tetrahedra in metres, as MSH 2.2: triangles as they are labelled, tetrahedra 10, or 10 + the region in which their
/// middles lie.
std::string to_msh(const MshFile& mesh, const RegionLookup& regions);

}  // namespace tissue
