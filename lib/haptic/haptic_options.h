#pragma once

#include <limits>
#include <optional>
#include <string>

#include "haptic/device_impedance.h"
#include "haptic/device_map.h"
#include "haptic/friction.h"
#include "haptic/safety.h"
#include "haptic/selector.h"
#include "springs/tool_choice.h"

namespace tissue {

/// Longest dt, 40 Hz: half of the time for which a device in C or Python keeps a force by default.
constexpr double longest_dt_s = 0.025;
/// Longest time between ticks that a session follows, 10 Hz. The device must keep a force for longer than that.
constexpr double slowest_period_s = 0.1;

/// Options of a session. HapticModel refuses options that have no effect with its model.
struct HapticOptions {
    /// Period of a tick; 1 kHz is the paper's rate. From 1e-6 s to longest_dt_s, and at most half of safety.hold_s.
    double dt_s = 1e-3;
    /// Smoothing gain gamma of (19), for spring sets. Empty: 0.05, with which a new set takes over within about 60 ms.
    std::optional<double> innovation = {};
    /// Damping over critical damping, at the lowest mode. Empty:
    ///   0.05 for spring sets: the paper's "very small values";
    ///   0.17 for an energy model, 5 1/s in study `surface`: the tissue comes to rest before a hand notices;
    ///   0.01 for one that relaxes, since its Maxwell branches damp. There 0.17 doubles the error of an indentation of
    ///   0.1 s. Spring sets beside such a model, in the plane, keep 0.17.
    std::optional<double> damping_ratio = {};
    /// k_C over the contact's own stiffness, for spring sets. Empty: 10, with which the tool goes a tenth deeper.
    std::optional<double> coupling_ratio = {};
    std::string dynamics = "auto";    ///< time integration: `auto` or a name of dynamics_kinds()
    /// Spring sets of the learned mesh: an optimiser of the model, or `optimum`. "": the model's first. None for an
    /// energy model.
    std::string sets;
    bool heuristic_mesh = true;       ///< Sec. 4.4: a second mesh, Van Gelder's, beside the learned one
    double stiffest = 1;              ///< factor by which an energy model may become stiffer in the session
    bool energy_book = false;         ///< energy log of the Maxwell branches; a step then takes a little longer
    double place_m = 0;               ///< position of the second mesh along x [m]; 0: 1.5 widths of the tissue
    SelectBy select_by = SelectBy::displacement;
    int tools = 1;                    ///< number of devices and tools; 2 only on an energy model without a second mesh
    ToolChoices tool = {ToolChoice()};  ///< in space, on an energy model: of each tool, or one for all
    double grasp_max_N = std::numeric_limits<double>::infinity();  ///< a grasp lets go above this force on the tissue
    FrictionOptions friction;                                            ///< between tool and tissue
    SafetyOptions safety;             ///< its dt_s is set from dt_s above
    DeviceImpedance device;           ///< of the device that gets the force
    DeviceMap map;
};

/// Checks that do not depend on the model, for the programs, C and Python alike. Throws MismatchError, which names the
/// option.
void check_options(const HapticOptions& options);

}  // namespace tissue
