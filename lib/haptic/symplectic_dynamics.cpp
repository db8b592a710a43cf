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

/// On a law the tool holds the nodes where they will be a quarter of a substep later: a damper beside each of its springs, which only
/// burns energy, since the contact's is convex. Swings that substeps hardly resolve, of a stiff imprint, die away within a tick or two; what
/// tool and tissue rest at stays. Else a tool that moves tick by tick drives them, and one that touches and lets go pumps them up.
/// The step is stable up to omega h = 1.63 with it, 2 without.
/// Over substeps the tool stands still, and the hand gets the mean of their forces: the impulse that the tissue got, and
/// the energy balance of a single step (tests/haptic/test_law_in_motion.cpp). The first one's force alone is too large after each move
/// of the tool, and the hand would pay a tenth of what it stores.
class SymplecticDynamics final : public Dynamics {
   public:
    SymplecticDynamics(const RealtimeMesh& mesh, const DynamicsOptions& options)
        : mesh_(mesh), law_(options.law), substeps_(options.substeps), h_(options.dt_s / options.substeps),
          ahead_s_(options.law ? h_ / 4 : 0), keep_(1 / (1 + h_ * options.damping_1_s)), gain_(h_ * keep_ * mesh.inverse_mass()), scratch_(options.law ? options.law->scratch_size() : 0),
          held_(NodeColumns::Zero(mesh.node_count(), mesh.dimension())) {}
    std::string name() const override { return symplectic_dynamics.name; }

    Point step(MeshState& s, const ContactLoad& load) noexcept override {
        const int N = mesh_.node_count();
        Point tool = Point::Zero(mesh_.dimension());
        for (int k = 0; k < substeps_; ++k) {
            if (law_)
                law_->force(s.displacement, s.force, scratch_, s.memory);
            else
                mesh_.force(s.theta, s.displacement, s.force);
            if (load.tool) held_ = s.displacement + ahead_s_ * s.velocity;
            tool += load.put_on(mesh_, load.tool ? held_ : s.displacement, s.force) / substeps_;
            for (int axis = 0; axis < mesh_.dimension(); ++axis)
                kernel::symplectic_axis(N, gain_.data(), keep_, h_, s.force.data() + axis * N, s.velocity.data() + axis * N,
                                        s.displacement.data() + axis * N);
        }
        s.theta_changed = false;
        return tool;
    }

   private:
    const RealtimeMesh& mesh_;
    const RealtimeLaw* law_;
    int substeps_;
    double h_;  ///< [s]
    double ahead_s_;
    double keep_;
    Eigen::VectorXd gain_;
    Eigen::VectorXd scratch_;  ///< of the law
    NodeColumns held_;         ///< [m] (N x D)
};

}  // namespace

const DynamicsKind symplectic_dynamics = {
    "symplectic", 1.8,
    [](const RealtimeMesh& mesh, const DynamicsOptions& options) -> std::unique_ptr<Dynamics> {
        return std::make_unique<SymplecticDynamics>(mesh, options);
    }};

}  // namespace tissue
