#pragma once

namespace tissue {

constexpr unsigned most_beds = 40;  ///< largest number of different bed stiffnesses in one study

/// Range of the stiffness per area of an elastic bed [Pa/m]. A softer bed hardly supports the tissue, a stiffer one
/// acts as a rigid support.
constexpr double bed_least_Pa_m = 10, bed_most_Pa_m = 1e9;

}  // namespace tissue
