#include "haptic/dynamics.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "error.h"
#include "haptic/dynamics_kinds.h"

namespace tissue {

Eigen::Vector2d ContactLoad::proxy(const RealtimeMesh& mesh, const NodeColumns& u) const noexcept {
    Eigen::Vector2d x = Eigen::Vector2d::Zero();
    for (int end : {0, 1}) x += weight[end] * (mesh.rest().row(node[end]) + u.row(node[end])).transpose();
    return x;
}

Point ContactLoad::put_on(const RealtimeMesh& mesh, const NodeColumns& u, NodeColumns& f) const noexcept {
    if (tool) return tool->put_on(push_m ? later(*push_m) : tool_push(u), u, f, memory);
    if (weight[0] == 0 && weight[1] == 0) return Point::Zero(mesh.dimension());  // a free mesh
    const Eigen::Vector2d force = given_N + coupling_N_m * (later(master_m) - proxy(mesh, u));
    for (int end : {0, 1}) f.row(node[end]) -= weight[end] * force.transpose();
    return force;
}

Point ContactLoad::later(const Point& tool_m) const noexcept {
    return velocity_m_s.size() == 0 ? tool_m : Point(tool_m + ahead_s * velocity_m_s);
}

Point ContactLoad::force_at(const RealtimeMesh& mesh, const NodeColumns& held) const noexcept {
    if (tool) return tool->tool_force_N(later(*push_m), held, memory);
    return Point(given_N + coupling_N_m * (later(master_m) - proxy(mesh, held)));
}

void ContactLoad::move(double seconds) noexcept {
    if (velocity_m_s.size() == 0) return;
    if (push_m) *push_m += seconds * velocity_m_s;
    if (coupling_N_m > 0) master_m += seconds * velocity_m_s;
}

Point Dynamics::step(MeshState& state, const ContactLoad& load) noexcept {
    Point force;
    step_under(state, &load, 1, &force);
    return force;
}

Point Dynamics::advance(MeshState& state, ContactLoad& load, double dt_s, int steps, int of_last) noexcept {
    ContactLoads loads;
    loads.load[loads.count++] = load;
    Point mean[most_tools];
    advance(state, loads, dt_s, steps, of_last, mean);
    load = loads.load[0];
    return mean[0];
}

void Dynamics::advance(MeshState& state, ContactLoads& loads, double dt_s, int steps, int of_last, Point* mean_N) noexcept {
    const int count = std::max(loads.count, 1);  // without a tool one free load
    Point force[most_tools];
    for (int k = 0; k < steps; ++k) {
        step_under(state, loads.load, count, force);
        for (int t = 0; t < count; ++t) {
            if (k == steps - of_last || mean_N[t].size() == 0) mean_N[t] = Point::Zero(force[t].size());
            if (k >= steps - of_last) mean_N[t] += force[t] / of_last;
            loads.load[t].move(dt_s);
        }
    }
    complete(state);
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
    const DynamicsKind* kind = dynamics_kinds().at(name);
    if (kind != &symplectic_dynamics && options.law)
        throw MismatchError(fmt::format("an energy model needs dynamics '{}', not '{}': leave the option out", symplectic_dynamics.name, name));
    if (!options.law && !mesh.embedding().empty()) throw MismatchError("an embedded lattice needs an energy model");
    return kind->make(mesh, options);
}

std::string stable_dynamics(double largest_eigenvalue_1_s2, double dt_s) {
    const double omega_dt = std::sqrt(largest_eigenvalue_1_s2) * dt_s;
    for (const DynamicsKind* kind : dynamics_kinds().kinds())
        if (omega_dt <= kind->stable_omega_dt) return kind->name;
    throw MismatchError(fmt::format("no time integration is stable at omega dt = {}: reduce dt, or use a coarser mesh", omega_dt));
}

int energy_model_substeps(double largest_eigenvalue_1_s2, double dt_s) {
    constexpr double most = 1000;  // more do not fit into a tick
    const double steps = std::ceil(1.5 * std::sqrt(largest_eigenvalue_1_s2) * dt_s);
    if (!(steps <= most))
        throw MismatchError(fmt::format("the energy model needs {:g} steps in {:g} ms, at most {:g} are possible: it is too stiff for its mass", steps, 1e3 * dt_s, most));
    return std::max(1, static_cast<int>(steps));
}

double energy_model_contact_damping_s(double largest_eigenvalue_1_s2, double dt_s, int steps) {
    const double h = dt_s / steps;
    return std::min(contact_damping_s(dt_s, steps), (2 / (largest_eigenvalue_1_s2 * h) - h) / 2);
}

}  // namespace tissue
