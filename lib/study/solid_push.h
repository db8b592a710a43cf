#pragma once

#include "field.h"

namespace tissue {

/// A push on the top of a solid block (3): tilted so far off the inward normal (0, 0, -1), towards an azimuth about z that
/// is counted from x: (sin tilt cos azimuth, sin tilt sin azimuth, -cos tilt). Components that should be 0 are exactly 0.
Point solid_push(double tilt_deg, double azimuth_deg);

}  // namespace tissue
