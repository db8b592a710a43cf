#pragma once

#include "mesh/cube_search.h"
#include "mesh/spring_mesh.h"
#include "springs/footing.h"

namespace tissue {

/// The surface near a place, as a quadric over its tangent plane: inward depth(x, y) = slope . (x, y) + (x, y) bend (x,
/// y)' / 2 [m], 0 at the place.
struct SurfaceQuadric {
    Eigen::Vector3d place_m, inward;
    Eigen::Matrix<double, 3, 2> tangents;
    Eigen::Vector2d slope;
    Eigen::Matrix2d bend_1_m;

    Eigen::Vector3d at(const Eigen::Vector2d& along_m) const noexcept {
        const double depth_m = slope.dot(along_m) + along_m.dot(bend_1_m * along_m) / 2, most_m = along_m.norm();
        // limited to 45 degrees
        return place_m + tangents * along_m + std::min(std::max(depth_m, -most_m), most_m) * inward;
    }
};

/// Points of a disc's contact on a solid in an embedded lattice. They move with the disc. They do not depend on the
/// nodes of the surface mesh, and on the lattice only through the cubes that carry them. 24 lie under the disc in three
/// rings of equal area, and 36 from the disc's edge to the end of the imprint, also in three rings of equal area. The
/// middle ring of three is rotated by half a step.
/// - imprint: shares are 1/24 each under the disc, and 1/36 (1 - (r / 2.5 R)^2)^2 beyond it.
/// - mean: the same points with radii scaled by m / 2.5 R, where m is the larger of 1.6 cube edges and 1.5 R. Each has
///   as weight its area times (1 - (r / m)^2)^2; the sum is 5/4. It reaches beyond the disc, because a force on the few
///   nodes of the cubes under the disc would indent the lattice far more than the tissue. The tool's force is the one
///   conjugate to d: the integral of p phi, with Hertz's pressure p. That is 4/5 of the integral of p, so the tissue
///   bears 5/4 of the tool's force.
/// The weight of a point outside all tissue decreases with its distance from the nearest cube, and is 0 from one edge
/// on. Its share is then 0 too.
class PolarPoints {
   public:
    static constexpr int under = 24, beyond = 36;
    static constexpr double total = 1.25;  ///< sum of the mean's weights
    /// reach m of the mean: in cube edges, and its least value in radii
    static constexpr double mean_edges = 1.6, mean_radii = 1.5;
    static_assert(under + beyond <= ToolSpring::most_nodes && 2 * 8 * (under + beyond) <= ToolSpring::most_entries, "a cube's corners for each point, of the imprint and of the mean");

    /// reach: of the imprint, in radii.
    PolarPoints(const SpringMesh& mesh, double reach);

    /// reach m of the mean [m]
    double mean_m(double radius_m) const noexcept { return std::max(mean_edges * spacing_m_, mean_radii * radius_m); }

    /// Two unit vectors normal to a unit normal, the axes of the points. They vary continuously with the normal, except
    /// where the surface faces as the fixed one does.
    Eigen::Matrix<double, 3, 2> tangents(const Eigen::Vector3d& inward) const noexcept;

    /// Fills the footing of a disc of that radius [m]. target(from_m, away_m) gives Footing::Point::target. Allocates
    /// nothing.
    template <class Target>
    void lay(const SurfaceQuadric& surface, double radius_m, Target&& target, Footing& footing) const noexcept {
        lay_mean(surface, radius_m, footing);
        const double reach_m = reach_ * radius_m;
        for (int k = 0; k < under + beyond; ++k) {
            const Eigen::Vector3d place_m = surface.at(along_m(k, radius_m));
            const CubeSearch::Found found = search_.at(place_m);
            const Eigen::Vector3d from_m = place_m - surface.place_m;
            // also points of share 0: ToolMemory goes by the number of a point
            Footing::Point& point = footing.point[footing.points++];
            point.target = target(from_m, from_m.norm());
            point.share = share_of(k, from_m.norm() / reach_m) * left_at(found);
            point.begin = footing.entries;
            for (int c = 0; c < 8 && found.cube >= 0; ++c) footing.add(cubes_(found.cube, c), found.weight[c]);
            point.end = footing.entries;
        }
    }

   private:
    static double share_of(int point, double away) noexcept { return point < under ? 1.0 / under : quartic_kernel(away) / beyond; }
    static double left_at(const CubeSearch::Found& found) noexcept { return found.cube < 0 ? 0 : quartic_kernel(found.away); }
    void lay_mean(const SurfaceQuadric& surface, double radius_m, Footing& footing) const noexcept;
    /// Position of a point in the tangent plane [m].
    Eigen::Vector2d along_m(int k, double radius_m) const noexcept {
        const double away_m = radius_m * away_[k];
        return {away_m * direction_(k, 0), away_m * direction_(k, 1)};
    }

    CubeSearch search_;
    Cells cubes_;
    /// columns; the third is opposite to the mean outward normal of the fixed surface
    Eigen::Matrix3d axes_;
    double reach_, spacing_m_;
    /// of each point in the tangent plane
    Eigen::Matrix<double, under + beyond, 2> direction_;
    Eigen::Matrix<double, under + beyond, 1> away_, area_;  ///< in radii, and over the disc's area
};

}  // namespace tissue
