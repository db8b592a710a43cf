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

/// What a tick came to. All but `done`: no force. Recordings and the page's frames have the numbers.
enum class TickStatus {
    done = 0,
    refused = 1,    ///< the position: not finite, too fast, too old
    not_armed = 2,  ///< the tool is inside tissue, and has not been outside since the start, a fault or a reset
    folded = 3,     ///< a surface crosses itself, or two meshes lie over each other: there is no inside
    diverged = 4    ///< a mesh flew apart, or came to rest inside out, and was put to rest
};

/// What a tick leaves behind, for the recorder, the page and the tests. Nothing in it is older than the tick, but where
/// it says so; what belongs to a contact is as it is here while nothing is pressed.
struct TickRecord {
    double time_s = 0;
    Eigen::Vector3d device_m = Eigen::Vector3d::Zero();  ///< as the device gave it; where not finite, the last that was
    Eigen::Vector3d device_N = Eigen::Vector3d::Zero();
    Point master_m;                ///< of the last position that was not refused (D)
    Point proxy_m;                 ///< the master where there is no contact
    Point contact_displacement_m;  ///< x_p - X_p of the learned mesh; of a law the tool's own, x_m - X_p
    Point coupling_N;              ///< f = k_C (x_p - x_m), or the tool's on a law, before safety
    Point measured_N;              ///< the device's own force sensor, of its tool on a tissue (D); NaN where it has none
    int mesh = -1;                ///< pressed mesh, -1 none
    int facet = -1;               ///< of its boundary,
    Eigen::Vector3d weight = Eigen::Vector3d::Zero();  ///< and of the facet's nodes there
    int set = -1;                 ///< that serves; -1 of a law
    bool slipping = false;        ///< the contact went along the surface in this tick
    TickStatus status = TickStatus::done;
    bool reset = false;           ///< before this tick every mesh was put to rest, by someone outside (Simulation::reset)
    bool late = false;            ///< the device had let go of the force, which began again at zero (SafetyCounters::late)
    bool overrun = false;         ///< time was lost in this tick (HapticCounters::lost_s); the force is the tissue's

    bool fault() const { return status == TickStatus::refused; }

    void fields(StateBytes& state) noexcept {
        state(time_s, device_m, device_N, master_m, proxy_m, contact_displacement_m, coupling_N, measured_N, mesh, facet, weight, set, slipping, status, reset, late, overrun);
    }
};

/// One device and its tool, between ticks: how the hand moves, what the tool touches, and the force that goes back. A session has as many as HapticOptions::tools says.
struct ToolState {
    ToolState(const HapticOptions& given, int dimension, std::vector<ToolMemory> memory_of_mesh);

    /// A law's tool at a place of a mesh that stands at place_m: how far it has pushed there [m].
    Point push_of(const Point& tool_m, const Point& place_m) const noexcept { return tool_m - place_m - touched_m; }

    /// Where the hand will be at the end of the time in which a tick's force is held, period_s. Where its positions come less often than ticks it goes on meanwhile, but
    /// not for longer than from one to the next. Of how old a position was when it came, dt at most: farther ahead the noise of a speed is larger than what it tells.
    Point at_the_end(const Point& master_m, double period_s) const noexcept;

    /// How fast the master is. A hand faster than speed-max is none, nor is one whose way since its last position nobody knows.
    void follow_hand(const Point& moved_m, double age_s) noexcept;

    void no_contact(const Point& proxy_m) noexcept;
    /// No contact, and none before the tool has been outside.
    void disarm(const Point& proxy_m) noexcept;
    void forget_taken_over() noexcept;

    /// The hand, its force, its device and the energy that it was given are those of `from`; the tool is where it is on its own tissue.
    void take_over(const ToolState& from, double period_s) noexcept;

    /// A law's tissue gets no more force than the device can show: else it would store, and later give to the hand, what the hand never felt. Not where springs are touched, whose coupling has no such limit.
    void show_no_more(bool on_law) noexcept;

    void fields(StateBytes& state) noexcept;

    HapticOptions options;        ///< as they are now
    Safety safety;
    double same_position_s = 0;   ///< that the device has said nothing new for
    double old_s = 0;             ///< how old that position was when it came, dt at most
    double expected_s = 0;        ///< between two positions that it measured
    double stood_s = 0;           ///< since the last tick, that is none of the tissue's
    Eigen::Vector3d device_m = Eigen::Vector3d::Zero();  ///< the last position that was good
    bool has_master = false;      ///< there was one
    bool clutched = false;
    bool taken_over = false;      ///< and no tick since
    Eigen::Vector3d carried_N = Eigen::Vector3d::Zero();  ///< of the session that was taken over: its last force where `carried` is above 0, else the difference to it
    double carried = 0;           ///< share of the force that it has where the tool slips to a hand that has moved on
    ContactState contact;
    int touched = -1;             ///< mesh in contact
    double coupling_N_m = 0;      ///< k_C of this contact
    ToolSpring spring, changed;   ///< of this contact, where the learned mesh is a law; and before it became another
    std::vector<ToolMemory> memory;  ///< of it on each mesh
    Point at_m;                   ///< the tool of this contact, at the time to which the touched mesh has come
    Point went_m;                 ///< how far it went in the step before (D)
    double share = 1;             ///< of its tool's way along the surface that a contact which slips makes (Simulation::glide)
    Point slid_m;                 ///< on spring sets: how far the contact has slid since the last step (D)
    Point slide_m_s;              ///< and how fast before it (D)
    Point velocity_m_s;           ///< of the master (D)
    Point touched_m;              ///< X_p of this contact, in the mesh's own coordinates
    Friction friction;
    bool armed = false;           ///< the master has been outside
    long long contacts = 0;       ///< begun so far; not part of a saved state: a restored contact counts as a new one
    long long unarmed = 0;        ///< ticks in which it was inside tissue and had not been outside
    double untouched_s = 0;       ///< since this tool or its force was on the meshes
    TickRecord record;
};

}  // namespace tissue
