#pragma once

#include <string>

#include "mesh/free_surface.h"

namespace tissue {

/// largest distance of a contact from the free surface
constexpr double usual_off_surface_m = 0.002;

/// Reason why a contact contact_m [m] (D) with a tool displacement push_m [m] (D) is refused: wrong number of axes, not
/// finite, off the free surface, on fixed nodes, or a displacement out of the tissue. "" if it is accepted; the contact
/// is then the nearest surface point. Zero displacements and displacements along the surface are accepted.
std::string push_refusal(const SpringMesh& mesh, const FreeSurface& surface, const Point& contact_m, const Point& push_m, double off_surface_m = usual_off_surface_m,
                         bool may_pull = false);

/// The same for a contact alone.
std::string contact_refusal(const SpringMesh& mesh, const FreeSurface& surface, const Point& contact_m, double off_surface_m = usual_off_surface_m);

}  // namespace tissue
