#pragma once

#include "field.h"

namespace tissue {

/// A push on the top of a solid block (3): tilted so far off the inward normal (0, 0, -1), towards an azimuth about z that
/// is counted from x: (sin tilt cos azimuth, sin tilt sin azimuth, -cos tilt). Components that should be 0 are exactly 0.
Point solid_push(double tilt_deg, double azimuth_deg);

/// The same on any surface, by its unit inward normal n: cos tilt n + sin tilt (cos azimuth t1 + sin azimuth t2), t1 the x axis
/// made tangent (the y axis where n is within 25 degrees of x), t2 = t1 x n. On a block's top t1 is x and t2 is y.
Point surface_push(const Point& inward, double tilt_deg, double azimuth_deg);

}  // namespace tissue
