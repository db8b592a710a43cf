#pragma once

#include <string>

#include "mesh/carried_surface.h"

namespace tissue {

/// One indentation, for programs that draw: the surface at rest and displaced, as it is drawn (springs/skin.h).
struct IndentedSurface {
    const CarriedSurface& surface;
    std::string name;        ///< of the load case
    NodeField places;        ///< vertex positions under indentation [m] (V x 3)
    Point contact_m;         ///< at rest
    Point push_m, force_N;   ///< displacement of the tool [m]; its force on the tissue [N]
};

/// VTK polygonal data (XML, double precision) of the displaced surface.
///   points  rest_m, displacement_m (V x 3)
///   field   contact_m, push_m, force_N (3)
std::string surface_vtp(const IndentedSurface& indented);

/// A binary glTF 2.0 file: one mesh at rest with normals, in metres; a morph target `pressed`; an animation of 1 s from
/// rest to it. In glTF y points up, so the node rotates z to y. Its `extras` are `case`, and contact_m, push_m and
/// force_N along the tissue's own axes.
/// Source: Khronos Group, glTF 2.0 Specification (2021), 3.6, 3.7.2.2, 3.11, 4.4.
std::string surface_glb(const IndentedSurface& indented);

}  // namespace tissue
