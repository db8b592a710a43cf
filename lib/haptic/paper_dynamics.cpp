#include <cassert>

#include "haptic/dynamics_kinds.h"

namespace tissue {
namespace {

/// (13)-(15) of the paper, with the dt that is missing there:
///   a_t = M^-1 (f - K u_{t-1} - B v_{t-1}),  v_t = v_{t-1} + dt (a_{t-1} + a_t) / 2,  x_t = x_{t-1} + dt (v_{t-1} +
///   v_t) / 2
class PaperDynamics final : public Dynamics {
   public:
    PaperDynamics(const RealtimeMesh& mesh, const DynamicsOptions& options) : mesh_(mesh), o_(options) {}

   private:
    void step_under(MeshState& s, const ContactLoad* loads, [[maybe_unused]] int count, Point* force_N) noexcept override {
        assert(count == 1);
        mesh_.force(s.theta, s.displacement, s.force);
        *force_N = loads->put_on(mesh_, s.displacement, s.force);
        for (Eigen::Index axis = 0; axis < 2; ++axis)
            for (Eigen::Index n = 0; n < s.force.rows(); ++n) {
                const double inverse_mass = mesh_.inverse_mass()[n], v = s.velocity(n, axis);
                const double a = -inverse_mass * s.force(n, axis) - (inverse_mass > 0 ? o_.damping_1_s * v : 0.0);
                const double v_new = v + o_.dt_s * (s.acceleration(n, axis) + a) / 2;
                s.displacement(n, axis) += o_.dt_s * (v + v_new) / 2;
                s.velocity(n, axis) = v_new;
                s.acceleration(n, axis) = a;
            }
        s.theta_changed = false;
    }

    const RealtimeMesh& mesh_;
    DynamicsOptions o_;
};

}  // namespace

const DynamicsKind paper_dynamics = {
    "paper", -1,
    [](const RealtimeMesh& mesh, const DynamicsOptions& options) -> std::unique_ptr<Dynamics> {
        return std::make_unique<PaperDynamics>(mesh, options);
    }};

}  // namespace tissue
