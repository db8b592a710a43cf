#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptic/contact_stiffness.h"
#include "haptic/device.h"
#include "haptic/dynamics.h"
#include "haptic/haptic_options.h"
#include "haptic/selector.h"
#include "haptic/tool_state.h"
#include "springs/tissue_model.h"

namespace tissue {

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

/// Both limits are on what the device feels: newtons and metres of its own. Throws MismatchError for a mesh that is too stiff for the device, and for a damping or a rate without a mass; allocates for that alone.
void check_device(const DeviceImpedance& device, const DeviceMap& map, double dt_s, const HapticMesh& mesh);

struct HapticCounters {
    long long ticks = 0;
    long long folded = 0;         ///< ticks in which there was no inside, and no force: a surface not simple, in contact the touched one, or two meshes over each other
    long long unstable = 0;       ///< a node not finite, or 1 km away; or a law that nothing touches and that does not come back: meshes put to rest
    double lost_s = 0;            ///< time that passed and that the tissue did not go through: a stall too long to be made up for, or ticks that cost more than their time

    void fields(StateBytes& state) noexcept { state(ticks, folded, unstable, lost_s); }
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
    /// Limits of the device are the state's too, but of a session that has ticked they stay its own. Throws MismatchError for bytes that are not of such a session, or not whole; the session is then as it was. What strangers made is not for it: a
    /// checksum finds accidents alone. The device's force is the saved one too, cut to this session's limit: with a hand on it, restore where the hand was.
    void restore(const std::byte* from, std::size_t size);
    int restores() const { return restores_; }  ///< so far

    /// The options that may change while it runs (`live`, haptic/session_options.h), of these; before the first tick also the device's limits (`limits`); between ticks. A change that moves the tool in the tissue by more than
    /// a hand does in a tick is a new start: it must be outside once. Each tool has its own. Throws MismatchError as HapticModel does, and changes nothing then.
    void change(const HapticOptions& options, int tool = 0);
    const HapticOptions& options(int tool = 0) const { return of(tool).options; }

    /// While it is on, the hand moves and the tool does not: the offset follows, and there is no force. A position that jumps is a fault as ever.
    void clutch(bool on, int tool = 0) noexcept {
        of(tool).clutched = on;
        of(tool).velocity_m_s.setZero();
    }

    /// A session that has not ticked yet: its tool is led to where another's is, whose model may be another, with that one's device: its limits, and the options that may change. That takes some hundred ticks, a time
    /// in which no device can wait: in another thread, after a copy of the session that plays. Throws MismatchError for another number of axes, as change(), and where the tool cannot be led there.
    void follow(const Simulation& from);
    /// After follow(), between two ticks: the hand, its force, its device's limits and impedance, the energy that it was given and counts are those of `from`. What forces differ by fades within some tenths of a second; the
    /// tissue's own energies are of this session. Allocates nothing.
    void take_over(const Simulation& from) noexcept;
    /// Throws MismatchError where take_over() must not be called: for another number of axes, where the device of `from` cannot show this tissue at the force-scale that it has by now, where it lets go of a force too
    /// soon for this session's dt, and where a tool of `from` has begun another contact, or was restored, since it was followed. Allocates where it throws alone.
    void check_take_over(const Simulation& from) const;

    /// One step of Sec. 4: device position in, device force out [N]. elapsed_s: since the last tick, an hour at most; 0 means dt; negative or not
    /// finite: unknown, taken for as long as the device holds a force (force_held_s where it holds it for ever). cost_s: how long the tick before took by the clock that elapsed_s is of; 0: elapsed_s is of no clock,
    /// or nobody knows, and ticks may cost what they will. In it denormals are zero; the caller's floating-point mode is as it was (flush_denormals.h).
    Eigen::Vector3d tick(const DeviceSample& sample, double elapsed_s = 0, double cost_s = 0) noexcept;
    /// The same of every tool: tool_count() samples and forces. Without a sample of its own, as above, a second tool has no force.
    void tick(const DeviceSample* samples, Eigen::Vector3d* force_N, double elapsed_s = 0, double cost_s = 0) noexcept;

    /// In place of a tick: everything stays as it is, the tissue's time too, and no force goes out [N]. passed_s: since the last tick or call of this; a hand may go on meanwhile. The force of
    /// the last tick was on the hand until now: its energy is booked. Two things change all the same: a position that is refused counts and ends the contact, and a sample's reset puts the tissue to rest.
    Eigen::Vector3d stand_still(const DeviceSample& sample, double passed_s) noexcept;
    /// The same of every tool: tool_count() samples and forces.
    void stand_still(const DeviceSample* samples, Eigen::Vector3d* force_N, double passed_s) noexcept;

    // Of what belongs to a tool: which one, 0 to tool_count() - 1.
    int tool_count() const { return static_cast<int>(tools_.size()); }
    const TickRecord& record(int tool = 0) const { return of(tool).record; }
    double went_s() const { return went_s_; }  ///< through which the tissue went in the last tick
    const HapticCounters& counters() const { return counters_; }
    bool has_begun() const { return begun_; }  ///< it has ticked; no state says otherwise
    long long unarmed(int tool = 0) const { return of(tool).unarmed; }  ///< ticks inside tissue, while the master had not been outside since the start or a fault
    const Friction& friction(int tool = 0) const { return of(tool).friction; }
    const Safety& safety(int tool = 0) const { return of(tool).safety; }
    const HapticModel& model() const { return model_; }
    const MeshState& state(std::size_t mesh) const { return states_[mesh]; }
    MeshState& state(std::size_t mesh) { return states_[mesh]; }  ///< to start from another state, between ticks
    const MovingSurface& surface(std::size_t mesh) const { return *surfaces_[mesh]; }
    const ContactState& contact(int tool = 0) const { return of(tool).contact; }
    int set() const { return set_; }                                                 ///< (18)'s l
    /// x_p - X_p of one mesh; of a law how far the tool has pushed it (a ball the mesh beside: by the contact that it has on the touched one). 0 where nothing is pressed (D).
    Point displacement_at_contact(std::size_t mesh, int tool = 0) const noexcept;
    /// Displacement of one mesh's nodes [m] (N x D) with the skin of a law in space while there is a contact (springs/skin.h), of two tools one after the other. The mesh beside the touched one has its own tool
    /// displacement (displacement_at_contact). Allocates nothing where displacement_m has that size.
    void seen(std::size_t mesh, NodeColumns& displacement_m) const noexcept;
    /// Of the learned law, since the start; nothing unless HapticOptions::energy_book. Between ticks.
    BranchBook branches() const { return law() ? law()->branches(states_[0].memory) : BranchBook{}; }
    double kinetic_J() const noexcept;  ///< of the learned mesh
    /// The learned law as it is in this session; nothing of sets.
    const RealtimeLaw* law() const { return laws_[0].get(); }
    RealtimeLaw* law() { return laws_[0].get(); }
    /// Whether the tool stayed behind the hand in the last tick, since the device cannot show the force of a law's tissue.
    bool held_back(int tool = 0) const noexcept { return record(tool).mesh >= 0 && record(tool).coupling_N.norm() >= of(tool).spring.most_N() * (1 - 1e-6); }
    const ToolSpring& tool(int tool = 0) const { return of(tool).spring; }  ///< of a law, where the tool touches it or the other mesh

    /// law() has become another (RealtimeLaw::become): a contact that lasts has its stiffness from now on.
    void law_changed() noexcept;

    /// Puts every mesh to rest; the master must be outside once before there is force again.
    void reset() noexcept;
    double rested_s() const { return rested_s_; }  ///< when they were last put to rest, and remembered nothing

   private:
    ToolState& of(int tool) { return tools_[static_cast<std::size_t>(tool)]; }
    const ToolState& of(int tool) const { return tools_[static_cast<std::size_t>(tool)]; }
    void advance(const DeviceSample* samples, Eigen::Vector3d* force_N, double elapsed_s, double cost_s) noexcept;
    void begin_record(ToolState& t, const DeviceSample& sample, double since_s) noexcept;
    void move_hand(ToolState& t, const DeviceSample& sample, double since_s) noexcept;
    Eigen::Vector3d force_out(ToolState& t, double since_s) noexcept;
    void time_passes(double seconds) noexcept;
    void keep_ticks_short(double since_s, double cost_s) noexcept;
    void fields(StateBytes& state) noexcept;
    struct Way {
        Point outside_m, touched_m, tool_m;  ///< in the tissue's space
    };
    Way way_to(const Simulation& from, int tool) const;
    void lead_to(const Simulation& from, int tool, std::vector<Point>& at_m);
    Point push_of(const ToolState& t, const Point& tool_m, std::size_t mesh) const noexcept { return t.push_of(tool_m, model_.meshes[mesh]->place_m); }
    bool on_law(const ToolState& t) const noexcept { return t.touched >= 0 && laws_[static_cast<std::size_t>(t.touched)]; }
    double untouched_s() const noexcept;
    double steady_s() const noexcept { return std::min({since_[0], since_[1], slowest_period_s}); }
    int steps_due(std::size_t mesh) noexcept;
    void place_surfaces() noexcept;
    void move_surfaces() noexcept;
    bool is_folded(const ToolState& t) const noexcept;
    void stop(ToolState& t) noexcept;
    void rest_meshes() noexcept;
    bool come_to_rest_elsewhere() const noexcept;
    bool put_to_rest() noexcept;
    bool find_contact(ToolState& t) noexcept;
    void begin_contact(ToolState& t, int mesh) noexcept;
    Point end_of(const ToolState& t) const noexcept;
    Point outside_cone(const ToolState& t, const Point& tool_m, const NodeColumns& u) const noexcept;
    struct Slip {
        Point slid_m, drags;  ///< how far the contact went, and the direction in which the force drags it on; zero where it does not slip (D)
        bool went_on;         ///< it slipped in the step before too
    };
    Slip slide(ToolState& t) noexcept;
    Point glide(ToolState& t, const Slip& slip, const Point& to_m, double seconds) noexcept;
    void lay_tool(ToolState& t, const Point& push_m) noexcept;
    void hold_tool(ToolState& t) noexcept;
    bool tool_pushes(const ToolState& t, const Point& tool_m) const noexcept;
    void look_for_contact(ToolState& t, const ContactState& from, int left) noexcept;
    void wait_for_outside(ToolState& t) noexcept;
    void pass_untouched(double seconds) noexcept;
    void select_set(ToolState& t, const Point& on_tissue_N) noexcept;
    void average_stiffness() noexcept;
    void step_meshes() noexcept;
    void stand_on(ToolState& t, std::size_t mesh) noexcept;
    void advance_mesh(std::size_t mesh) noexcept;
    void record_contact(ToolState& t) noexcept;
    ContactLoad load_of(ToolState& t, std::size_t mesh) noexcept;
    void remember_contact(ToolState& t, const Point& tool_m, int steps) noexcept;

    const HapticModel& model_;
    std::vector<std::unique_ptr<RealtimeLaw>> laws_;  ///< of the meshes that have one
    std::vector<ToolState> tools_;
    std::vector<double> due_s_;   ///< how far each mesh is behind a period after now
    std::vector<double> spare_s_; ///< the part of longest_s_ that the ticks before did not use, since a tick goes through whole steps; of each mesh
    double since_[2] = {0, 0};    ///< that passed before the last tick and before this one
    double period_s_;             ///< mean time between ticks: as long as a force is held
    double went_s_ = 0;           ///< through which the meshes went in the last tick
    double cost_[2] = {0, 0};     ///< of a tick, over the time that its meshes went through, the last two; 0: not known
    double usual_s_ = 0;          ///< between ticks; 0: not known yet
    double lost_s_ = 0;           ///< by the mesh that lost most in this tick, of what it owed
    double longest_s_ = 0;        ///< through which meshes may go in this tick
    std::vector<MeshState> states_;
    std::vector<std::unique_ptr<MovingSurface>> surfaces_;
    std::vector<std::unique_ptr<Dynamics>> dynamics_;
    NodeColumns held_;            ///< scratch of a tick without a step (N x D)
    bool simple_[2] = {true, true};  ///< each surface, in this tick: it does not cross itself,
    bool sound_ = true;           ///< and none does
    double rested_s_ = 0;
    bool reset_ = false;          ///< since the last tick
    bool begun_ = false;
    std::vector<long long> followed_;  ///< contact of each tool that follow() led it to, by ToolState::contacts; empty where none was followed
    int set_ = 0;                 ///< (19)'s K_l
    int restores_ = 0;
    HapticCounters counters_;
};

}  // namespace tissue
