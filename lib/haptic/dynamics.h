#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "haptic/realtime_mesh.h"

namespace tissue {

/// What changes while one mesh runs.
struct MeshState {
    explicit MeshState(const RealtimeMesh& mesh, const Eigen::VectorXd& theta_by_slot)
        : displacement(NodeColumns::Zero(mesh.node_count(), 2)), velocity(displacement), acceleration(displacement),
          force(displacement), theta(theta_by_slot) {}

    NodeColumns displacement;  ///< u = x - x_0, (11) [m] (N x 2)
    NodeColumns velocity;      ///< [m/s] (N x 2)
    NodeColumns acceleration;  ///< of the step before, `paper` alone [m/s^2] (N x 2)
    NodeColumns force;         ///< K u, scratch [N] (N x 2)
    Eigen::VectorXd theta;     ///< stiffness in use, by slot [N/m] (P)
    bool theta_changed = true; ///< since the last step: whoever keeps a factor of K must make it again
};

/// What the tool does to a mesh in one step, at the ends of one segment of the outline: a spring of the virtual
/// coupling between the master and the proxy w(0) x_i + w(1) x_j, and a given force. Neither: a free mesh.
struct ContactLoad {
    int node[2] = {0, 0};
    double weight[2] = {0, 0};
    double coupling_N_m = 0;                               ///< k_C
    Eigen::Vector2d master_m = Eigen::Vector2d::Zero();    ///< in the mesh's own coordinates
    Eigen::Vector2d given_N = Eigen::Vector2d::Zero();     ///< force on the mesh

    /// Proxy at the given displacement [m].
    Eigen::Vector2d proxy(const RealtimeMesh& mesh, const NodeColumns& u) const noexcept;
};

/// One step of M a = f - K u - B v, (12) with the signs put right, of length dt. B = damping M [1/s].
/// One file a kind. No step allocates.
class Dynamics {
   public:
    virtual ~Dynamics() = default;
    virtual std::string name() const = 0;

    /// Returns the force on the mesh at the contact in this step [N]: the force of the tool on the tissue, put on its
    /// segment's end nodes as w(j) f.
    virtual Eigen::Vector2d step(MeshState& state, const ContactLoad& load) noexcept = 0;
};

struct DynamicsOptions {
    double dt_s = 1e-3;          ///< 1 kHz (Sec. 4)
    double damping_1_s = 0;      ///< B = damping M
};

/// name: of dynamics_kinds() (haptic/dynamics_kinds.h). Throws MismatchError for an unknown one, or an implicit step of a
/// mesh too large to factor (over 256 MB).
/// The mesh must outlive the result.
std::unique_ptr<Dynamics> make_dynamics(const std::string& name, const RealtimeMesh& mesh,
                                        const DynamicsOptions& options);

/// Which step a mesh needs: the first that is stable at omega dt = sqrt(largest eigenvalue) dt. That is `symplectic` up
/// to 1.8 (its limit is 2; the rest is margin), else `implicit`. largest_eigenvalue_1_s2: with the coupling's stiffness on it.
std::string stable_dynamics(double largest_eigenvalue_1_s2, double dt_s);

}  // namespace tissue
