#pragma once

#include <Eigen/Core>
#include <memory>

#include "mesh/surface.h"

namespace tissue {

/// An inclusion: a part of a solid with its own material. It is a ball or the inside of a closed surface. Copies share
/// the surface.
class Inclusion {
   public:
    /// A ball.
    Inclusion(const Eigen::Vector3d& centre_m, double radius_m);
    /// The inside of a closed surface. contains() is then CGAL's Side_of_triangle_mesh with exact predicates.
    explicit Inclusion(const Surface& surface);

    bool contains(const Eigen::Vector3d& place_m) const;
    const Surface* surface() const;                                ///< null for a ball
    const Eigen::Vector3d& centre_m() const { return centre_m_; }  ///< centroid of the volume
    double radius_m() const { return radius_m_; }                  ///< of the ball of equal volume
    double volume_m3() const;
    const Eigen::Vector3d& low_m() const { return low_m_; }        ///< lower corner of the bounding box
    const Eigen::Vector3d& high_m() const { return high_m_; }      ///< upper corner

   private:
    struct Inside;
    std::shared_ptr<const Inside> inside_;  ///< null for a ball
    Eigen::Vector3d centre_m_, low_m_, high_m_;
    double radius_m_;
};

/// The closed surface of a file, normals out, for an inclusion. unit_m: the file's unit of length [m].
/// Throws FileError with the file and the first fault (mesh/surface_report.h) if the surface cannot be filled.
Surface inclusion_surface(const MshFile& file, double unit_m);

/// An inclusion's surface, remeshed for finite elements. Sides are about 0.6 of the radius of the ball of equal volume,
/// or most_m [m] if that is less. Edges of the given triangles are not kept. The result is scaled and moved so that
/// volume and centroid are those of the given surface.
/// Throws MismatchError if a triangle has a quality below 0.1.
Surface inclusion_facets(const Surface& surface, double most_m);

}  // namespace tissue
