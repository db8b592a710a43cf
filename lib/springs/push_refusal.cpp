#include "springs/push_refusal.h"

#include <fmt/format.h>

#include <algorithm>

#include "mesh/facet.h"

namespace tissue {
namespace {

// least cosine to the inward normal: admits rounding of a displacement along the surface
constexpr double outward = -1e-6;

bool near_held_facet(const SpringMesh& mesh, const FreeSurface& surface, const Point& contact_m, double off_surface_m) {
    for (Eigen::Index f = 0; f < surface.fixed_facets_of_surface().rows(); ++f)
        if (nearest_on_facet(mesh.nodes, surface.fixed_facets_of_surface(), f, contact_m).distance_m <= off_surface_m) return true;
    return false;
}

/// Whether the place is at a fixed node or between fixed nodes, where the free surface ends.
bool on_held_nodes(const SpringMesh& mesh, const FreeSurface& surface, const FreeSurface::Place& at) {
    const FacetPoint point = nearest_on_facet(mesh.nodes, surface.facets(), at.facet, at.point_m);
    for (Eigen::Index k = 0; k < surface.facets().cols(); ++k)
        if (point.weight[k] > 1e-9 && !std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), surface.facets()(at.facet, k))) return false;
    return true;
}

std::string refusal_at(const SpringMesh& mesh, const FreeSurface& surface, const Point& contact_m, double off_surface_m, FreeSurface::Place& at) {
    if (contact_m.size() != mesh.dimension()) return fmt::format("is not of {} axes", mesh.dimension());
    if (!contact_m.allFinite()) return "has a number that is not finite";
    at = surface.nearest(contact_m);
    if (at.distance_m > off_surface_m) {
        if (near_held_facet(mesh, surface, contact_m, off_surface_m)) return "is on a fixed part";
        return fmt::format("is {:.3g} mm off the surface, more than {:g} mm", 1e3 * at.distance_m, 1e3 * off_surface_m);
    }
    return on_held_nodes(mesh, surface, at) ? "is on a fixed part" : "";
}

}  // namespace

std::string contact_refusal(const SpringMesh& mesh, const FreeSurface& surface, const Point& contact_m, double off_surface_m) {
    FreeSurface::Place at;
    return refusal_at(mesh, surface, contact_m, off_surface_m, at);
}

std::string push_refusal(const SpringMesh& mesh, const FreeSurface& surface, const Point& contact_m, const Point& push_m, double off_surface_m, bool may_pull) {
    if (push_m.size() != mesh.dimension()) return fmt::format("is not of {} axes", mesh.dimension());
    if (!push_m.allFinite()) return "has a number that is not finite";
    FreeSurface::Place at;
    if (std::string why = refusal_at(mesh, surface, contact_m, off_surface_m, at); !why.empty()) return why;
    return !may_pull && push_m.dot(at.inward) < outward * push_m.norm() ? "has a tool displacement out of the tissue" : "";
}

}  // namespace tissue
