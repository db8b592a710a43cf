#include "mesh/disc_rim.h"
#include "mesh/nearest_triangle.h"

#include <fmt/format.h>

#include <cmath>

#include "error.h"

namespace tissue {
namespace {

constexpr double least_quality = 0.1;  // of a triangle; 1: equilateral
constexpr double beyond_m = 0.002;     // sides are near_m up to this distance beyond the rim
constexpr double most_lost = 0.003;    // largest relative change of volume if edges are not kept
constexpr int rounds = 6;

std::string at(const Eigen::Vector3d& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", p.x(), p.y(), p.z()); }

struct Divided {
    RimmedSurface rimmed;
    Eigen::Vector3d worst_m;  // a corner of the triangle with the least quality
};
Divided divided(const Surface& surface, const DiscRim& disc, const Eigen::Vector3d& contact_m, double crease) {
    SurfaceRemesh mesh(surface, side_length(disc, contact_m), crease);
    mesh.remesh(rounds);
    const int centre = mesh.insert(contact_m);
    mesh.cut(centre, disc.radius_m);
    mesh.remesh(rounds);

    Divided made{{mesh.surface(), contact_m, 1}, contact_m};
    check_fixed_area(surface, made.rimmed.surface);
    for (Eigen::Index t = 0; t < made.rimmed.surface.triangles.rows(); ++t) {
        const Surface& s = made.rimmed.surface;
        const double quality = triangle_quality(s.corner(t, 0), s.corner(t, 1), s.corner(t, 2));
        if (quality < made.rimmed.least_quality) made.rimmed.least_quality = quality, made.worst_m = s.corner(t, 0);
    }
    return made;
}

}  // namespace

SideLength side_length(const DiscRim& disc, const Eigen::Vector3d& contact_m) {
    return {contact_m, disc.radius_m + beyond_m, disc.near_m, disc.far_m};
}

RimmedSurface with_rim(const Surface& surface, const DiscRim& disc) {
    if (!(disc.radius_m > 0) || !(disc.near_m > 0) || !(disc.far_m >= disc.near_m))
        throw MismatchError(fmt::format("the disc's radius and the size near it must be positive, and the size far away at least the size near it: got {}, {}, {} m",
                                        disc.radius_m, disc.near_m, disc.far_m));
    const NearestTriangle::Place place = NearestTriangle(surface).nearest(disc.contact_m);
    if (place.distance_m > 2 * disc.radius_m)
        throw MismatchError(fmt::format("the contact {} is {:.6g} mm off the surface, more than two disc radii", at(disc.contact_m), 1e3 * place.distance_m));
    if (Surface::is_fixed(surface.label[static_cast<std::size_t>(place.triangle)]))
        throw MismatchError(fmt::format("the contact {} is on a fixed part", at(disc.contact_m)));
    Divided made = divided(surface, disc, place.point_m, crease_cosine);
    if (made.rimmed.least_quality < least_quality) {
        Divided smooth = divided(surface, disc, place.point_m, -1);
        // a larger change of volume means that true edges, as of a box, were cut off
        if (std::abs(enclosed_by(smooth.rimmed.surface).volume_m3 / enclosed_by(made.rimmed.surface).volume_m3 - 1) < most_lost) made = smooth;
    }
    if (made.rimmed.least_quality < least_quality)
        throw MismatchError(fmt::format("the surface has poor triangles at {}: quality {:.3g}, needed {}", at(made.worst_m), made.rimmed.least_quality, least_quality));
    return made.rimmed;
}

}  // namespace tissue
