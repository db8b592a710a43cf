#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "haptic/contact.h"
#include "haptic/friction.h"
#include "haptic/haptic_options.h"
#include "haptic/safety.h"
#include "springs/tool_spring.h"

namespace tissue {

/// Outcome of a tick for a tool. There is force with `done` only. Recordings and the page's frames contain the numbers.
enum class TickStatus {
    done = 0,
    refused = 1,    ///< the position was not valid or finite, too fast, or too old
    not_armed = 2,  ///< the tool is inside tissue, and was not outside since the start, a fault or a reset
    folded = 3,     ///< a surface crosses itself, or two meshes overlap: there is no inside
    diverged = 4    ///< a mesh diverged, or came to rest inverted, and was put to rest
};

/// Result of a tick for a tool, for the recorder, the page and the tests. Values are those of this tick, unless stated
/// otherwise. Values of a contact have the defaults below while nothing is pressed.
struct TickRecord {
    double time_s = 0;                                   ///< session time
    Eigen::Vector3d device_m = Eigen::Vector3d::Zero();  ///< as the device gave it; if not finite, the last finite one
    Eigen::Vector3d device_N = Eigen::Vector3d::Zero();  ///< force that went out to the device
    Point master_m;                ///< last position that was not refused, in the tissue's space (D)
    Point proxy_m;                 ///< the master where there is no contact (D)
    Point contact_displacement_m;  ///< x_p - X_p of the learned mesh; on an energy model the tool's, x_m - X_p (D)
    Point coupling_N;              ///< f = k_C (x_p - x_m), or that of an energy model's tool; before safety (D)
    Point measured_N;              ///< of the device's force sensor, of its tool on a tissue (D); NaN without a sensor
    int mesh = -1;                ///< pressed mesh; -1: none
    int facet = -1;               ///< pressed facet of its boundary; -1: none
    Eigen::Vector3d weight = Eigen::Vector3d::Zero();  ///< weights of the facet's nodes at the contact
    int set = -1;                 ///< spring set in use; -1 for an energy model
    bool slipping = false;        ///< the contact moved along the surface in this tick
    bool grasp = false;           ///< the tool was to grasp in this tick, or no more in a skipped one after it
    bool grasped = false;         ///< and it holds the tissue
    TickStatus status = TickStatus::done;
    bool reset = false;           ///< before this tick every mesh was put to rest from outside (Simulation::reset)
    bool late = false;            ///< the device had released the force, which restarted at zero (SafetyCounters::late)
    bool overrun = false;         ///< time was lost in this tick (HapticCounters::lost_s); the force is still valid

    bool fault() const { return status == TickStatus::refused; }

    void fields(StateBytes& state) noexcept {
        state(time_s, device_m, device_N, master_m, proxy_m, contact_displacement_m, coupling_N, measured_N, mesh, facet, weight, set, slipping, grasp, grasped, status, reset, late, overrun);
    }
};

/// State of one device and its tool between ticks: motion of the hand, contact of the tool, and the returned force. A
/// session has HapticOptions::tools of them.
struct ToolState {
    ToolState(const HapticOptions& given, int dimension, std::vector<ToolMemory> memory_of_mesh);

    /// Tool displacement [m] (D) of an energy model's tool at tool_m, on a mesh whose origin is at place_m.
    Point push_of(const Point& tool_m, const Point& place_m) const noexcept { return tool_m - place_m - touched_m; }

    /// Predicted position of the hand at the end of the time for which a tick's force is held, period_s [s]. Where
    /// positions come less often than ticks, the hand's velocity is extrapolated in between, but for no longer than the
    /// time between two positions. The age of a position at arrival is added up to dt: farther ahead the noise of the
    /// velocity exceeds its information.
    Point at_the_end(const Point& master_m, double period_s) const noexcept;

    /// Updates the velocity of the master. It is limited to speed-max, and 0 where the motion since the last position
    /// is unknown. moved_m: the master's motion since the last position (D). age_s: age of the new position.
    void follow_hand(const Point& moved_m, double age_s) noexcept;

    void no_contact(const Point& proxy_m) noexcept;
    /// Ends the contact; there is none before the tool has been outside.
    void disarm(const Point& proxy_m) noexcept;
    void forget_taken_over() noexcept;

    /// Takes over the hand, its force, its device and the energy given to it from `from`. The contact stays the one on
    /// this session's tissue.
    void take_over(const ToolState& from, double period_s) noexcept;

    /// Limits the force on an energy model's tissue to what the device can show. Otherwise the tissue would store
    /// energy against which the hand never felt a force, and later give it to the hand. There is no limit where a mesh
    /// of spring sets is touched (on_energy_model false): its coupling has none.
    void show_no_more(bool on_energy_model) noexcept;

    void fields(StateBytes& state) noexcept;

    HapticOptions options;        ///< as they are now
    Safety safety;
    double same_position_s = 0;   ///< time since the device gave a new position
    double old_s = 0;             ///< age of that position at its arrival, dt at most
    double expected_s = 0;        ///< time between its last two measured positions
    double stood_s = 0;           ///< time since the last tick that is no part of the tissue's time
    Eigen::Vector3d device_m = Eigen::Vector3d::Zero();  ///< last position that was not refused
    bool has_master = false;      ///< whether there was one
    bool clutched = false;
    bool grasp_asked = false;     ///< by Simulation::grasp
    bool grasps = false;          ///< the contact is bilateral and does not slip
    long long let_go = 0;         ///< grasps that ended above HapticOptions::grasp_max_N
    bool taken_over = false;      ///< a take-over, and no tick since
    /// of the session that was taken over: its last force where `carried` is above 0, else the difference to it
    Eigen::Vector3d carried_N = Eigen::Vector3d::Zero();
    /// weight of carried_N in the force, while the tool slips to a hand that has moved on
    double carried = 0;
    ContactState contact;
    int touched = -1;             ///< mesh in contact; -1: none
    double coupling_N_m = 0;      ///< k_C of this contact
    ToolSpring spring, changed;   ///< contact of the learned energy model; the same before the model changed
    std::vector<ToolMemory> memory;  ///< its Maxwell branches, on each mesh
    Point at_m;                   ///< the tool at the time to which the touched mesh has advanced (D)
    Point went_m;                 ///< its motion in the step before (D)
    double share = 1;             ///< part of the tool's motion that a slipping contact makes (Simulation::glide)
    Point slid_m;                 ///< on spring sets: sliding displacement since the last step (D)
    Point slide_m_s;              ///< on spring sets: sliding velocity up to that step (D)
    Point velocity_m_s;           ///< of the master (D)
    Point touched_m;              ///< X_p of this contact, in the mesh's own coordinates (D)
    Friction friction;
    bool armed = false;           ///< the master has been outside
    long long contacts = 0;       ///< contacts begun so far; not saved: a restored contact counts as a new one
    long long unarmed = 0;        ///< ticks inside tissue without having been outside
    double untouched_s = 0;       ///< time since this tool or its force was on the meshes
    TickRecord record;
};

}  // namespace tissue
