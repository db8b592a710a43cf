#pragma once

#include <Eigen/Core>
#include <memory>

#include "mesh/surface.h"

namespace tissue {

/// A part of a solid that has a material of its own: a ball, or what a closed surface encloses. Copies share the surface.
class Inclusion {
   public:
    Inclusion(const Eigen::Vector3d& centre_m, double radius_m);
    /// Source of the test whether a place is inside: CGAL's Side_of_triangle_mesh, with exact predicates.
    explicit Inclusion(const Surface& surface);

    bool contains(const Eigen::Vector3d& place_m) const;
    const Surface* surface() const;                                ///< none of a ball
    const Eigen::Vector3d& centre_m() const { return centre_m_; }  ///< of its volume
    double radius_m() const { return radius_m_; }                  ///< of the ball of its volume
    double volume_m3() const;
    const Eigen::Vector3d& low_m() const { return low_m_; }        ///< of the box about it
    const Eigen::Vector3d& high_m() const { return high_m_; }

   private:
    struct Inside;
    std::shared_ptr<const Inside> inside_;  ///< none of a ball
    Eigen::Vector3d centre_m_, low_m_, high_m_;
    double radius_m_;
};

/// The closed surface of a file, normals out, as an inclusion's. unit_m [m]: of the file's numbers.
/// Throws FileError with the file and the first fault (mesh/surface_report.h) of a surface that cannot be filled.
Surface inclusion_surface(const MshFile& file, double unit_m);

/// The same surface in triangles for finite elements, with sides of about 0.6 of the radius of the ball of its volume, or most_m where that is less: edges of the given
/// triangles are not kept, and it is scaled about its centroid so that it encloses the same volume.
/// Throws MismatchError where it has no triangles of quality 0.1.
Surface inclusion_facets(const Surface& surface, double most_m);

}  // namespace tissue
