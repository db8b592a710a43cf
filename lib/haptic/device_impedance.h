#pragma once

#include <limits>

namespace tissue {

/// Device impedance: mechanical properties, limits and timing of a device. A property that is 0 or infinite by default
/// is then unknown, and no check uses it.
struct DeviceImpedance {
    const char* name = "";
    double mass_kg = 0;                                              ///< apparent mass at the tool, without a hand
    double damping_Ns_m = 0;                                         ///< viscous damping of the device itself
    double stiffness_N_m = std::numeric_limits<double>::infinity();  ///< largest stiffness that it can render
    double force_max_N = std::numeric_limits<double>::infinity();    ///< largest force at its nominal position
    double rate_Hz = std::numeric_limits<double>::infinity();        ///< rate of its positions and forces
    /// Delay from the measurement of a position to the force that is computed from it, in addition to the period of the
    /// tick. It is one servo period where a force goes out in the period after it was written.
    double delay_s = 0;
};

/// Touch, and its predecessor PHANTOM Omni: 45 g, 3.3 N, 1.02 N/mm on its softest axis, by the vendor's data sheet. The
/// sheet gives no damping, so none is assumed. OpenHaptics reads positions and sets forces at 1 kHz. The force computed
/// from a position goes out together with the next position, which is a delay of 1 ms.
inline constexpr DeviceImpedance touch_impedance{"Touch", 0.045, 0, 1020, 3.3, 1000, 1e-3};

/// The least of a family: omega, delta, sigma and lambda of Force Dimension, and Novint Falcon. Force and stiffness are
/// the Falcon's, 8 N and 3 kN/m; the others have more (CHAI3D 3.2, CDeltaDevices.cpp). No source gives mass, damping of
/// the device itself or rate: where the user gives device-mass, contacts are checked for it. The force for a position
/// goes out one servo period later, which is 1 ms where a device answers at 1 kHz, and less where it is faster.
inline constexpr DeviceImpedance force_dimension_impedance{
    "Force Dimension", 0, 0, 3000, 8, std::numeric_limits<double>::infinity(), 1e-3};

/// Haply's Inverse3 and Minverse, the stricter of the two, since which one is there is known too late. Published for the
/// Inverse3: 10 N and 1000 N/m, in Haply's fork of CHAI3D (src/devices/CHaplyDevices.cpp), which calls such figures
/// estimates; stiffness up to 800 N/m in the "Basic Force-Feedback Tutorial" of docs.haply.co. Nothing was found for the
/// Minverse, nor an apparent mass or damping of either. Chosen with care, not measured: 3 N, 800 N/m, 20 g (less than
/// half of a Touch), no damping, 1 kHz. The delay is right where an exchange takes at most 1 ms; statistics count others.
inline constexpr DeviceImpedance haply_impedance{"Inverse3 or Minverse", 0.020, 0, 800, 3, 1000, 1e-3};

/// Combines properties given by a user (`said`) with those of a known device: the user's mass and damping where they
/// are given (not 0), the lower of two limits or rates, the longer of two delays, and the known device's name.
DeviceImpedance stricter(DeviceImpedance said, const DeviceImpedance& known);

/// Largest stiffness of a contact, before the tissue under it moves [N/m], on which a device of this mass and damping
/// is stable in any hand, with a margin for late ticks. device: mass_kg > 0. dt_s: period of the tick [s]. lead: time
/// by which the force of a tick is ahead of the hand [dt]. Returns 0 where no contact is stable.
///
/// Let x_n be the hand's position at tick n. The tool goes on a straight line from its end in the tick before,
/// 2 x_{n-1} - x_{n-2}, to 2 x_n - x_{n-1}. A contact of stiffness K then gives the force
///     F_n = -K (2 lead x_n + (2 - 3 lead) x_{n-1} + (lead - 1) x_{n-2}),
/// which is held for dt. At lead 1 this is a spring K and a damper K dt. The device, a mass and a damper, is stable
/// under this force up to some K: K dt^2 / m = 2/3 at lead 1 without damping of the device. The result is 0.45 of it.
///
/// With a delay of d periods (rounded up to a whole number), and with positions that state their age
/// (DeviceSample::age_s), the tool goes to x_{n-d} + (1 + d) (x_{n-d} - x_{n-d-1}) instead. The limit of K dt^2 / m is
/// then 0.11 at lead 1 and d = 1. With d > 3 no contact counts as stable.
double stable_stiffness_N_m(const DeviceImpedance& device, double dt_s, double lead);

}  // namespace tissue
