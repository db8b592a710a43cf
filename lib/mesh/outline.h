#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

/// The free surface of a spring mesh at rest in the plane, as one line with arc length [m]. The line runs
/// counter-clockwise from one end of the fixed part of the boundary to the other.
class Outline {
   public:
    /// Throws MismatchError if the fixed nodes do not leave one connected free surface.
    explicit Outline(const SpringMesh& mesh);

    double length() const { return arc_.back(); }

    /// Nodes of the free surface in order, with the fixed nodes at its two ends, and the arc length of each [m].
    const std::vector<int>& nodes() const { return nodes_; }
    const std::vector<double>& arcs() const { return arc_; }

    /// Arc lengths of the nodes at which the surface turns by more than 45 degrees, ascending. Where it turns by less,
    /// the surface counts as curved.
    std::vector<double> corners() const;

    /// Point at an arc length, clamped to [0, length].
    Eigen::Vector2d position(double arc_m) const;

    /// Unit normal into the tissue. On a curved surface it is interpolated along each segment, and at a node it is the
    /// mean of both segments' normals. Towards a corner it tends to the segment's normal; at the corner it is the mean
    /// of both.
    Eigen::Vector2d inward_normal(double arc_m) const;

    /// Unit vector of a tool displacement at `angle` [rad] from the inward normal, counter-clockwise positive.
    Eigen::Vector2d direction(double arc_m, double angle) const;

    /// Angle [rad] between the inward normal at an arc length and a tool displacement, in (-pi, pi].
    double angle(double arc_m, const Eigen::Vector2d& direction) const;

    /// Arc length of the surface point nearest to a position [m].
    double arc_of(const Eigen::Vector2d& position_m) const;

   private:
    std::size_t segment(double arc_m) const;
    bool is_corner(std::size_t b) const;
    Eigen::Vector2d segment_normal(std::size_t b) const;

    std::vector<int> nodes_;               ///< nodes of the free surface, in order
    std::vector<Eigen::Vector2d> points_;  ///< their rest positions [m]
    std::vector<double> arc_;              ///< arc length of each [m]
};

}  // namespace tissue
