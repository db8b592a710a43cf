#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

/// The free surface of a spring mesh at rest as one line: from where it leaves the fixed edge to where it meets it
/// again, counter-clockwise, measured by arc length [m]. Two dimensions.
class Outline {
   public:
    /// Throws MismatchError when the fixed nodes do not leave one connected free surface.
    explicit Outline(const SpringMesh& mesh);

    double length() const { return arc_.back(); }

    /// Nodes of the free surface in order, the held ones at its two ends included, and the arc length of each [m].
    const std::vector<int>& nodes() const { return nodes_; }
    const std::vector<double>& arcs() const { return arc_; }

    /// Arc lengths of the nodes at which the surface turns by more than 45 degrees, ascending. Where it turns by less it
    /// is taken as curved.
    std::vector<double> corners() const;

    /// Point at an arc length, clamped to [0, length].
    Eigen::Vector2d position(double arc_m) const;

    /// Unit normal into the tissue: turning evenly from node to node of a curved surface, at a node the mean of both
    /// sides'; up to a corner that of the segment, at the corner the mean.
    Eigen::Vector2d inward_normal(double arc_m) const;

    /// Push of unit length, `angle` [rad] off the inward normal, counter-clockwise positive.
    Eigen::Vector2d direction(double arc_m, double angle) const;

    /// Angle [rad] of a push off the inward normal at an arc length, in (-pi, pi].
    double angle(double arc_m, const Eigen::Vector2d& direction) const;

    /// Arc length of the surface point nearest to a position.
    double arc_of(const Eigen::Vector2d& position_m) const;

   private:
    std::size_t segment(double arc_m) const;
    bool is_corner(std::size_t b) const;
    Eigen::Vector2d segment_normal(std::size_t b) const;

    std::vector<int> nodes_;               ///< of the free surface, in order
    std::vector<Eigen::Vector2d> points_;  ///< where they are at rest
    std::vector<double> arc_;              ///< arc length of each
};

}  // namespace tissue
