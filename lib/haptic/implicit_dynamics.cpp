#include <fmt/format.h>

#include <Eigen/LU>
#include <cassert>
#include <limits>

#include "error.h"
#include "haptic/band_cholesky.h"
#include "haptic/dynamics_kinds.h"

namespace tissue {
namespace {

/// Backward Euler, with the coupling spring included:
///   (A + dt (dt + ahead) k_C W W') v = M v_old - dt K u + dt W (f_given + k_C (x_m - x_p)),
///   A = M (1 + dt damping) + dt^2 K,   u += dt v,
/// with W the weights of the contact and ahead its ContactLoad::ahead_s. A is banded with a fixed pattern. The coupling
/// has two or four entries outside the pattern, and is added by the formula of Sherman, Morrison and Woodbury. Where K
/// depends on u, it is taken at the old positions without its buckling part (one Newton step). So A is always positive
/// definite.
class ImplicitDynamics final : public Dynamics {
   public:
    ImplicitDynamics(const RealtimeMesh& mesh, const DynamicsOptions& options)
        : mesh_(mesh), o_(options), numbering_(mesh), A_(order(numbering_), numbering_.half_bandwidth),
          x_(Eigen::VectorXd::Zero(2 * mesh.node_count())), z_(Eigen::MatrixXd::Zero(2 * mesh.node_count(), 2)) {}

   private:
    void step_under(MeshState& s, const ContactLoad* loads, [[maybe_unused]] int count, Point* force_N) noexcept override {
        assert(count == 1);
        const ContactLoad& load = *loads;
        const double dt = o_.dt_s;
        const int D = numbering_.per_node;

        // factor A again where K may have changed
        if (s.theta_changed || !mesh_.law().linear_in_displacement() || !factored_) {
            A_.set_zero();
            for (int node = 0; node < mesh_.node_count(); ++node)
                for (int d = 0; d < D; ++d)
                    if (at(node) >= 0) A_.at(D * at(node) + d, D * at(node) + d) = mesh_.mass()[node] * (1 + dt * o_.damping_1_s);
            add_stiffness(mesh_, numbering_, s.theta, s.displacement, dt * dt, true, A_);
            factored_ = A_.factor();
            s.theta_changed = false;
            if (!factored_) {
                *force_N = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
                return;
            }
        }

        // v without the implicit part of the coupling, k_C W W'
        const Eigen::Vector2d pull = load.coupling_N_m * (load.later(load.master_m) - load.proxy(mesh_, s.displacement));
        mesh_.force(s.theta, s.displacement, s.force);
        for (int end : {0, 1})
            s.force.row(load.node[end]) -= load.weight[end] * (load.given_N + pull).transpose();
        solve_momentum(s);

        // add that part
        Eigen::Vector2d slip = load.weight[0] * s.velocity.row(load.node[0]) + load.weight[1] * s.velocity.row(load.node[1]);
        if (load.coupling_N_m > 0) slip = add_coupling(s, load, slip);
        s.displacement += dt * s.velocity;
        *force_N = load.given_N + pull - load.coupling_N_m * (dt + load.ahead_s) * slip;
    }

    static int order(const FreeNumbering& numbering) {
        if (BandCholesky::bytes(numbering.order, numbering.half_bandwidth) > 256e6)
            throw MismatchError(fmt::format("the implicit step of a mesh of {} unknowns and half bandwidth {} is too "
                                            "large to factor",
                                            numbering.order, numbering.half_bandwidth));
        return numbering.order;
    }

    int at(int node) const { return numbering_.number[static_cast<std::size_t>(node)]; }

    /// s.velocity = A^-1 (M v_old - dt force) on the free nodes.
    void solve_momentum(MeshState& s) noexcept {
        const int D = numbering_.per_node, solves = 2 / D;
        for (int solve = 0; solve < solves; ++solve) {
            for (int node = 0; node < mesh_.node_count(); ++node)
                for (int d = 0; d < D && at(node) >= 0; ++d)
                    x_[D * at(node) + d] = mesh_.mass()[node] * s.velocity(node, solve + d) - o_.dt_s * s.force(node, solve + d);
            A_.solve(x_.data());
            for (int node = 0; node < mesh_.node_count(); ++node)
                for (int d = 0; d < D; ++d)
                    s.velocity(node, solve + d) = at(node) >= 0 ? x_[D * at(node) + d] : 0.0;
        }
    }

    /// v -= Z (I / (dt (dt + ahead) k_C) + W'Z)^-1 W'v with Z = A^-1 W. Returns W'v after it.
    Eigen::Vector2d add_coupling(MeshState& s, const ContactLoad& load, const Eigen::Vector2d& slip) noexcept {
        const int D = numbering_.per_node;
        Eigen::Matrix2d S = Eigen::Matrix2d::Zero();
        for (int c = 0; c < D; ++c) {
            double* z = z_.col(c).data();
            std::fill(z, z + numbering_.order, 0.0);
            for (int end : {0, 1})
                if (at(load.node[end]) >= 0) z[D * at(load.node[end]) + c] += load.weight[end];
            A_.solve(z);
            for (int end : {0, 1})
                for (int d = 0; d < D && at(load.node[end]) >= 0; ++d)
                    S(d, c) += load.weight[end] * z[D * at(load.node[end]) + d];
        }
        if (D == 1) S(1, 1) = S(0, 0);
        const Eigen::Matrix2d spring =
            S + Eigen::Matrix2d::Identity() / (o_.dt_s * (o_.dt_s + load.ahead_s) * load.coupling_N_m);
        const Eigen::Vector2d push = spring.inverse() * slip;
        for (int node = 0; node < mesh_.node_count(); ++node) {
            if (at(node) < 0) continue;
            if (D == 1)
                s.velocity.row(node) -= z_(at(node), 0) * push.transpose();
            else
                for (int d = 0; d < 2; ++d)
                    s.velocity(node, d) -= z_(2 * at(node) + d, 0) * push[0] + z_(2 * at(node) + d, 1) * push[1];
        }
        return slip - S * push;
    }

    const RealtimeMesh& mesh_;
    DynamicsOptions o_;
    FreeNumbering numbering_;
    BandCholesky A_;
    Eigen::VectorXd x_;
    Eigen::MatrixXd z_;
    bool factored_ = false;
};

}  // namespace

const DynamicsKind implicit_dynamics = {
    "implicit", std::numeric_limits<double>::infinity(),
    [](const RealtimeMesh& mesh, const DynamicsOptions& options) -> std::unique_ptr<Dynamics> {
        return std::make_unique<ImplicitDynamics>(mesh, options);
    }};

}  // namespace tissue
