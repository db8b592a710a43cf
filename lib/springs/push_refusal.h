#pragma once

#include <string>

#include "mesh/free_surface.h"

namespace tissue {

constexpr double usual_off_surface_m = 0.002;  ///< a contact farther off the free surface is none

/// Why a tool at a contact [m] (D) that goes on by a push [m] (D) is none that a tissue answers: of another number of axes, not finite, off the
/// free surface, on what is held, or out of the tissue. "" where it is one; then the contact is at the surface's nearest point. A push of no
/// length, or along the surface, is one.
std::string push_refusal(const SpringMesh& mesh, const FreeSurface& surface, const Point& contact_m, const Point& push_m, double off_surface_m = usual_off_surface_m);

/// The same without a push.
std::string contact_refusal(const SpringMesh& mesh, const FreeSurface& surface, const Point& contact_m, double off_surface_m = usual_off_surface_m);

}  // namespace tissue
