#pragma once

#include <string>

#include "springs/spring_sets.h"

namespace tissue {

/// States in one sentence how exactly SOFA's springs reproduce a spring law. A spring of its SpringForceField has the
/// force theta (|x_i - x_j| - L0) along the current direction. `geometric` is the same. `isotropic` is exact with
/// springs of zero length and a constant force that balances them at rest. Laws whose springs do not turn have the same
/// stiffness at rest only. Throws MismatchError for an unknown law.
std::string sofa_fidelity(const std::string& law);

/// Why an energy model has no scene. Its springs exist in SOFA, but SOFA's AreaMapping measures single triangles, where
/// a cell or region is the sum of many. Its force fields with a volume are finite elements.
constexpr const char* sofa_lacks = "SOFA has no force field that keeps the area of cells and regions, or the volume of boxes";

/// A SOFA scene (.scn, XML, for releases since 24.06): nodes in the plane z = 0 [m], springs "i j ks kd L0" [N/m, N
/// s/m, m], fixed nodes, node masses [kg], implicit Euler at 1 kHz without gravity or damping. Throws as sofa_fidelity.
std::string sofa_scene(const TissueModel& model, const NamedSet& set);

}  // namespace tissue
