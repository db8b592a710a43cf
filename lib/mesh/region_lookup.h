#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mesh/shape.h"

namespace tissue {

/// Finds the material region of a position, as a physical volume of a mesh of tetrahedra. Finite elements have a mesh
/// of their own for each load path and take their regions from the shape's mesh.
class RegionLookup {
   public:
    /// regions: names of physical volumes; unit_m: the mesh's unit of length [m].
    /// Throws FileError if the mesh has no tetrahedra or lacks a named volume.
    RegionLookup(const MshFile& mesh, const std::vector<std::string>& regions, double unit_m);
    /// The regions of a shape in space.
    explicit RegionLookup(const Shape& shape);

    /// Region at a position [m]: 1 + its index in `regions`, or 0 in the base material. A position outside the mesh has
    /// the region of the tetrahedron from whose face planes it is least far. Some positions are slightly outside,
    /// because FE meshes discretise a curved surface differently.
    int at(const Eigen::Vector3d& position_m) const;
    /// Region of the tetrahedron that contains the position; nothing if none does.
    std::optional<int> inside(const Eigen::Vector3d& position_m) const;

   private:
    struct Tetrahedron {
        Eigen::Vector3d low_m, high_m, origin_m;
        Eigen::Matrix<double, 4, 3> inward;  ///< unit normals of the faces; the first face is opposite to origin_m
        double far_m;                        ///< distance of that face from origin_m
        int region;
    };
    void add(const Eigen::Matrix<double, 4, 3>& corners_m, int region);
    void sort();

    static double out_of_m(const Tetrahedron& t, const Eigen::Vector3d& position_m);  ///< [m]; 0 inside

    std::vector<Tetrahedron> tetrahedra_;  ///< sorted by low_m.x()
    double longest_m_ = 0;                 ///< largest extent along x
};

/// A mesh of tetrahedra in metres, as text in MSH 2.2. Triangles keep their labels. Tetrahedra have the label 10 + the
/// region of their centroid.
std::string to_msh(const MshFile& mesh, const RegionLookup& regions);

}  // namespace tissue
