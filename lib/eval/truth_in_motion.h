#pragma once

#include <optional>
#include <string>
#include <vector>

#include "haptic/simulation.h"
#include "springs/tissue_model.h"

namespace tissue {

/// A contact at which FE knows the force.
struct PressTruth {
    std::string name;
    Point contact_m, direction;  ///< at rest; unit vector of the push
    double magnitude_m;
    std::optional<Point> force_N;   ///< on the tissue; nothing where FE was not asked
};

/// The running simulation pressed at one contact until it rests.
struct PressResult {
    std::string name;
    bool rested = false;                 ///< the force changed by less than 1e-4 of itself in each of the last two half seconds
    std::string reason;                  ///< why there is no comparison; empty when there is one
    Point displacement_m;  ///< the proxy reached; of a law the tool
    Point force_N;         ///< of the tool on the tissue
    Point static_N;        ///< closed-loop answer at that displacement, of sets with the stiffness in use
    double static_error = 0;             ///< |force - static| / |static|
    double off_contact_m = 0;            ///< how far the touched point lies from the contact asked for, at rest
    std::optional<double> fe_error;      ///< |force - FE| / |FE|; nothing where the tool slipped off to another contact
    std::optional<double> static_fe_error;  ///< of the static answer at the FE displacement: what motion cannot mend; infinite without an answer
    bool fe_asked = false;               ///< whether FE knows the force: errors beside it are defined
    std::string set;                     ///< that served in the end
    double seconds = 0;                  ///< of simulated time
    double energy_given_J = 0;
    std::vector<double> time_s, depth_m, curve_N;  ///< along the push, 100 a second
};

/// Moves a virtual hand to the contact and on, until the proxy has come `magnitude_m` along the push, and waits.
/// The hand aims past the contact by what the coupling gives way, and a little deeper so that grazing pushes stay
/// inside; then it creeps until the proxy, of a law the tool, stands where FE's contact does.
PressResult press(const HapticModel& model, const TissueModel& tissue, const PressTruth& truth, double seconds_max = 30);

/// Potential energy and force at a switch of spring sets under a held contact: one jump, or a moving average.
struct SwitchJump {
    double innovation;                     ///< gamma
    std::string from, to;
    std::vector<double> time_s, force_N, energy_J;  ///< after the switch; force along the push
    double energy_jump_J = 0, force_jump_N = 0;     ///< largest change in one tick
    double energy_bound_J = 0;                      ///< gamma |U(to) - U(from)| at the switch: what (19) allows
};

/// Of sets alone. Holds case `from`'s contact at its displacement with set `from`, at rest, then lets set `to` serve.
SwitchJump switch_jump(const TissueModel& tissue, HapticOptions options, int from, int to, double innovation);

}  // namespace tissue
