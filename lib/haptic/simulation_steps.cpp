// Time steps of Simulation: meshes and contacts advance in time, and contacts slide. Contact detection is in
// simulation_contact.cpp.
#include "haptic/simulation.h"

#include <algorithm>
#include <cmath>

namespace tissue {

/// How far an energy model's tool at tool_m is outside the friction cone [m] (D), along the surface, with nodes
/// displaced by u.
Point Simulation::outside_cone(const ToolState& t, const Point& tool_m, const NodeColumns& u) const noexcept {
    if (!may_slip(t)) return Point::Zero(tool_m.size());
    const auto m = static_cast<std::size_t>(t.touched);
    return t.friction.outside(push_of(t, tool_m, m), u, t.spring, t.memory[m]);
}

/// Predicted position of a tool at the end of the time for which this tick's force is held. On an energy model the
/// prediction is cut where it leaves the friction cone along the surface: a contact that slid for a predicted hand
/// would stay there when the hand stops. On spring sets it is not cut.
Point Simulation::end_of(const ToolState& t) const noexcept {
    const Point& master_m = t.record.master_m;
    const Point end_m = t.at_the_end(master_m, period_s_);
    if (t.touched < 0 || !on_energy_model(t) || !may_slip(t)) return end_m;
    const Point outside_m = outside_cone(t, end_m, states_[static_cast<std::size_t>(t.touched)].displacement);
    const double far_m = outside_m.norm();
    if (!(far_m > 0)) return end_m;
    const Point direction = outside_m / far_m;
    return end_m - std::clamp((end_m - master_m).dot(direction), 0.0, far_m) * direction;
}

/// Moves the contact along the surface where the tool is outside the friction cone. The tool is taken at the time to
/// which the mesh has advanced; on spring sets, at its measured position.
Simulation::Slip Simulation::slide(ToolState& t) noexcept {
    const auto m = static_cast<std::size_t>(t.touched);
    const HapticMesh& mesh = *model_.meshes[m];
    const MovingSurface& now = *surfaces_[m];
    if (t.grasps) return {Point::Zero(model_.dimension()), Point::Zero(model_.dimension()), false};
    Slip slip;
    slip.went_on = t.friction.slipping();
    if (mesh.energy_model) {
        slip.slid_m = -t.touched_m;
        slip.drags = t.friction.slide(model_.surface, mesh.springs, contacts_of(t), states_[m].displacement, t.at_m - mesh.place_m, t.contact.where, t.touched_m, t.spring,
                                      t.memory[m], t.memory.size() > 1 ? &t.memory[1 - m] : nullptr);
        slip.slid_m += t.touched_m;
        t.contact.where.position_m = now.at(t.contact.where.facet, t.contact.where.weight);
    } else {
        slip.slid_m = -t.contact.where.position_m;
        slip.drags = t.friction.slide(model_.surface, mesh.springs, now, t.coupling_N_m, t.record.master_m, t.contact.where);
        slip.slid_m += t.contact.where.position_m;
        // an energy model beside gets the force at the new place
        if (t.friction.slipping()) lay_tool(t, push_of(t, t.at_m, m));
    }
    t.contact.proxy_m = t.contact.where.position_m;
    slip.went_on = slip.went_on && t.friction.slipping();
    t.record.slipping = t.record.slipping || t.friction.slipping();
    return slip;
}

/// Displacement of a contact [m] (D) while its tool moves from at_m to to_m, with which the force stays on the friction
/// cone. A contact that slips keeps its ratio to the tool's motion, since the tissue below it moves. A contact that
/// reaches the cone on the way goes as far as the tool is then outside the cone. The contact itself is moved in the
/// next step, after the tissue has responded.
Point Simulation::glide(ToolState& t, const Slip& slip, const Point& to_m, double seconds) noexcept {
    constexpr double most = 2;
    const Point way_m = to_m - t.at_m;
    // at the speed of its sliding since the last step; 0 after a take-over, since the hand then moved in another
    // session
    if (!on_energy_model(t)) {
        t.slide_m_s = t.taken_over ? Point(Point::Zero(way_m.size())) : Point((t.slid_m + slip.slid_m) / seconds);
        t.slid_m.setZero();
        return seconds * t.slide_m_s;
    }
    if (!may_slip(t)) return Point::Zero(way_m.size());
    if (slip.drags.isZero(0)) {
        const MeshState& state = states_[static_cast<std::size_t>(t.touched)];
        held_ = state.displacement + seconds * state.velocity;
        const Point outside_m = outside_cone(t, to_m, held_);
        const double far_m = outside_m.norm();
        return far_m > 0 ? Point(std::clamp(way_m.dot(outside_m) / far_m, 0.0, far_m) / far_m * outside_m) : outside_m;
    }
    const double moved_m = t.went_m.dot(slip.drags);
    if (!slip.went_on) t.share = 1;
    // half of the change: the whole of it would oscillate where friction is low
    else if (moved_m > 0) t.share += (std::clamp(slip.slid_m.dot(slip.drags) / moved_m, 0.0, most) - t.share) / 2;
    return t.share * std::max(0.0, way_m.dot(slip.drags)) * slip.drags;
}

/// Load of a tool on a mesh: on the touched mesh the tool is held by the hand; other meshes get the tool's force.
ContactLoad Simulation::load_of(ToolState& t, std::size_t m) noexcept {
    ContactLoad load;
    load.tool = energy_models_[m] ? &t.spring : nullptr;
    load.memory = t.memory[m].empty() ? nullptr : &t.memory[m];
    if (!model_.is_solid())  // spring sets are loaded at the ends of the segment, an energy model by its own contact
        for (int end : {0, 1}) {
            load.node[end] = model_.meshes[m]->springs.facets()(t.contact.where.facet, end);
            load.weight[end] = t.contact.where.weight[end];
        }
    if (static_cast<int>(m) != t.touched) {
        load.given_N = -t.record.coupling_N;
        return load;
    }
    if (!model_.is_solid()) load.master_m = t.at_m - model_.meshes[m]->place_m;
    load.coupling_N_m = t.coupling_N_m;
    load.push_m = push_of(t, t.at_m, m);
    load.velocity_m_s = t.velocity_m_s;
    load.ahead_s = model_.meshes[m]->contact_damping_s;
    return load;
}

/// Force of a tool on the mesh that it touches, in a tick without a step.
void Simulation::stand_on(ToolState& t, std::size_t m) noexcept {
    const HapticMesh& mesh = *model_.meshes[m];
    const MeshState& state = states_[m];
    if (!mesh.energy_model) t.slid_m += slide(t).slid_m;
    ContactLoad load = load_of(t, m);
    // motion of the tool since the last step
    const Point moved_m = t.at_the_end(t.record.master_m, period_s_) + (model_.options.dt_s - due_s_[m] - period_s_) * t.velocity_m_s - t.at_m;
    held_ = state.displacement + load.ahead_s * state.velocity;
    if (load.tool) {
        // the contact slides in the next step; until then its force is that on the cone
        const Point outside_m = outside_cone(t, t.at_m + moved_m, held_);
        const double far_m = outside_m.norm();
        *load.push_m += moved_m - outside_m;
        if (far_m > 0) load.velocity_m_s -= load.velocity_m_s.dot(outside_m) / (far_m * far_m) * outside_m;
        t.record.slipping = t.record.slipping || far_m > 0;
    } else {
        load.master_m += moved_m;
        load.velocity_m_s -= t.slide_m_s;
    }
    t.record.coupling_N = -load.force_at(mesh.springs, held_);
}

/// Advances a mesh to the end of the time for which this tick's force is held. A tool on it moves on a straight line to
/// the predicted position of the hand, and its record gets the mean of its force over that time. On an energy model a
/// tick of two dt or more is done dt by dt. Each part determines anew whether the tool presses; else oscillating tissue
/// would be released for the whole tick.
void Simulation::advance_mesh(std::size_t m) noexcept {
    const HapticMesh& mesh = *model_.meshes[m];
    MeshState& state = states_[m];
    const double h = model_.options.dt_s / mesh.substeps;
    const int steps = steps_due(m);
    const auto holds = [m](const ToolState& t) { return static_cast<int>(m) == t.touched; };
    if (steps == 0) {
        for (ToolState& t : tools_)
            if (t.contact.pressing && holds(t)) stand_on(t, m);
        return;
    }
    Point course_m_s[most_tools];
    bool held = false;
    for (std::size_t k = 0; k < tools_.size(); ++k) {
        ToolState& t = tools_[k];
        if (!t.contact.contact || !holds(t)) continue;
        held = true;
        course_m_s[k] = (end_of(t) - t.at_m) / (steps * h);
    }
    const bool in_parts = held && mesh.energy_model && steps >= 2 * mesh.substeps;
    const int of_last = std::clamp(static_cast<int>(std::lround(period_s_ / h)), 1, steps), most = in_parts ? mesh.substeps : steps;
    Point sum_N[most_tools];
    for (std::size_t k = 0; k < tools_.size(); ++k) sum_N[k] = Point::Zero(model_.dimension());
    bool pressed[most_tools] = {};
    for (int done = 0; done < steps;) {
        const int n = std::min(most, steps - done), last = std::clamp(of_last - (steps - done - n), 0, n);
        ContactLoads loads;
        int of[most_tools] = {-1, -1};  // tool of each load on the touched mesh; -1 for a load that is a force only
        Point on_m[most_tools], slid_m[most_tools];
        for (std::size_t k = 0; k < tools_.size(); ++k) {
            ToolState& t = tools_[k];
            if (!t.contact.contact) continue;
            if (!holds(t)) {
                if (t.record.mesh >= 0) loads.load[loads.count++] = load_of(t, m);
                continue;
            }
            on_m[k] = t.at_m + n * h * course_m_s[k];
            if (in_parts) t.contact.pressing = tool_pushes(t, on_m[k]);
            if (t.contact.pressing) {
                const Slip slip = slide(t);
                slid_m[k] = slip.slid_m;
                of[loads.count] = static_cast<int>(k);
                ContactLoad& load = loads.load[loads.count++] = load_of(t, m);
                load.velocity_m_s = course_m_s[k] - glide(t, slip, on_m[k], n * h) / (n * h);
            }
            t.went_m = on_m[k] - t.at_m;
            t.at_m = on_m[k];
        }
        Point mean_N[most_tools];
        dynamics_[m]->advance(state, loads, h, n, std::max(last, 1), mean_N);
        for (int k = 0; k < loads.count; ++k) {
            if (of[k] < 0) continue;
            pressed[of[k]] = true;
            tools_[static_cast<std::size_t>(of[k])].friction.dissipate(mean_N[k].dot(slid_m[of[k]]));
            if (last > 0) sum_N[of[k]] += last * mean_N[k];
        }
        for (std::size_t k = 0; k < tools_.size(); ++k)
            if (ToolState& t = tools_[k]; t.contact.contact && !t.contact.pressing && holds(t)) remember_contact(t, in_parts ? on_m[k] : t.record.master_m, n);
        done += n;
    }
    for (std::size_t k = 0; k < tools_.size(); ++k)
        if (ToolState& t = tools_[k]; pressed[k]) {
            record_contact(t);
            t.record.coupling_N = -sum_N[k] / of_last;
        }
}

/// Records the contact of a tool that presses, or that pressed in a part of the tick.
void Simulation::record_contact(ToolState& t) noexcept {
    t.untouched_s = 0;
    t.record.proxy_m = t.contact.proxy_m;
    t.record.mesh = t.touched;
    t.record.facet = t.contact.where.facet;
    t.record.weight = t.contact.where.weight;
}

/// Advances every mesh. The touched one goes first: its coupling or patch gives the force that the others get too.
void Simulation::step_meshes() noexcept {
    for (ToolState& t : tools_) {
        t.record.proxy_m = t.contact.proxy_m;
        t.record.set = model_.is_energy_model() ? -1 : set_;
        if (t.contact.pressing) record_contact(t);
    }
    // with two tools there is one mesh only
    const auto first = static_cast<std::size_t>(std::max(tools_[0].touched, 0));
    lost_s_ = 0;
    advance_mesh(first);
    for (std::size_t m = 0; m < states_.size(); ++m)
        if (m != first) advance_mesh(m);
    counters_.lost_s += lost_s_;
    pass_untouched(-lost_s_);
    for (ToolState& t : tools_) {
        if (t.contact.pressing) continue;
        t.at_m = t.at_the_end(t.record.master_m, period_s_);
        t.went_m.setZero();
        t.slid_m.setZero();
        t.slide_m_s.setZero();
    }
}

/// Advances the Maxwell branches of an energy model's contact that does not press: they relax with its present gap.
void Simulation::remember_contact(ToolState& t, const Point& tool_m, int steps) noexcept {
    const auto m = static_cast<std::size_t>(t.touched);
    if (t.memory[m].empty()) return;
    for (int k = 0; k < steps; ++k) t.spring.remember(push_of(t, tool_m, m), states_[m].displacement, t.memory[m]);
}

}  // namespace tissue
