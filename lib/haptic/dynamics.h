#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/realtime_energy_model.h"
#include "haptic/realtime_mesh.h"
#include "haptic/state_bytes.h"
#include "springs/tool_spring.h"

namespace tissue {

/// State of one mesh in a session.
struct MeshState {
    explicit MeshState(const RealtimeMesh& mesh, const Eigen::VectorXd& theta_by_slot)
        : displacement(NodeColumns::Zero(mesh.node_count(), mesh.dimension())), velocity(displacement), acceleration(displacement),
          force(displacement), theta(theta_by_slot) {}

    NodeColumns displacement;  ///< u = x - x_0, (11) [m] (N x D)
    NodeColumns velocity;      ///< [m/s] (N x D)
    NodeColumns acceleration;  ///< of the step before, used by `paper` only [m/s^2] (N x D)
    NodeColumns force;         ///< scratch: K u less the tools' forces [N] (N x D)
    BranchMemory memory;       ///< Maxwell branches (RealtimeEnergyModel::memory); empty for a model that does not relax
    Eigen::VectorXd theta;     ///< stiffness in use, by slot [N/m] (P); constant for an energy model
    void fields(StateBytes& state) noexcept {
        state(displacement, velocity, acceleration, memory, theta);
        if (state.reads()) theta_changed = true;
    }

    bool theta_changed = true; ///< since the last step: a stored factorisation of K is out of date
};

/// Load of one tool on a mesh in one step. By default the mesh is free.
///
/// On spring sets the load acts at the ends of one segment of the outline. It is the virtual coupling, a spring between
/// the master and the proxy w(0) x_i + w(1) x_j, plus a given force. On an energy model the load acts through the
/// contact `tool` (springs/tool_spring.h): either the tool displacement or the force is given.
struct ContactLoad {
    int node[2] = {0, 0};                                  ///< i, j: ends of the segment
    double weight[2] = {0, 0};                             ///< w; both 0: the mesh is free
    double coupling_N_m = 0;                               ///< k_C
    Eigen::Vector2d master_m = Eigen::Vector2d::Zero();    ///< in the mesh's own coordinates
    Point given_N = Eigen::Vector2d::Zero();               ///< force on the mesh (D)
    const ToolSpring* tool = nullptr;                      ///< contact on an energy model; null on spring sets
    ToolMemory* memory = nullptr;                          ///< the contact's Maxwell branches, which steps advance
    std::optional<Point> push_m = {};                      ///< tool displacement d (D); empty: given_N acts instead
    Point velocity_m_s = {};                               ///< velocity of the tool or master (D); empty: zero
    /// The contact's force is that of tool and nodes at a time ahead_s later, which acts as a damper beside its
    /// springs.
    double ahead_s = 0;

    /// Position of the proxy at the displacement u [m]. For spring sets, in the plane.
    Eigen::Vector2d proxy(const RealtimeMesh& mesh, const NodeColumns& u) const noexcept;

    /// Tool displacement on an energy model [m] (D): push_m, or the one at which the force is given_N at u.
    Point tool_push(const NodeColumns& u) const noexcept { return push_m ? *push_m : tool->push_at(given_N, u, memory); }

    /// Position of the tool ahead_s later [m] (D).
    Point later(const Point& tool_m) const noexcept;

    /// Force of the tool on the mesh [N] (D). held: displacement of the nodes ahead_s later [m] (N x D). On an energy
    /// model push_m must be set.
    Point force_at(const RealtimeMesh& mesh, const NodeColumns& held) const noexcept;

    /// Moves the tool and the master on by velocity_m_s * seconds.
    void move(double seconds) noexcept;

    /// Subtracts the load from f, the external nodal force in equilibrium with u [N] (N x D). Returns the force of the
    /// tool on the mesh [N] (D), zero for a free mesh.
    Point put_on(const RealtimeMesh& mesh, const NodeColumns& u, NodeColumns& f) const noexcept;
};

constexpr int most_tools = 2;  ///< largest number of tools on one tissue

/// Loads of all tools on a mesh in one step.
struct ContactLoads {
    ContactLoad load[most_tools];
    int count = 0;
};

/// Time integration of M a = f - K u - B v, (12) with corrected signs, in steps of length dt. B = damping M, damping in
/// 1/s. Each kind has its own file. No step allocates. Every kind but `paper` has the contact's damper
/// (ContactLoad::ahead_s).
class Dynamics {
   public:
    virtual ~Dynamics() = default;

    /// One step. Returns the force f of the tool on the tissue in it [N] (D). On spring sets the end nodes of the
    /// segment get w(j) f; on an energy model the contact distributes f.
    Point step(MeshState& state, const ContactLoad& load) noexcept;
    /// Sets the displacements of an embedded solid's own nodes. advance() calls it after its last step. Velocities of
    /// these nodes are neither set nor read.
    virtual void complete(MeshState& /*state*/) const noexcept {}

    /// Advances by `steps` steps of dt_s each, in which the tool moves on. Returns the mean force over the last
    /// `of_last` of them [N] (D).
    Point advance(MeshState& state, ContactLoad& load, double dt_s, int steps, int of_last) noexcept;
    /// The same under several tools. mean_N: mean force of each tool [N] (one element at least).
    void advance(MeshState& state, ContactLoads& loads, double dt_s, int steps, int of_last, Point* mean_N) noexcept;

   private:
    /// One step under `count` loads; force_N receives the force of each tool. Without a tool the one load is free. Only
    /// `symplectic` takes more than one load.
    virtual void step_under(MeshState& state, const ContactLoad* loads, int count, Point* force_N) noexcept = 0;
};

struct DynamicsOptions {
    double dt_s = 1e-3;          ///< length of a step; the default is 1 kHz (Sec. 4)
    double damping_1_s = 0;      ///< B = damping M
    const RealtimeEnergyModel* law = nullptr;  ///< energy model in place of springs, `symplectic` only; must outlive the result
};

/// Makes the time integration `name`, one of dynamics_kinds() (haptic/dynamics_kinds.h). The mesh must outlive the
/// result. Throws MismatchError for an unknown name, a dt that is not positive, a negative damping, an implicit step of
/// a mesh too large to factor (over 256 MB), an energy model with a kind other than `symplectic`, and an embedded
/// lattice without an energy model.
std::unique_ptr<Dynamics> make_dynamics(const std::string& name, const RealtimeMesh& mesh,
                                        const DynamicsOptions& options);

/// Name of the first kind that is stable at omega dt = sqrt(largest eigenvalue) dt: `symplectic` up to 1.8 (its limit
/// is 2; the rest is margin), else `implicit`. largest_eigenvalue_1_s2: of M^-1 K with the coupling's stiffness
/// included. Throws MismatchError when the eigenvalue is NaN.
std::string stable_dynamics(double largest_eigenvalue_1_s2, double dt_s);

/// ContactLoad::ahead_s where positions of the hand come every dt. The force of a tick is constant for dt, so it is
/// late by dt / 2 on average: a spring K then acts with the negative damping -K dt / 2. The tool moves on a straight
/// line through the steps of dt, which removes (steps - 1) / steps of that. With ahead_s = dt / 2 a positive damping of
/// nearly K dt / 2 remains, in proportion to K. With a single step it is 3/4 dt, so that K dt / 4 remains.
constexpr double contact_damping_s(double dt_s, int steps) { return steps == 1 ? 0.75 * dt_s : 0.5 * dt_s; }

/// Number of steps h into which `symplectic` divides dt for an energy model: omega h <= 2/3. The limit is lower than
/// for spring sets, whose stiffness never exceeds the bound. An energy model gets stiffer than the bound when it is
/// indented or stretched farther than in any load case; its areas stiffen with the square of the stretch. Throws
/// MismatchError for more than 1000 steps, or when the eigenvalue is NaN.
int energy_model_substeps(double largest_eigenvalue_1_s2, double dt_s);

/// contact_damping_s, or less where the steps h are too long for it: (omega h)^2 (1 + 2 ahead / h) <= 2, half of the
/// limit of stability.
double energy_model_contact_damping_s(double largest_eigenvalue_1_s2, double dt_s, int steps);

}  // namespace tissue
