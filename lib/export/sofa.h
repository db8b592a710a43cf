#pragma once

#include <string>

#include "springs/spring_sets.h"

namespace tissue {

/// How true SOFA's springs are to a law, in one sentence. A spring of its SpringForceField is theta (|x_i - x_j| - L0)
/// along the current direction: `geometric` as it is; `isotropic` exactly, as springs of no length whose pull at rest a
/// constant force takes up; laws that do not turn, or that stiffen, at rest alone.
/// Throws MismatchError for an unknown law.
std::string sofa_fidelity(const std::string& law);

/// Why there is no scene of a law. SOFA's springs are the law's, but what could keep an area there, AreaMapping, knows
/// single triangles, where a cell or region is the sum of many; and what has volume there is its own finite elements.
constexpr const char* sofa_lacks = "SOFA has no force field that keeps the area of cells and regions, or the volume of boxes";

/// A SOFA scene (.scn, XML, of releases since 24.06): nodes in the plane z = 0 [m], springs "i j ks kd L0" [N/m, N s/m,
/// m], fixed nodes, node masses [kg], implicit Euler at 1 kHz without gravity or damping. Throws as sofa_fidelity.
std::string sofa_scene(const TissueModel& model, const NamedSet& set);

}  // namespace tissue
