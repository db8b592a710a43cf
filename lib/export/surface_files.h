#pragma once

#include <string>

#include "mesh/carried_surface.h"

namespace tissue {

/// One press, for programs that draw: the surface at rest and where it has moved to, as it is seen (springs/skin.h).
struct PressedSurface {
    const CarriedSurface& surface;
    std::string name;        ///< of the case
    NodeField places;        ///< of the surface's vertices under the press [m] (V x 3)
    Point contact_m;         ///< at rest
    Point push_m, force_N;   ///< of the tool on the tissue
};

/// VTK polygonal data (XML, double precision), where the surface is under the press.
///   points  rest_m, displacement_m (V x 3)    field  contact_m, push_m, force_N (3)
std::string surface_vtp(const PressedSurface& press);

/// glTF 2.0 in one binary file: one mesh at rest with normals, in metres, a morph target `pressed`, and an animation of 1 s from rest to it. The standard has y upwards, so the
/// node turns z there. Its `extras` are `case`, and contact_m, push_m and force_N along the tissue's own axes.
/// Source: Khronos Group, glTF 2.0 Specification (2021), 3.6, 3.7.2.2, 3.11, 4.4.
std::string surface_glb(const PressedSurface& press);

}  // namespace tissue
