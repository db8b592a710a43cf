#pragma once

#include "field.h"

namespace tissue {

/// Unit vector of a tool displacement into the top of a solid block (3). tilt_deg is the angle from the inward normal
/// (0, 0, -1), azimuth_deg the angle about z from x: (sin tilt cos azimuth, sin tilt sin azimuth, -cos tilt).
/// Components that are 0 in exact arithmetic are exactly 0.
Point solid_push(double tilt_deg, double azimuth_deg);

/// The same on any surface with the unit inward normal n: cos tilt n + sin tilt (cos azimuth t1 + sin azimuth t2). t1
/// is the tangential part of the x axis, normalised (of the y axis where |n_x| > 0.9, less than 26 degrees from x).
/// t2 = t1 x n. On a block's top t1 is x and t2 is y.
Point surface_push(const Point& inward, double tilt_deg, double azimuth_deg);

}  // namespace tissue
