#include "haptic/dynamics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "error.h"
#include "haptic/dynamics_kinds.h"

namespace tissue {

Eigen::Vector2d ContactLoad::proxy(const RealtimeMesh& mesh, const NodeColumns& u) const noexcept {
    Eigen::Vector2d x = Eigen::Vector2d::Zero();
    for (int end : {0, 1}) x += weight[end] * (mesh.rest().row(node[end]) + u.row(node[end])).transpose();
    return x;
}

const std::vector<std::string>& dynamics_names() {
    static const std::vector<std::string> names = {"paper", "symplectic", "implicit"};
    return names;
}

std::unique_ptr<Dynamics> make_dynamics(const std::string& name, const RealtimeMesh& mesh,
                                        const DynamicsOptions& options) {
    if (!(options.dt_s > 0) || !(options.damping_1_s >= 0))
        throw MismatchError(fmt::format("a step of {} s with damping {} 1/s is not possible", options.dt_s,
                                        options.damping_1_s));
    if (name == "paper") return make_paper_dynamics(mesh, options);
    if (name == "symplectic") return make_symplectic_dynamics(mesh, options);
    if (name == "implicit") return make_implicit_dynamics(mesh, options);
    throw MismatchError(fmt::format("dynamics '{}' is not known; allowed: {}", name, fmt::join(dynamics_names(), ", ")));
}

std::string stable_dynamics(double largest_eigenvalue_1_s2, double dt_s) {
    constexpr double limit = 1.8;
    return std::sqrt(largest_eigenvalue_1_s2) * dt_s <= limit ? "symplectic" : "implicit";
}

}  // namespace tissue
