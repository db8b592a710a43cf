#pragma once

#include <optional>
#include <string>
#include <vector>

#include "haptic/simulation.h"
#include "springs/tissue_model.h"

namespace tissue {

/// FE reference for an indentation in a running simulation.
struct IndentationReference {
    std::string name;
    Point contact_m, direction;  ///< contact at rest; unit vector of the tool displacement (D)
    double magnitude_m;
    std::optional<Point> force_N;   ///< FE force of the tool on the tissue (D); absent without an FE reference
};

/// Result of an indentation in a running simulation, at the time when the force is constant.
struct IndentationResult {
    std::string name;
    bool rested = false;                 ///< the force changed by less than 1e-4 of it in each of the last two 0.5 s
    std::string reason;                  ///< why there is no comparison; empty when there is one
    Point displacement_m;  ///< reached by the proxy; with an energy model by the tool
    Point force_N;         ///< of the tool on the tissue
    Point static_N;        ///< static force at that displacement; spring sets: with the stiffness in use at the end
    double static_error = 0;             ///< |force - static| / |static|
    double off_contact_m = 0;            ///< distance of the touched point from the planned contact, both at rest
    std::optional<double> fe_error;      ///< |force - FE| / |FE|; absent where the tool slipped to another contact
    std::optional<double> static_fe_error;  ///< the same for the static force at the FE displacement; may be infinite
    bool fe_asked = false;               ///< whether there is an FE reference
    std::string set;                     ///< spring set in use at the end
    double seconds = 0;                  ///< simulated time
    double energy_given_J = 0;           ///< energy injected at the port
    std::vector<double> time_s, depth_m, curve_N;  ///< along the tool displacement, 100 samples a second
};

/// Moves a virtual hand to the contact and on, and waits until the force is constant or seconds_max [s] have passed.
/// The target position of the hand allows for the stretch of the virtual coupling. The hand touches 0.3 mm inside the
/// surface, so that a tangential displacement does not leave the tissue. Then the hand is corrected slowly until the
/// displacement of the proxy (with an energy model: of the tool) is the reference's magnitude_m * direction.
IndentationResult indent(const HapticModel& model, const TissueModel& tissue, const IndentationReference& reference, double seconds_max = 30);

/// Potential energy and force after a switch of spring sets at a constant master position: one jump (gamma = 1), or the
/// moving average (19).
struct SwitchJump {
    double innovation;                     ///< smoothing gain gamma of (19)
    std::string from, to;
    std::vector<double> time_s, force_N, energy_J;  ///< after the switch; force along the tool displacement
    double energy_jump_J = 0, force_jump_N = 0;     ///< largest change in one tick
    double energy_bound_J = 0;                      ///< bound of (19): gamma |U(to) - U(from)| at the switch
};

/// For spring sets only. Puts the master at the displaced contact of case `from`, brings the mesh to rest with set
/// `from`, and switches to set `to` with the smoothing gain `innovation`. from, to: indices of load cases.
SwitchJump switch_jump(const TissueModel& tissue, HapticOptions options, int from, int to, double innovation);

}  // namespace tissue
