#pragma once

#include <optional>
#include <string>

#include "haptic/device_impedance.h"
#include "haptic/device_map.h"
#include "haptic/friction.h"
#include "haptic/safety.h"
#include "haptic/selector.h"
#include "springs/tool_choice.h"

namespace tissue {

constexpr double longest_dt_s = 0.025;       ///< 40 Hz: half of what a device of C and Python holds a force for
constexpr double slowest_period_s = 0.1;     ///< 10 Hz: of a host whose device holds a force for longer than that

struct HapticOptions {
    double dt_s = 1e-3;               ///< 1 kHz, the paper's rate; 1e-6 to longest_dt_s, and half of what the device holds a force for
    std::optional<double> innovation = {};      ///< gamma of (19), of sets; nothing: 0.05, a new set takes over within about 60 ms
    /// Of critical, at the lowest mode. Nothing: 0.05 for sets, the paper's "very small values"; 0.17 for a law, 5 1/s on the
    /// tissue of `surface`, with which a press comes to rest in the time that a hand takes to notice; 0.01 for a law that relaxes, whose
    /// branches damp (springs in the plane beside it keep 0.17): more makes quick pokes wrong (0.17: twice as wrong, of 0.1 s).
    std::optional<double> damping_ratio = {};
    std::optional<double> coupling_ratio = {};  ///< k_C over the contact's own stiffness, on a mesh of springs; nothing: 10, the tool sinks in by a tenth more
    std::string dynamics = "auto";    ///< or a name of dynamics_kinds()
    std::string sets;                 ///< of the learned mesh: an optimiser of the model, `optimum`; "" is its first. A law has none
    bool heuristic_mesh = true;       ///< Sec. 4.4: a second mesh, Van Gelder's, beside the learned one
    double stiffest = 1;              ///< of a law that learns while it plays: so many times as stiff as it is it may become
    bool energy_book = false;         ///< of a law that relaxes: what its branches store and dissipate is booked; a step takes a little longer
    double place_m = 0;               ///< where the second mesh stands along x; 0: one and a half widths to the right
    SelectBy select_by = SelectBy::displacement;
    int tools = 1;                    ///< devices, each with a tool on the same tissue: 1, or 2 on a law without a mesh beside it
    ToolChoice tool;                  ///< that a law in space plays with (with_tool of springs/law_at_radius.h makes the model)
    FrictionOptions friction;                                            ///< of the tool on the tissue
    SafetyOptions safety;             ///< its dt is taken from here
    DeviceImpedance device;           ///< of the device that the force goes to
    DeviceMap map;
};

/// What holds of these numbers whatever the model is: one set of checks for the programs, C and Python. Throws MismatchError, which names the option.
void check_options(const HapticOptions& options);

}  // namespace tissue
