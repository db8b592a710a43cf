#include <algorithm>

#include "haptic/dynamics_kinds.h"
#include "hot_loop.h"

namespace tissue {
namespace kernel {

/// v = (v - h f / m) / (1 + h damping), u += h v, for one axis of all nodes. gain: h / (m (1 + h damping)); 0 at a
/// fixed node, whose velocity is 0 from the start. keep: 1 / (1 + h damping).
TISSUE_HOT void symplectic_axis(int n, const double* __restrict gain, double keep, double h,
                                const double* __restrict f, double* __restrict v, double* __restrict u) {
    for (int k = 0; k < n; ++k) {
        v[k] = keep * v[k] - gain[k] * f[k];
        u[k] += h * v[k];
    }
}

}  // namespace kernel

namespace {

/// The contact uses the positions of nodes and tool `ahead_s` later. This acts as a damper parallel to each of its
/// springs, which only dissipates, since the contact's energy is convex. On an energy model at least a quarter of a
/// step is used, even where ahead_s is 0. Oscillations of a stiff imprint, which steps hardly resolve, then decay
/// within a tick or two. Without it, a tool that moves step by step excites them, and a tool that touches and releases
/// feeds energy into them. With a damper the step is stable up to (omega h)^2 (1 + 2 ahead / h) = 4.
class SymplecticDynamics final : public Dynamics {
   public:
    SymplecticDynamics(const RealtimeMesh& mesh, const DynamicsOptions& options)
        : mesh_(mesh), law_(options.law), h_(options.dt_s), keep_(1 / (1 + h_ * options.damping_1_s)), gain_(h_ * keep_ * mesh.inverse_mass()),
          scratch_(options.law ? options.law->scratch() : RealtimeEnergyModel::Scratch{}), held_(NodeColumns::Zero(mesh.node_count(), mesh.dimension())) {}

    void complete(MeshState& s) const noexcept override { mesh_.embedding().interpolate(s.displacement); }

   private:
    void step_under(MeshState& s, const ContactLoad* loads, int count, Point* force_N) noexcept override {
        const int N = mesh_.node_count();
        if (law_)
            law_->force(s.displacement, s.force, scratch_, s.memory);
        else
            mesh_.force(s.theta, s.displacement, s.force);
        double held_ahead_s = 0;
        for (int k = 0; k < count; ++k) {
            const double ahead_s = loads[k].tool ? std::max(loads[k].ahead_s, h_ / 4) : loads[k].ahead_s;
            if (ahead_s > 0 && ahead_s != held_ahead_s) held_ = s.displacement + (held_ahead_s = ahead_s) * s.velocity;
            force_N[k] = loads[k].put_on(mesh_, ahead_s > 0 ? held_ : s.displacement, s.force);
        }
        const int own = mesh_.embedding().node_count();  // an embedded solid's own nodes come first and have no mass
        for (int axis = 0; axis < mesh_.dimension(); ++axis)
            kernel::symplectic_axis(N - own, gain_.data() + own, keep_, h_, s.force.data() + axis * N + own, s.velocity.data() + axis * N + own,
                                    s.displacement.data() + axis * N + own);
        s.theta_changed = false;
    }

    const RealtimeMesh& mesh_;
    const RealtimeEnergyModel* law_;
    double h_;  ///< [s]
    double keep_;
    Eigen::VectorXd gain_;
    RealtimeEnergyModel::Scratch scratch_;  ///< of the energy model
    NodeColumns held_;         ///< displacement ahead_s later [m] (N x D)
};

}  // namespace

const DynamicsKind symplectic_dynamics = {
    "symplectic", 1.8,
    [](const RealtimeMesh& mesh, const DynamicsOptions& options) -> std::unique_ptr<Dynamics> {
        return std::make_unique<SymplecticDynamics>(mesh, options);
    }};

}  // namespace tissue
