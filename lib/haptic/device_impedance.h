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
    double rate_Hz = std::numeric_limits<double>::infinity();        ///< at which it measures positions and takes forces
    double delay_s = 0;                                              ///< between the measurement of a position and the force that answers it, besides the tick's own period: one servo period where a force goes out in the period after it was written
};

/// A Touch, and its predecessor the PHANTOM Omni: mass 45 g, 3.3 N, 1.02 N/mm on its softest axis by the vendor's data sheet. The sheet has no damping,
/// and none is relied on. OpenHaptics reads positions and sets forces at 1 kHz; the force that answers a position goes out with the next one.
inline constexpr DeviceImpedance touch_impedance{"Touch", 0.045, 0, 1020, 3.3, 1000, 1e-3};

/// What a user says of a device that is known: his mass and damping where he gives them, of two limits or rates the lower, of two delays the longer.
DeviceImpedance stricter(DeviceImpedance said, const DeviceImpedance& known);

/// The most that a contact may answer a hand with at once [N/m], so that a device of this mass and damping is stable on it, with room for ticks that come late, whatever hand
/// holds the device. lead: how far ahead of the hand, in dt, the force of a tick is. 0 where no contact is stable.
///
/// With x_n the hand at tick n, the tool of that tick goes from where the tick before left it, 2 x_{n-1} - x_{n-2}, straight to 2 x_n - x_{n-1}, and a contact K answers with
///     F_n = -K (2 lead x_n + (2 - 3 lead) x_{n-1} + (lead - 1) x_{n-2}),
/// held for dt; at lead 1 a spring and a damper K dt. A mass and a damper under it are stable up to some K: K dt^2 / m = 2/3 at lead 1 without damping of its own. 0.45 of that is
/// asked for. With a delay of d periods (whole ones, rounded up) and positions that say so (DeviceSample::age_s) the tool goes to x_{n-d} + (1 + d) (x_{n-d} - x_{n-d-1}) instead: at lead 1 and d = 1 up to 0.11.
double stable_stiffness_N_m(const DeviceImpedance& device, double dt_s, double lead);

}  // namespace tissue
