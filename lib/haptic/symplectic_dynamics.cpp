#include <algorithm>

#include "haptic/dynamics_kinds.h"
#include "hot_loop.h"

namespace tissue {
namespace kernel {

/// v = (v - h f / m) / (1 + h damping), u += h v, one axis of all nodes. `gain`: h / (m (1 + h damping)), 0 where
/// a node is fixed, and its velocity is 0 from the start.
TISSUE_HOT void symplectic_axis(int n, const double* __restrict gain, double keep, double h,
                                const double* __restrict f, double* __restrict v, double* __restrict u) {
    for (int k = 0; k < n; ++k) {
        v[k] = keep * v[k] - gain[k] * f[k];
        u[k] += h * v[k];
    }
}

}  // namespace kernel

namespace {

/// The contact takes the nodes where they will be `ahead_s` later, as it takes the tool: a damper beside each of its springs, which only burns
/// energy, since the contact's is convex. On a law also where nobody asks for one, by a quarter of a step: swings that steps hardly resolve, of a stiff
/// imprint, die away within a tick or two. Else a tool that moves step by step drives them, and one that touches and lets go pumps them up. With a
/// damper the step is stable up to (omega h)^2 (1 + 2 ahead / h) = 4.
class SymplecticDynamics final : public Dynamics {
   public:
    SymplecticDynamics(const RealtimeMesh& mesh, const DynamicsOptions& options)
        : mesh_(mesh), law_(options.law), h_(options.dt_s), keep_(1 / (1 + h_ * options.damping_1_s)), gain_(h_ * keep_ * mesh.inverse_mass()),
          scratch_(options.law ? options.law->scratch() : RealtimeLaw::Scratch{}), held_(NodeColumns::Zero(mesh.node_count(), mesh.dimension())) {}
    std::string name() const override { return symplectic_dynamics.name; }

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
    const RealtimeLaw* law_;
    double h_;  ///< [s]
    double keep_;
    Eigen::VectorXd gain_;
    RealtimeLaw::Scratch scratch_;  ///< of the law
    NodeColumns held_;         ///< [m] (N x D)
};

}  // namespace

const DynamicsKind symplectic_dynamics = {
    "symplectic", 1.8,
    [](const RealtimeMesh& mesh, const DynamicsOptions& options) -> std::unique_ptr<Dynamics> {
        return std::make_unique<SymplecticDynamics>(mesh, options);
    }};

}  // namespace tissue
