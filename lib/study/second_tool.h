#pragma once

#include "field.h"

namespace tissue {

/// A second disc on the same body, with the radius of the first one. Both displacements grow in proportion, so that
/// both discs reach their depths together.
struct SecondTool {
    Point contact_m;  ///< at rest, on the surface [m] (D)
    Point direction;  ///< unit vector of its displacement (D)
    double depth_m;
};

/// Least distance of the centres of two discs at rest, over their radius. It leaves a gap of a tenth of a radius
/// between the rims for finite elements.
constexpr double least_apart_radii = 2.1;

}  // namespace tissue
