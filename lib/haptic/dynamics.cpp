#include "haptic/dynamics.h"

#include <fmt/format.h>

#include <cmath>

#include "error.h"
#include "haptic/dynamics_kinds.h"

namespace tissue {

Eigen::Vector2d ContactLoad::proxy(const RealtimeMesh& mesh, const NodeColumns& u) const noexcept {
    Eigen::Vector2d x = Eigen::Vector2d::Zero();
    for (int end : {0, 1}) x += weight[end] * (mesh.rest().row(node[end]) + u.row(node[end])).transpose();
    return x;
}

const Registry<const DynamicsKind*>& dynamics_kinds() {
    static const Registry<const DynamicsKind*> kinds("dynamics", {&paper_dynamics, &symplectic_dynamics, &implicit_dynamics},
                                                     [](const DynamicsKind* kind) { return kind->name; });
    return kinds;
}

std::unique_ptr<Dynamics> make_dynamics(const std::string& name, const RealtimeMesh& mesh,
                                        const DynamicsOptions& options) {
    if (!(options.dt_s > 0) || !(options.damping_1_s >= 0))
        throw MismatchError(fmt::format("a step of {} s with damping {} 1/s is not possible", options.dt_s,
                                        options.damping_1_s));
    return dynamics_kinds().at(name)->make(mesh, options);
}

std::string stable_dynamics(double largest_eigenvalue_1_s2, double dt_s) {
    const double omega_dt = std::sqrt(largest_eigenvalue_1_s2) * dt_s;
    for (const DynamicsKind* kind : dynamics_kinds().kinds())
        if (omega_dt <= kind->stable_omega_dt) return kind->name;
    throw MismatchError(fmt::format("no step is stable at omega dt = {}", omega_dt));
}

}  // namespace tissue
