#include "haptic/dynamics_kinds.h"
#include "hot_loop.h"

namespace tissue {
namespace kernel {

/// v = (v - dt f / m) / (1 + dt damping), u += dt v, one axis of all nodes. `gain`: dt / (m (1 + dt damping)), 0 where
/// a node is fixed, and its velocity is 0 from the start.
TISSUE_HOT void symplectic_axis(int n, const double* __restrict gain, double keep, double dt,
                                const double* __restrict f, double* __restrict v, double* __restrict u) {
    for (int k = 0; k < n; ++k) {
        v[k] = keep * v[k] - gain[k] * f[k];
        u[k] += dt * v[k];
    }
}

}  // namespace kernel

namespace {

class SymplecticDynamics final : public Dynamics {
   public:
    SymplecticDynamics(const RealtimeMesh& mesh, const DynamicsOptions& options)
        : mesh_(mesh), o_(options), keep_(1 / (1 + options.dt_s * options.damping_1_s)),
          gain_(options.dt_s * keep_ * mesh.inverse_mass()) {}
    std::string name() const override { return symplectic_dynamics.name; }

    Eigen::Vector2d step(MeshState& s, const ContactLoad& load) noexcept override {
        const Eigen::Vector2d f =
            load.given_N + load.coupling_N_m * (load.master_m - load.proxy(mesh_, s.displacement));
        mesh_.force(s.theta, s.displacement, s.force);
        for (int end : {0, 1}) s.force.row(load.node[end]) -= load.weight[end] * f.transpose();
        const int N = mesh_.node_count();
        for (int axis = 0; axis < 2; ++axis)
            kernel::symplectic_axis(N, gain_.data(), keep_, o_.dt_s, s.force.data() + axis * N,
                                    s.velocity.data() + axis * N, s.displacement.data() + axis * N);
        s.theta_changed = false;
        return f;
    }

   private:
    const RealtimeMesh& mesh_;
    DynamicsOptions o_;
    double keep_;
    Eigen::VectorXd gain_;
};

}  // namespace

const DynamicsKind symplectic_dynamics = {
    "symplectic", 1.8,
    [](const RealtimeMesh& mesh, const DynamicsOptions& options) -> std::unique_ptr<Dynamics> {
        return std::make_unique<SymplecticDynamics>(mesh, options);
    }};

}  // namespace tissue
