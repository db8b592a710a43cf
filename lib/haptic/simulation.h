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

/// One mesh of a session: its constants.
struct HapticMesh {
    std::string name;                  ///< learned, heuristic
    RealtimeMesh springs;
    Eigen::MatrixXd theta_of_set;      ///< by slot, one column per set [N/m] (P x C); of an energy model one column
    std::unique_ptr<RealtimeEnergyModel> energy_model;  ///< the energy model; null on a mesh of spring sets
    Point place_m;                     ///< position of its origin (D)
    std::string dynamics;              ///< time integration in use
    int substeps;                      ///< steps in a period dt
    double contact_damping_s;          ///< ContactLoad::ahead_s of a tool on it
    double lead;                       ///< lead of a tick's force over the hand, in dt (stable_stiffness_N_m)
    double static_N_m;                 ///< largest ratio of tool force to tool displacement, in equilibrium
    /// largest stiffness of a contact while its mesh does not move; on spring sets k_C
    double contact_N_m;
    /// of M^-1 K: over all sets, with k_C of the coupling on its node; of an energy model as in EnergyModelSpectrum
    double largest_eigenvalue_1_s2;
    double lowest_frequency_Hz;        ///< of the mean set, or the energy model at rest; 0: zero-energy modes
    double damping_1_s;                ///< B = damping M
};

/// Everything that is the same in every tick. Any number of sessions may use it, in any threads.
struct HapticModel {
    /// Throws MismatchError as check_options(), for options without effect on this model, such as those of spring sets
    /// on an energy model, as with_tool() (springs/energy_model_at_radius.h) for a tool that it refuses, and for tissue
    /// that is too stiff for the device.
    HapticModel(const TissueModel& model, const HapticOptions& options);
    HapticModel(const HapticModel&) = delete;
    HapticModel& operator=(const HapticModel&) = delete;

    std::string study;
    ToolChoices tools;                                ///< of each tool; in space with its radius, else radius 0
    HapticOptions options;
    std::vector<std::string> set_names;
    std::vector<std::unique_ptr<HapticMesh>> meshes;  ///< the learned one first
    std::unique_ptr<Selector> selector;               ///< of the learned mesh; null for an energy model
    /// of the first mesh of spring sets, used for all of them; null where there is none
    std::unique_ptr<ContactStiffness> stiffness;
    Point low_m, high_m;                              ///< bounding box of the learned mesh at rest (D)

    FreeSurface surface;                              ///< at rest
    SpringMesh rest;                                  ///< nodes and boundary of each mesh, at rest

    bool may_be_pulled = false;  ///< energy model in the plane, or one whose disc was trained to be pulled (ContactCurve::compression)
    /// Whether a tool may grasp: a disc or patch, on such a model; others have no convex energy there.
    bool grasps(int tool = 0) const noexcept { return may_be_pulled && tools[static_cast<std::size_t>(tool)].shape == ToolChoice::Shape::disc; }
    /// Throws MismatchError where it may not, with the causes.
    void check_grasp(int tool = 0) const;

    std::uint64_t fingerprint = 0;                    ///< hash of everything that a session's state depends on

    bool is_energy_model() const { return meshes.front()->energy_model != nullptr; }
    int dimension() const { return rest.dimension(); }
    bool is_solid() const { return rest.is_solid(); }

   private:
    HapticModel(const std::vector<TissueModel>& of_tool, const HapticOptions& options);
};

/// Checks that the device can show a mesh: its static stiffness, and the stiffness of a contact. Both are compared in
/// newtons and metres of the device. Throws MismatchError for a mesh that is too stiff, and for a damping or rate
/// without a mass. Allocates only where it throws.
void check_device(const DeviceImpedance& device, const DeviceMap& map, double dt_s, const HapticMesh& mesh);

struct HapticCounters {
    long long ticks = 0;
    /// ticks without an inside, and so without force: a surface crosses itself (in contact: the touched one), or two
    /// meshes overlap
    long long folded = 0;
    /// times that meshes were put to rest: a displacement not finite or of 1 km, or an untouched mesh that does not
    /// return to rest
    long long unstable = 0;
    /// time that passed without being simulated: a stall too long to be made up for, or ticks that cost more than their
    /// time
    double lost_s = 0;

    void fields(StateBytes& state) noexcept { state(ticks, folded, unstable, lost_s); }
};

/// The state of one session, and its tick. Storage is allocated in the constructor; tick() allocates nothing, takes no
/// lock, prints nothing and throws nothing.
class Simulation {
   public:
    explicit Simulation(const HapticModel& model);
    Simulation(const Simulation& other);             ///< continues as the other one does, bit for bit
    Simulation& operator=(const Simulation&) = delete;

    /// Everything that changes while a session runs, as bytes: displacements and Maxwell branches of the tissue,
    /// contacts, the adapted stiffness, options that may change, energy and counts. A session of the same model
    /// continues from them bit for bit, with this version on this machine. Their number is constant.
    std::size_t state_size() const noexcept;
    void save(std::byte* to) const noexcept;
    /// Restores a saved state. Limits of the device are restored too, except in a session that has ticked, which keeps
    /// its own. The force on the device becomes the saved one, cut to this session's limit: with a hand on the device,
    /// restore only where the hand was when the state was saved. Do not restore bytes of unknown origin: the checksum
    /// detects accidents only.
    /// Throws MismatchError for bytes that are not such a state, or are damaged; the session is then unchanged.
    void restore(const std::byte* from, std::size_t size);
    int restores() const { return restores_; }  ///< number of states restored so far

    /// Changes a tool's options between ticks: those that may change while a session runs (`live`,
    /// haptic/session_options.h), and before the first tick also the device's limits (`limits`). Other fields of
    /// `options` are ignored. After a change that moves the tool in the tissue by more than a hand does in a tick, the
    /// tool must be outside once before there is force. Throws MismatchError as HapticModel does, and then changes
    /// nothing.
    void change(const HapticOptions& options, int tool = 0);
    const HapticOptions& options(int tool = 0) const { return of(tool).options; }

    /// While the clutch is on, the hand moves and the tool does not: the offset follows the hand, and there is no
    /// force. A position that jumps is still a fault.
    void clutch(bool on, int tool = 0) noexcept {
        of(tool).clutched = on;
        of(tool).velocity_m_s.setZero();
    }

    /// On: the tissue that the tool touches follows it in every direction, without slip, as if it were glued to it: a
    /// bilateral contact with the same energy. Begins in the next tick if the tool presses the tissue in that tick.
    /// Otherwise, and after a release, it must be off for one tick and on again. Ends when it goes off, above
    /// HapticOptions::grasp_max_N (a finite limit also where the device's own limit is reached), with a fault or a reset,
    /// and where the hand has moved without a force: a late tick, or more than a millimetre in skip_tick(). Has no effect
    /// on a model without HapticModel::grasps. A device may ask for the same (DeviceSample::grasp).
    void grasp(bool on, int tool = 0) noexcept { of(tool).grasp_asked = on; }
    bool grasps(int tool = 0) const noexcept { return of(tool).grasps; }
    long long let_go(int tool = 0) const noexcept { return of(tool).let_go; }  ///< grasps that ended above the limit

    /// For a session that has not ticked yet: moves its tools to where those of `from` are. The model of `from` may be
    /// another. The device, its limits, and the options that may change become those of `from`. This takes some hundred
    /// ticks, too long for a device to wait: call it in another thread, with a copy of the running session. Throws
    /// MismatchError as check_take_over() and change(), for a session that has ticked, and where a tool cannot be moved
    /// there.
    void follow(const Simulation& from);
    /// After follow(), between two ticks: the hand, its force, the device's limits and impedance, the energy given to
    /// the hand, and counts become those of `from`. The difference between the two sessions' forces fades within some
    /// tenths of a second. Energies of the tissue are those of this session. Allocates nothing.
    void take_over(const Simulation& from) noexcept;
    /// Throws MismatchError where take_over() must not be called:
    ///   - `from` has another number of axes or tools;
    ///   - its device cannot show this tissue at the force scale that it has by now;
    ///   - its device holds a force for less than two dt of this session;
    ///   - a tool of `from` is in another contact than at follow(); a restored contact counts as another.
    /// Allocates only where it throws.
    void check_take_over(const Simulation& from) const;

    /// One step of Sec. 4: takes the device's position, returns its force [N]. elapsed_s: time since the last tick, an
    /// hour at most; 0: dt; negative or not finite: unknown, and taken as the time for which the device holds a force
    /// (force_held_s if that is infinite). cost_s: duration of the previous tick, by the clock of elapsed_s; 0:
    /// elapsed_s is not measured by a clock, or the duration is unknown, and ticks are not shortened. Denormals are
    /// zero inside; the caller's floating-point mode is restored (flush_denormals.h).
    Eigen::Vector3d tick(const DeviceSample& sample, double elapsed_s = 0, double cost_s = 0) noexcept;
    /// The same for all tools: tool_count() samples and forces. The function above gives a second tool an invalid
    /// sample, so that it has no force.
    void tick(const DeviceSample* samples, Eigen::Vector3d* force_N, double elapsed_s = 0, double cost_s = 0) noexcept;

    /// In place of a tick: the tissue and its time stay as they are, and the returned force is zero [N]. passed_s: time
    /// since the last tick or skip_tick(); the hand may move meanwhile. If the last tick's force was on the hand
    /// until now, its energy is counted, and a position that is refused counts and ends the contact. A sample's reset
    /// puts the tissue to rest.
    Eigen::Vector3d skip_tick(const DeviceSample& sample, double passed_s) noexcept;
    /// The same for all tools: tool_count() samples and forces.
    void skip_tick(const DeviceSample* samples, Eigen::Vector3d* force_N, double passed_s) noexcept;

    // tool: number of a tool, 0 to tool_count() - 1
    int tool_count() const { return static_cast<int>(tools_.size()); }
    const TickRecord& record(int tool = 0) const { return of(tool).record; }
    double advanced_s() const { return advanced_s_; }  ///< time by which the tissue advanced in the last tick
    const HapticCounters& counters() const { return counters_; }
    bool has_begun() const { return begun_; }  ///< it has ticked; a restored state does not undo that
    /// Ticks in which the master was inside tissue without having been outside since the start or a fault.
    long long unarmed(int tool = 0) const { return of(tool).unarmed; }
    const Friction& friction(int tool = 0) const { return of(tool).friction; }
    const Safety& safety(int tool = 0) const { return of(tool).safety; }
    const HapticModel& model() const { return model_; }
    const MeshState& state(std::size_t mesh) const { return states_[mesh]; }
    MeshState& state(std::size_t mesh) { return states_[mesh]; }  ///< for starting from another state, between ticks
    const MovingSurface& surface(std::size_t mesh) const { return *surfaces_[mesh]; }
    const ContactState& contact(int tool = 0) const { return of(tool).contact; }
    int set() const { return set_; }                                                 ///< l of (18)
    /// Displacement at a tool's contact [m] (D); 0 without contact. On a mesh of spring sets x_p - X_p. On an energy
    /// model the tool displacement; on a mesh that is not the touched one, the tool displacement that gives the same
    /// force there (of a ball: with the contact that it has on the touched mesh).
    Point displacement_at_contact(std::size_t mesh, int tool = 0) const noexcept;
    /// Displayed displacement of one mesh's nodes [m] (N x D): of an energy model in space with the skin at each
    /// contact (springs/skin.h), two tools one after the other. On a mesh that is not the touched one, the skin follows
    /// that mesh's own tool displacement (displacement_at_contact). Allocates nothing where displacement_m has the
    /// right size.
    void displayed(std::size_t mesh, NodeColumns& displacement_m) const noexcept;
    /// Energies of the learned model's Maxwell branches since the start; 0 without HapticOptions::energy_book. Between
    /// ticks.
    BranchEnergies branches() const { return energy_model() ? energy_model()->branches(states_[0].memory) : BranchEnergies{}; }
    double kinetic_J() const noexcept;  ///< of the learned mesh
    /// The learned energy model, as it is in this session; null for spring sets.
    const RealtimeEnergyModel* energy_model() const { return energy_models_[0].get(); }
    RealtimeEnergyModel* energy_model() { return energy_models_[0].get(); }
    /// Whether the tool stayed behind the hand in the last tick, since the device cannot show the energy model's force.
    bool held_back(int tool = 0) const noexcept { return record(tool).mesh >= 0 && record(tool).coupling_N.norm() >= of(tool).spring.most_N() * (1 - 1e-6); }
    /// Contact of the learned energy model; valid while the tool touches its mesh or the one beside it.
    const ToolSpring& tool(int tool = 0) const { return of(tool).spring; }

    /// To be called after energy_model() was changed (RealtimeEnergyModel::become): gives present contacts the new stiffness.
    void energy_model_changed() noexcept;

    /// Puts every mesh to rest; the master must be outside once before there is force again.
    void reset() noexcept;
    double rested_s() const { return rested_s_; }  ///< session time at which meshes and branches were last put to rest

   private:
    ToolState& of(int tool) { return tools_[static_cast<std::size_t>(tool)]; }
    const ToolState& of(int tool) const { return tools_[static_cast<std::size_t>(tool)]; }
    int index_of(const ToolState& t) const noexcept { return static_cast<int>(&t - tools_.data()); }
    const ToolContact& contacts_of(const ToolState& t) const noexcept { return energy_models_[0]->contacts(index_of(t)); }
    void advance(const DeviceSample* samples, Eigen::Vector3d* force_N, double elapsed_s, double cost_s) noexcept;
    void begin_grasp(ToolState& t) noexcept;
    bool may_slip(const ToolState& t) const noexcept { return t.friction.finite() && !t.grasps; }
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
    bool on_energy_model(const ToolState& t) const noexcept { return t.touched >= 0 && energy_models_[static_cast<std::size_t>(t.touched)]; }
    double untouched_s() const noexcept;
    double steady_s() const noexcept { return std::min({since_[0], since_[1], slowest_period_s}); }
    int steps_due(std::size_t mesh) noexcept;
    void place_surfaces() noexcept;
    void move_surfaces() noexcept;
    bool is_folded(const ToolState& t) const noexcept;
    void stop(ToolState& t) noexcept;
    void rest_meshes() noexcept;
    static double settled_s(const HapticMesh& mesh) noexcept;
    bool come_to_rest_elsewhere() const noexcept;
    bool put_to_rest() noexcept;
    bool find_contact(ToolState& t) noexcept;
    void begin_contact(ToolState& t, int mesh) noexcept;
    Point end_of(const ToolState& t) const noexcept;
    Point outside_cone(const ToolState& t, const Point& tool_m, const NodeColumns& u) const noexcept;
    struct Slip {
        Point slid_m, drags;  ///< displacement of the contact; direction of the drag, zero where it does not slip (D)
        bool went_on;         ///< it also slipped in the step before
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
    std::vector<std::unique_ptr<RealtimeEnergyModel>> energy_models_;  ///< energy model of each mesh, or null
    std::vector<ToolState> tools_;
    std::vector<double> due_s_;   ///< time of each mesh behind now + dt
    /// unused part of longest_s_ of earlier ticks, which advance by whole steps; of each mesh
    std::vector<double> spare_s_;
    double since_[2] = {0, 0};    ///< time that passed before the last tick, and before this one
    double period_s_;             ///< mean time between ticks, for which a force is held
    double advanced_s_ = 0;           ///< time by which meshes advanced in the last tick
    double cost_[2] = {0, 0};     ///< of the last two ticks, over the time by which meshes advanced; 0: not known
    double usual_s_ = 0;          ///< usual time between ticks; 0: not known yet
    double lost_s_ = 0;           ///< time dropped in this tick, by the mesh that dropped most
    double longest_s_ = 0;        ///< longest time by which meshes may advance in this tick
    std::vector<MeshState> states_;
    std::vector<std::unique_ptr<MovingSurface>> surfaces_;
    std::vector<std::unique_ptr<Dynamics>> dynamics_;
    NodeColumns held_;            ///< scratch: displacements some time ahead (N x D)
    bool simple_[2] = {true, true};  ///< whether each surface does not cross itself, in this tick
    bool sound_ = true;           ///< whether none does
    double rested_s_ = 0;
    bool reset_ = false;          ///< whether reset() was called since the last tick
    bool begun_ = false;
    std::vector<long long> followed_;  ///< ToolState::contacts of each tool at follow(); empty without it
    int set_ = 0;                 ///< l of K_l in (19)
    int restores_ = 0;
    HapticCounters counters_;
};

}  // namespace tissue
