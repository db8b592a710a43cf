#pragma once

#include "mesh/cube_search.h"
#include "mesh/spring_mesh.h"
#include "springs/footing.h"

namespace tissue {

/// The surface about a place, as a quadric over its tangent plane: depth(x, y) = slope . (x, y) + (x, y) bend (x, y)' / 2 [m], inward; 0 at the place.
struct SurfaceQuadric {
    Eigen::Vector3d place_m, inward;
    Eigen::Matrix<double, 3, 2> tangents;
    Eigen::Vector2d slope;
    Eigen::Matrix2d bend_1_m;

    Eigen::Vector3d at(const Eigen::Vector2d& along_m) const noexcept {
        const double depth_m = slope.dot(along_m) + along_m.dot(bend_1_m * along_m) / 2, most_m = along_m.norm();
        return place_m + tangents * along_m + std::min(std::max(depth_m, -most_m), most_m) * inward;  // 45 degrees at the most
    }
};

/// Points of a disc's footing on a solid in an embedded lattice: they go with the disc, and depend neither on the nodes of the surface's mesh nor, but for the cubes that move
/// them, on the lattice. 24 lie under the disc, in three rings of equal areas, and 36 beyond it to the imprint's end, likewise; the middle one of three is turned by half a step.
///   imprint  shares: 1/24 each under the disc, 1/36 (1 - (r / 2.5 R)^2)^2 beyond it
///   mean     the same points, farther out or nearer by m / 2.5 R, m = 1.6 edges of a cube and 1.5 R at least: of each its area times (1 - (r / m)^2)^2, 5/4 in all. It reaches
///            beyond the disc, since a force on the few nodes of the cubes under it alone dents the lattice far more than the tissue. The tissue bears 5/4 of the hand's
///            force: of Hertz's pressure p the hand gets what is conjugate to d, the integral of p phi, which is 4/5 of that of p
/// A point beyond all tissue fades with its distance from the nearest cube, and is none at one edge from it: its share is 0 then.
class PolarPoints {
   public:
    static constexpr int under = 24, beyond = 36;
    static constexpr double total = 1.25;  ///< of the mean's weights
    static constexpr double mean_edges = 1.6, mean_radii = 1.5;  ///< the mean reaches so many edges of a cube, and so many radii at least
    static_assert(under + beyond <= ToolSpring::most_nodes && 2 * 8 * (under + beyond) <= ToolSpring::most_entries, "a cube's corners for each point, of the imprint and of the mean");

    /// reach: of the imprint, in radii.
    PolarPoints(const SpringMesh& mesh, double reach);

    double mean_m(double radius_m) const noexcept { return std::max(mean_edges * spacing_m_, mean_radii * radius_m); }  ///< m

    /// Two unit vectors across a unit normal, which points lie along: they turn with it without jumps, but where the surface faces as the held one does.
    Eigen::Matrix<double, 3, 2> tangents(const Eigen::Vector3d& inward) const noexcept;

    /// Fills the footing of a disc of that radius. target(from_m, away_m): Footing::Point's. Allocates nothing.
    template <class Target>
    void lay(const SurfaceQuadric& surface, double radius_m, Target&& target, Footing& footing) const noexcept {
        lay_mean(surface, radius_m, footing);
        const double reach_m = reach_ * radius_m;
        for (int k = 0; k < under + beyond; ++k) {
            const Eigen::Vector3d place_m = surface.at(along_m(k, radius_m));
            const CubeSearch::Found found = search_.at(place_m);
            const Eigen::Vector3d from_m = place_m - surface.place_m;
            Footing::Point& point = footing.point[footing.points++];  // those that fade to none too: what a contact remembers goes by their number
            point.target = target(from_m, from_m.norm());
            point.share = share_of(k, from_m.norm() / reach_m) * left_at(found);
            point.begin = footing.entries;
            for (int c = 0; c < 8 && found.cube >= 0; ++c) footing.add(cubes_(found.cube, c), found.weight[c]);
            point.end = footing.entries;
        }
    }

   private:
    static double share_of(int point, double away) noexcept { return point < under ? 1.0 / under : bell(away) / beyond; }
    static double left_at(const CubeSearch::Found& found) noexcept { return found.cube < 0 ? 0 : bell(found.away); }
    void lay_mean(const SurfaceQuadric& surface, double radius_m, Footing& footing) const noexcept;
    /// Of a point in the tangent plane.
    Eigen::Vector2d along_m(int k, double radius_m) const noexcept {
        const double away_m = radius_m * away_[k];
        return {away_m * direction_(k, 0), away_m * direction_(k, 1)};
    }

    CubeSearch search_;
    Cells cubes_;
    Eigen::Matrix3d axes_;   ///< columns; the third out of the held surface's inside, against its mean normal
    double reach_, spacing_m_;
    Eigen::Matrix<double, under + beyond, 2> direction_;  ///< of each point in the tangent plane
    Eigen::Matrix<double, under + beyond, 1> away_, area_;  ///< in radii, and over the disc's
};

}  // namespace tissue
