#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/realtime_law.h"
#include "haptic/realtime_mesh.h"
#include "haptic/state_bytes.h"
#include "springs/tool_spring.h"

namespace tissue {

/// What changes while one mesh runs.
struct MeshState {
    explicit MeshState(const RealtimeMesh& mesh, const Eigen::VectorXd& theta_by_slot)
        : displacement(NodeColumns::Zero(mesh.node_count(), mesh.dimension())), velocity(displacement), acceleration(displacement),
          force(displacement), theta(theta_by_slot) {}

    NodeColumns displacement;  ///< u = x - x_0, (11) [m] (N x D)
    NodeColumns velocity;      ///< [m/s] (N x D)
    NodeColumns acceleration;  ///< of the step before, `paper` alone [m/s^2] (N x D)
    NodeColumns force;         ///< K u, scratch [N] (N x D)
    BranchMemory memory;       ///< of a law that relaxes (RealtimeLaw::memory); else empty
    Eigen::VectorXd theta;     ///< stiffness in use, by slot [N/m] (P); of a law its springs', which stay
    void fields(StateBytes& state) noexcept {
        state(displacement, velocity, acceleration, memory, theta);
        if (state.reads()) theta_changed = true;
    }

    bool theta_changed = true; ///< since the last step: whoever keeps a factor of K must make it again
};

/// What the tool does to a mesh in one step. On springs, at the ends of one segment of the outline: a spring of the virtual
/// coupling between the master and the proxy w(0) x_i + w(1) x_j, and a given force. On a law, at a contact of its own (springs/tool_spring.h): held
/// at a push, or a given force. None of these: a free mesh.
struct ContactLoad {
    int node[2] = {0, 0};
    double weight[2] = {0, 0};
    double coupling_N_m = 0;                               ///< k_C
    Eigen::Vector2d master_m = Eigen::Vector2d::Zero();    ///< in the mesh's own coordinates
    Point given_N = Eigen::Vector2d::Zero();               ///< force on the mesh (D)
    const ToolSpring* tool = nullptr;                      ///< of a law
    ToolMemory* memory = nullptr;                          ///< of the contact on this mesh, where it relaxes; it goes on with every step
    std::optional<Point> push_m = {};                      ///< of the tool that is held; nothing: it pushes with given_N
    Point velocity_m_s = {};                               ///< of the tool that is held (D); empty: it stands still
    double ahead_s = 0;                                    ///< the contact's force is that of tool and nodes so much later: a damper beside its springs

    /// Proxy at the given displacement [m]. On springs, in the plane.
    Eigen::Vector2d proxy(const RealtimeMesh& mesh, const NodeColumns& u) const noexcept;

    /// How far the tool has pushed a law's tissue [m]: push_m, or as far as given_N takes it at u.
    Point tool_push(const NodeColumns& u) const noexcept { return push_m ? *push_m : tool->push_at(given_N, u, memory); }

    /// Where the tool will be ahead_s later (D).
    Point later(const Point& tool_m) const noexcept;

    /// The force of the tool on a mesh that has this displacement ahead_s later [N] (D). held: of the tool that is held.
    Point force_at(const RealtimeMesh& mesh, const NodeColumns& held) const noexcept;

    /// The tool moves on.
    void move(double seconds) noexcept;

    /// Takes the tool's share off f, the force that holds u [N]. Returns the force of the tool on the mesh [N]; nothing where there is no tool.
    Point put_on(const RealtimeMesh& mesh, const NodeColumns& u, NodeColumns& f) const noexcept;
};

constexpr int most_tools = 2;  ///< on one tissue

/// What the tools do to a mesh in one step.
struct ContactLoads {
    ContactLoad load[most_tools];
    int count = 0;
};

/// One step of M a = f - K u - B v, (12) with the signs put right, of length dt. B = damping M [1/s].
/// One file a kind. No step allocates. The contact's damper (ContactLoad::ahead_s) works in every kind but `paper`.
class Dynamics {
   public:
    virtual ~Dynamics() = default;
    virtual std::string name() const = 0;

    /// Returns the force on the mesh at the contact in this step [N]: the force of the tool on the tissue, put on its
    /// segment's end nodes as w(j) f, or at its own contact.
    Point step(MeshState& state, const ContactLoad& load) noexcept;
    /// Called after the last step of a tick: sets the displacements of an embedded solid's own nodes. Nothing sets or reads their velocities.
    virtual void complete(MeshState& /*state*/) const noexcept {}

    /// So many steps one after the other, in which the tool moves on. Returns the mean force of the last `of_last` of them.
    Point advance(MeshState& state, ContactLoad& load, double dt_s, int steps, int of_last) noexcept;
    /// The same under several tools; mean_N: of each.
    void advance(MeshState& state, ContactLoads& loads, double dt_s, int steps, int of_last, Point* mean_N) noexcept;

   private:
    /// force_N: of each tool. Kinds but `symplectic` take one load: a free one where there is no tool.
    virtual void step_under(MeshState& state, const ContactLoad* loads, int count, Point* force_N) noexcept = 0;
};

struct DynamicsOptions {
    double dt_s = 1e-3;          ///< 1 kHz (Sec. 4)
    double damping_1_s = 0;      ///< B = damping M
    const RealtimeLaw* law = nullptr;  ///< in place of springs; `symplectic` alone. It must outlive the step
};

/// name: of dynamics_kinds() (haptic/dynamics_kinds.h). Throws MismatchError for an unknown one, an implicit step of a
/// mesh too large to factor (over 256 MB), and a law for a kind that does not know it.
/// The mesh must outlive the result.
std::unique_ptr<Dynamics> make_dynamics(const std::string& name, const RealtimeMesh& mesh,
                                        const DynamicsOptions& options);

/// Which step a mesh needs: the first that is stable at omega dt = sqrt(largest eigenvalue) dt. That is `symplectic` up
/// to 1.8 (its limit is 2; the rest is margin), else `implicit`. largest_eigenvalue_1_s2: with the coupling's stiffness on it.
std::string stable_dynamics(double largest_eigenvalue_1_s2, double dt_s);

/// How far ahead a contact takes tool and nodes where a hand's positions come every dt (ContactLoad::ahead_s). The force is held for dt, half of that
/// late on average: a spring K gives back K dt / 2 as negative damping. The tool's straight way through the steps of dt takes (steps - 1) / steps of that away.
/// Half of dt more leaves nearly K dt / 2 of damping, in proportion to whatever K is; of a single step three quarters, so that K dt / 4 is left at least.
constexpr double contact_damping_s(double dt_s, int steps) { return steps == 1 ? 0.75 * dt_s : 0.5 * dt_s; }

/// Into how many steps `symplectic` divides dt for a law: omega h <= 2/3. Springs of a set are never stiffer than
/// at the bound; a law pressed deeper or drawn out farther than any load case is, its areas by the square of the stretch.
/// Throws MismatchError for more than a thousand, or when the eigenvalue is no number.
int law_substeps(double largest_eigenvalue_1_s2, double dt_s);

/// contact_damping_s, or less where steps h are too long for it: (omega h)^2 (1 + 2 ahead / h) <= 2, half of the step's limit.
double law_contact_damping_s(double largest_eigenvalue_1_s2, double dt_s, int steps);

}  // namespace tissue
