#pragma once

namespace tissue {

constexpr unsigned most_beds = 40;  ///< of different stiffness in one study

/// Stiffness per area of an elastic bed [Pa/m]: on a softer one tissue floats, on a stiffer one it is held.
constexpr double bed_least_Pa_m = 10, bed_most_Pa_m = 1e9;

}  // namespace tissue
