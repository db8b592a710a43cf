#pragma once

#include "field.h"

namespace tissue {

/// A second disc on the same body, of the first one's radius. It goes to its depth while the first goes to its own, in proportion.
struct SecondTool {
    Point contact_m;  ///< at rest, on the surface [m] (D)
    Point direction;  ///< unit vector of its push (D)
    double depth_m;
};

/// Least distance of the middles of two discs at rest, over their radius: a gap of a tenth of a radius lies between the rims, which the finite elements of it need.
constexpr double least_apart_radii = 2.1;

}  // namespace tissue
