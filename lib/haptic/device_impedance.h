#pragma once

#include <limits>

namespace tissue {

/// What a device is to the hand and to the loop, as data. 0, or infinite: not known, and nothing is checked with it.
struct DeviceImpedance {
    const char* name = "";
    double mass_kg = 0;                                              ///< apparent, at the tool, with nobody's hand on it
    double damping_Ns_m = 0;                                         ///< of its own
    double stiffness_N_m = std::numeric_limits<double>::infinity();  ///< the largest that it can show
    double force_max_N = std::numeric_limits<double>::infinity();    ///< at its nominal position
};

/// A Touch, and its predecessor the PHANTOM Omni: mass 45 g, 3.3 N, 1.02 N/mm on its softest axis by the vendor's data sheet. The sheet has no damping;
/// 0.2 Ns/m is assumed, and nothing here relies on it.
inline constexpr DeviceImpedance touch_impedance{"Touch", 0.045, 0.2, 1020, 3.3};

/// A contact that answers a hand with K at once is stable on a device of mass m, whatever hand holds it, up to K dt^2 / m = 2/3: a spring K and a damper K dt beside it,
/// force held for dt, on a mass (Jury's criterion on z^3 + (-2 + (a + b) / 2) z^2 + (1 + a / 2) z - b / 2 with a = K dt^2 / m and b = a). Less than half of it
/// is asked for: ticks come late.
constexpr double stable_share = 0.3;

}  // namespace tissue
