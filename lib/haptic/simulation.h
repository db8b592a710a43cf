#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/contact.h"
#include "haptic/contact_stiffness.h"
#include "haptic/device.h"
#include "haptic/device_impedance.h"
#include "haptic/device_map.h"
#include "haptic/dynamics.h"
#include "haptic/friction.h"
#include "haptic/safety.h"
#include "haptic/selector.h"
#include "springs/tissue_model.h"
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
    bool energy_book = false;         ///< of a law that relaxes: what its branches store and burn is booked; a step takes a little longer
    double place_m = 0;               ///< where the second mesh stands along x; 0: one and a half widths to the right
    SelectBy select_by = SelectBy::displacement;
    ToolChoice tool;                  ///< that a law in space plays with (with_tool of springs/law_at_radius.h makes the model)
    FrictionOptions friction;                                            ///< of the tool on the tissue
    SafetyOptions safety;             ///< its dt is taken from here
    DeviceImpedance device;           ///< of the device that the force goes to
    DeviceMap map;
};

/// What holds of these numbers whatever the model is: one set of checks for the programs, C and Python. Throws MismatchError, which names the option.
void check_options(const HapticOptions& options);

/// One mesh as it runs: what belongs to it and does not change.
struct HapticMesh {
    std::string name;                  ///< learned, heuristic
    RealtimeMesh springs;
    Eigen::MatrixXd theta_of_set;      ///< by slot, one column a set [N/m] (P x C); of a law its springs', one column
    std::unique_ptr<RealtimeLaw> law;  ///< nothing where springs alone hold the mesh together
    Point place_m;                     ///< of its origin (D)
    std::string dynamics;              ///< which step runs
    int substeps;                      ///< steps in a period dt
    double contact_damping_s;          ///< ContactLoad::ahead_s of a tool on it
    double lead;                       ///< how far ahead of the hand, in dt, the force of a tick is: stable_stiffness_N_m
    double static_N_m;                 ///< the most that a tool's force is over its displacement, everything at rest
    double contact_N_m;                ///< the most that a contact answers a hand with at once, before the mesh under it moves; of springs k_C
    double largest_eigenvalue_1_s2;    ///< of M^-1 K: over all its sets, the coupling's k_C on its node included; of a law as law_spectrum has it
    double lowest_frequency_Hz;        ///< of the mean set, or of the law at rest; 0 when the mesh can move for nothing
    double damping_1_s;                ///< B = damping M
};

/// Everything that is the same in every tick, for any number of sessions in any threads.
struct HapticModel {
    /// Throws MismatchError as check_options(), for options that would do nothing with this model, such as those of sets where it is a law, and
    /// for a tissue that is too stiff for the device.
    HapticModel(const TissueModel& model, const HapticOptions& options);
    HapticModel(const HapticModel&) = delete;
    HapticModel& operator=(const HapticModel&) = delete;

    std::string study;
    ToolChoice tool;                                  ///< of a law in space, with its radius; else of radius 0
    HapticOptions options;
    std::vector<std::string> set_names;
    std::vector<std::unique_ptr<HapticMesh>> meshes;  ///< the learned one first
    std::unique_ptr<Selector> selector;               ///< of the learned mesh; a law has none
    std::unique_ptr<ContactStiffness> stiffness;      ///< of the first mesh of springs; every one uses it. Nothing where there is none
    Point low_m, high_m;                              ///< box of the learned mesh at rest (D)

    FreeSurface surface;                              ///< at rest
    SpringMesh rest;                                  ///< nodes and boundary of every one of them, at rest

    std::uint64_t fingerprint = 0;                    ///< of all that a session's state means something with

    bool is_law() const { return meshes.front()->law != nullptr; }
    int dimension() const { return rest.dimension(); }
    bool is_solid() const { return rest.is_solid(); }
};

/// Both limits are on what the device feels: newtons and metres of its own. Throws MismatchError for a mesh that is too stiff for the device; allocates for that alone.
void check_device(const DeviceImpedance& device, const DeviceMap& map, double dt_s, const HapticMesh& mesh);

/// What a tick came to. All but `done`: no force.
enum class TickStatus {
    done,
    refused,    ///< the position: not finite, too fast, too old
    not_armed,  ///< the tool is inside tissue, and has not been outside since the start, a fault or a reset
    folded,     ///< a surface crosses itself, or two meshes lie over each other: there is no inside
    diverged    ///< a mesh flew apart, or came to rest inside out, and was put to rest
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
    bool fault = false;           ///< refused
    bool reset = false;           ///< before this tick every mesh was put to rest, by someone outside (reset())
    bool overrun = false;         ///< time was lost in this tick (HapticCounters::lost_s); the force is the tissue's

    void fields(StateBytes& state) noexcept {
        state(time_s, device_m, device_N, master_m, proxy_m, contact_displacement_m, coupling_N, measured_N, mesh, facet, weight, set, slipping, status, fault, reset, overrun);
    }
};

struct HapticCounters {
    long long ticks = 0;
    long long folded = 0;         ///< surface not simple, in contact the touched one, or two meshes over each other: no inside, no force
    long long unstable = 0;       ///< a node not finite, or 1 km away; or a law that nothing touches and that does not come back: meshes put to rest
    double lost_s = 0;            ///< time that passed and that the tissue did not go through: a stall too long to be made up for, or ticks that cost more than their time
    long long unarmed = 0;        ///< inside tissue, but the master has not been outside since the start or a fault

    void fields(StateBytes& state) noexcept { state(ticks, folded, unstable, lost_s, unarmed); }
};

/// The state of one session and its tick. Storage is made in the constructor; tick() allocates nothing, takes no lock,
/// prints nothing and throws nothing.
class Simulation {
   public:
    explicit Simulation(const HapticModel& model);
    Simulation(const Simulation& other);             ///< goes on as the other one does, bit for bit
    Simulation& operator=(const Simulation&) = delete;

    /// All that changes while a session runs, as bytes: where the tissue is and what it remembers, the contact, the law that it has learned, the
    /// options that may change, energy and counts. A session of the same model goes on from them bit for bit, on this version and machine. Always as many.
    std::size_t state_size() const noexcept;
    void save(std::byte* to) const noexcept;
    /// Throws MismatchError for bytes that are not of such a session, or not whole; the session is then as it was. What strangers made is not for it: a
    /// checksum finds accidents alone. The device's force is the saved one too: with a hand on it, restore where the hand was.
    void restore(const std::byte* from, std::size_t size);
    int restores() const { return restores_; }  ///< so far

    /// The options that may change while it runs (`live`, haptic/session_options.h), of these; between ticks. The device's limits stay. A change that moves the tool in the tissue by more than
    /// a hand does in a tick is a new start: it must be outside once. Throws MismatchError as HapticModel does, and changes nothing then.
    void change(const HapticOptions& options);
    const HapticOptions& options() const { return options_; }

    /// While it is on, the hand moves and the tool does not: the offset follows, and there is no force. A position that jumps is a fault as ever.
    void clutch(bool on) noexcept {
        clutched_ = on;
        velocity_m_s_.setZero();
    }

    /// A session that has not ticked yet: its tool is led to where another's is, whose model may be another, with that one's device: its limits, and the options that may change. That takes some hundred ticks, a time
    /// in which no device can wait: in another thread, after a copy of the session that plays. Throws MismatchError for another number of axes, as change(), and where the tool cannot be led there.
    void follow(const Simulation& from);
    /// After follow(), between two ticks: the hand, its force, its device's limits and impedance, the energy that it was given and counts are those of `from`. What forces differ by fades within some tenths of a second; the
    /// tissue's own energies are of this session. Allocates nothing.
    void take_over(const Simulation& from) noexcept;
    /// Throws MismatchError where take_over() must not be called: for another number of axes, where the device of `from` cannot show this tissue at the force-scale that it has by now, and where it lets go of a force too
    /// soon for this session's dt. Allocates where it throws alone.
    void check_take_over(const Simulation& from) const;

    /// One step of Sec. 4: device position in, device force out [N]. elapsed_s: since the last tick, an hour at most; 0 means dt; negative or not
    /// finite: unknown, taken for as long as the device holds a force (force_held_s where it holds it for ever). cost_s: how long the tick before took by the clock that elapsed_s is of; 0: elapsed_s is of no clock,
    /// or nobody knows, and ticks may cost what they will. In it denormals are zero; the caller's floating-point mode is as it was (flush_denormals.h).
    Eigen::Vector3d tick(const DeviceSample& sample, double elapsed_s = 0, double cost_s = 0) noexcept;

    /// In place of a tick: everything stays as it is, the tissue's time too, and no force goes out [N]. passed_s: since the last tick or call of this; a hand may go on meanwhile. The force of
    /// the last tick was on the hand until now: its energy is booked. Two things change all the same: a position that is refused counts and ends the contact, and a sample's reset puts the tissue to rest.
    Eigen::Vector3d stand_still(const DeviceSample& sample, double passed_s) noexcept;

    const TickRecord& record() const { return record_; }
    double went_s() const { return went_s_; }  ///< through which the tissue went in the last tick
    const HapticCounters& counters() const { return counters_; }
    const Friction& friction() const { return friction_; }
    const Safety& safety() const { return safety_; }
    const HapticModel& model() const { return model_; }
    const MeshState& state(std::size_t mesh) const { return states_[mesh]; }
    MeshState& state(std::size_t mesh) { return states_[mesh]; }  ///< to start from another state, between ticks
    const MovingSurface& surface(std::size_t mesh) const { return *surfaces_[mesh]; }
    const ContactState& contact() const { return contact_; }
    int set() const { return set_; }                                                 ///< (18)'s l
    /// x_p - X_p of one mesh; of a law how far the tool has pushed it (a ball the mesh beside: by the contact that it has on the touched one). 0 where nothing is pressed (D).
    Point displacement_at_contact(std::size_t mesh) const noexcept;
    /// Displacement of one mesh's nodes [m] (N x D) with the skin of a law in space while there is a contact (springs/skin.h). The mesh beside the touched one has its own tool
    /// displacement (displacement_at_contact). Allocates nothing where displacement_m has that size.
    void seen(std::size_t mesh, NodeColumns& displacement_m) const noexcept;
    /// Of the learned law, since the start; nothing unless HapticOptions::energy_book. Between ticks.
    BranchBook branches() const { return law() ? law()->branches(states_[0].memory) : BranchBook{}; }
    double kinetic_J() const noexcept;  ///< of the learned mesh
    /// The learned law as it is in this session; nothing of sets.
    const RealtimeLaw* law() const { return laws_[0].get(); }
    RealtimeLaw* law() { return laws_[0].get(); }
    /// Whether the tool stayed behind the hand in the last tick, since the device cannot show the force of a law's tissue.
    bool held_back() const noexcept { return record_.mesh >= 0 && record_.coupling_N.norm() >= tool_.most_N() * (1 - 1e-6); }
    const ToolSpring& tool() const { return tool_; }  ///< of a law, where the tool touches it or the other mesh

    /// law() has become another (RealtimeLaw::become): a contact that lasts has its stiffness from now on.
    void law_changed() noexcept;

    /// Puts every mesh to rest; the master must be outside once before there is force again.
    void reset() noexcept;
    double rested_s() const { return rested_s_; }  ///< when they were last put to rest, and remembered nothing

   private:
    Eigen::Vector3d advance(const DeviceSample& sample, double elapsed_s, double cost_s) noexcept;
    void time_passes(double seconds) noexcept;
    void keep_ticks_short(double since_s, double cost_s) noexcept;
    void fields(StateBytes& state) noexcept;
    void lead_to(const Simulation& from);
    void forget_taken_over() noexcept;
    void follow_hand(const Point& moved_m, double age_s) noexcept;
    void show_no_more() noexcept;
    Point push_of(const Point& tool_m, std::size_t mesh) const noexcept;
    Point tool_at_the_end(const Point& master_m) const noexcept;
    double steady_s() const noexcept { return std::min({since_[0], since_[1], slowest_period_s}); }
    int steps_due(std::size_t mesh) noexcept;
    void place_surfaces() noexcept;
    bool move_surfaces() noexcept;
    void rest_meshes() noexcept;
    bool come_to_rest_elsewhere() const noexcept;
    bool put_to_rest() noexcept;
    bool find_contact(const Point& master_m) noexcept;
    void begin_contact(int mesh, const Point& master_m) noexcept;
    void slide(const Point& master_m) noexcept;
    void lay_tool(const Point& push_m) noexcept;
    void hold_tool(const Point& master_m) noexcept;
    bool tool_pushes(const Point& master_m) const noexcept;
    void look_for_contact(const ContactState& from, int left, const Point& master_m) noexcept;
    void wait_for_outside(const Point& master_m) noexcept;
    void no_contact(const Point& proxy_m) noexcept;
    void disarm(const Point& proxy_m) noexcept;
    void select_set(const Point& on_tissue_N) noexcept;
    void average_stiffness() noexcept;
    Point step_meshes(const Point& master_m) noexcept;
    Point advance_mesh(std::size_t mesh, ContactLoad& load, const Point& master_m) noexcept;
    void remember_contact(const Point& master_m, int steps) noexcept;
    Eigen::Vector3d stop(TickStatus why) noexcept;

    const HapticModel& model_;
    HapticOptions options_;       ///< as they are now
    std::vector<std::unique_ptr<RealtimeLaw>> laws_;  ///< of the meshes that have one
    Safety safety_;
    std::vector<double> due_s_;   ///< how far each mesh is behind a period after now
    std::vector<double> spare_s_; ///< the part of longest_s_ that the ticks before did not use, since a tick goes through whole steps; of each mesh
    double since_[2] = {0, 0};    ///< that passed before the last tick and before this one
    double period_s_;             ///< mean time between ticks: as long as a force is held
    double went_s_ = 0;           ///< through which the meshes went in the last tick
    double cost_[2] = {0, 0};     ///< of a tick, over the time that its meshes went through, the last two; 0: not known
    double usual_s_ = 0;          ///< between ticks; 0: not known yet
    double stood_s_ = 0;          ///< since the last tick, that is none of the tissue's
    double longest_s_ = 0;        ///< through which meshes may go in this tick
    double same_position_s_ = 0;  ///< that the device has said nothing new for
    double old_s_ = 0;            ///< how old that position was when it came, dt at most
    double expected_s_ = 0;       ///< between two positions that it measured
    Eigen::Vector3d device_m_ = Eigen::Vector3d::Zero();  ///< the last position that was good
    bool has_master_ = false;     ///< there was one
    bool clutched_ = false;
    bool taken_over_ = false;     ///< and no tick since
    Eigen::Vector3d carried_N_ = Eigen::Vector3d::Zero();  ///< of the session that was taken over, and fades
    std::vector<MeshState> states_;
    std::vector<std::unique_ptr<MovingSurface>> surfaces_;
    std::vector<std::unique_ptr<Dynamics>> dynamics_;
    ContactState contact_;
    int touched_ = -1;            ///< mesh in contact
    double coupling_N_m_ = 0;     ///< k_C of this contact
    ToolSpring tool_, changed_;   ///< of this contact, where the learned mesh is a law; and before it became another
    std::vector<ToolMemory> tool_memory_;  ///< of it on each mesh
    Point tool_m_;                ///< of this contact, at the time to which the touched mesh has come
    Point velocity_m_s_;          ///< of the master (D)
    Point slid_m_;                ///< how far the contact has gone along the surface since the last step (D)
    Point slide_m_s_;             ///< and how fast before it (D)
    NodeColumns held_;            ///< scratch of a tick without a step (N x D)
    Point touched_m_;             ///< X_p of this contact, in the mesh's own coordinates
    Friction friction_;
    bool armed_ = false;          ///< the master has been outside
    bool sound_ = true;           ///< no surface crosses itself
    double rested_s_ = 0;
    bool reset_ = false;          ///< since the last tick
    double untouched_s_ = 0;      ///< since a tool or its force was on the meshes
    int set_ = 0;                 ///< (19)'s K_l
    int restores_ = 0;
    HapticCounters counters_;
    TickRecord record_;
};

}  // namespace tissue
