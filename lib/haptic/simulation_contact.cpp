// What a tool does on the meshes in a tick: where it touches, how it slides, and the steps under it. The tick itself is in simulation.cpp.
#include "haptic/simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tissue {

/// Surfaces to where the meshes are, and which of them are simple now.
void Simulation::move_surfaces() noexcept {
    place_surfaces();
    sound_ = true;
    for (std::size_t m = 0; m < surfaces_.size(); ++m) {
        simple_[m] = surfaces_[m]->simple();
        sound_ = sound_ && simple_[m];
    }
}

/// Whether a surface crosses itself, and there is no inside. A contact asks that of the touched mesh alone: the force is that one's, and the mesh beside it, which is only
/// shown, must not end it.
bool Simulation::is_folded(const ToolState& t) const noexcept {
    return t.touched >= 0 ? !simple_[t.touched] : !sound_;
}

/// The proxy of 4.2 against the mesh in contact, or against each while there is none. Before the master has once been
/// outside there is no contact. False when there is no inside, and when two meshes lie in one place and both hold the proxy.
bool Simulation::find_contact(ToolState& t) noexcept {
    if (is_folded(t)) return false;
    const Point& master_m = t.record.master_m;
    if (!t.armed) {
        wait_for_outside(t);
    } else if (t.touched >= 0) {
        const int left = t.touched;
        ContactState from = t.contact;
        if (on_law(t))
            hold_tool(t);
        else if (update_contact(*surfaces_[static_cast<std::size_t>(left)], master_m, t.contact) == ContactRow::swallowed_release)
            begin_contact(t, left);  // at another place of the same surface
        from.contact = false;
        if (!t.contact.contact && !sound_) return false;  // whether the other mesh is touched now, nobody can say
        if (!t.contact.contact) look_for_contact(t, from, left);
    } else {
        look_for_contact(t, ContactState(t.contact), -1);
    }
    if (!t.contact.contact) t.touched = -1;
    for (std::size_t m = 0; m < surfaces_.size() && (t.contact.contact || !t.armed); ++m)
        if (static_cast<int>(m) != t.touched && surfaces_[m]->contains_strictly(t.contact.proxy_m, 1e-9)) return false;
    return true;
}

/// A contact at a new place: it has its own stiffness, or patch.
void Simulation::begin_contact(ToolState& t, int mesh) noexcept {
    const Point& master_m = t.record.master_m;
    t.touched = mesh;
    ++t.contacts;
    t.at_m = master_m;
    t.went_m.setZero();
    t.friction.begin();
    const HapticMesh& pressed = *model_.meshes[static_cast<std::size_t>(mesh)];
    t.touched_m = pressed.springs.rest_place(t.contact.where.facet, t.contact.where.weight);
    t.spring.grow({});
    lay_tool(t, push_of(t, t.at_the_end(master_m, period_s_), static_cast<std::size_t>(mesh)));
    t.show_no_more(on_law(t));
    for (ToolMemory& memory : t.memory) memory.forget();
    if (pressed.law)
        t.contact.pressing = tool_pushes(t, t.at_the_end(master_m, period_s_));
    else
        t.coupling_N_m = *model_.options.coupling_ratio * model_.stiffness->at(t.contact.where.facet, t.contact.where.weight[1]);
}

/// The law's contact where the tool is, at that push.
void Simulation::lay_tool(ToolState& t, const Point& push_m) noexcept {
    if (model_.is_law()) laws_[0]->contact(t.contact.where.facet, t.contact.where.weight, push_m, states_[static_cast<std::size_t>(t.touched)].displacement, t.spring);
}

/// Whether the tool, held at a place, such as where it will be at the time to which the mesh has come, pushes the law's tissue in: its force has a part along the rest's inward normal, whole or
/// without the imprint on single nodes. That swings fast where it is stiff; a contact let go at each swing would be pumped up by them.
bool Simulation::tool_pushes(const ToolState& t, const Point& tool_m) const noexcept {
    const auto m = static_cast<std::size_t>(t.touched);
    const Point push = push_of(t, tool_m, m);
    const NodeColumns& u = states_[m].displacement;
    const ToolMemory& memory = t.memory[m];
    return t.spring.mean_N(push, u, &memory).dot(t.spring.inward()) > 0 || t.spring.hand_N(push, u, &memory).dot(t.spring.inward()) > t.spring.growth().force_N;
}

/// A law's contact keeps its place, and presses while it pushes the tool out. The surface does not say whether:
/// the patch's spline is smoother, and the tool may lie on either side of it. Contact ends when the patch does not push and the
/// tool is out of the surface, or when it is farther out of it than the surface's nodes lie apart, which no patch explains. Where ticks come less often than dt, tissue that
/// swings may be away from the tool at one tick and back before the next. There a contact lasts for one period of the lowest mode while the tool is deeper than where it touched the tissue at rest, and no
/// farther along the surface than deep: a contact that ended and began at every tick would feed energy into the tissue.
void Simulation::hold_tool(ToolState& t) noexcept {
    const auto m = static_cast<std::size_t>(t.touched);
    const MovingSurface& surface = *surfaces_[m];
    const Point& master_m = t.record.master_m;
    if (laws_[0]->contact_grows()) lay_tool(t, t.spring.shown_push(push_of(t, end_of(t), m), states_[m].displacement));
    t.contact.pressing = tool_pushes(t, end_of(t));
    const Point inward = t.spring.inward(), placed = push_of(t, t.at_m, m);  // the contact was laid for the tool there
    const double in_m = push_of(t, master_m, m).dot(inward), swing_s = 1 / std::max(model_.meshes[m]->lowest_frequency_Hz, 1.0);
    const bool waits = !t.contact.pressing && period_s_ > 1.5 * model_.options.dt_s && t.untouched_s < swing_s && in_m > (placed - placed.dot(inward) * inward).norm();
    if (!surface.contains(master_m) &&
        ((!t.contact.pressing && !waits) || surface.nearest(master_m).distance_m > laws_[m]->spacing_m())) {
        t.contact.contact = t.contact.pressing = false;
        t.contact.proxy_m = master_m;
        return;
    }
    t.contact.where.position_m = surface.at(t.contact.where.facet, t.contact.where.weight);
    t.contact.where.distance_m = (master_m - t.contact.where.position_m).norm();
    t.contact.proxy_m = t.contact.where.position_m;
}

/// How far a tool at a place is outside the cone of friction, along the surface, of nodes that are displaced by u.
Point Simulation::outside_cone(const ToolState& t, const Point& tool_m, const NodeColumns& u) const noexcept {
    const auto m = static_cast<std::size_t>(t.touched);
    if (on_law(t)) return t.friction.outside(push_of(t, tool_m, m), u, t.spring, t.memory[m]);
    return t.friction.outside(model_.meshes[m]->springs, t.coupling_N_m, tool_m, t.contact.where);
}

/// Where a tool will be at the end of the time in which this tick's force is held. Along the surface it is not led farther than friction holds it: a contact that slid for a hand that
/// was expected would stay there when the hand stops. Spring sets have one step a tick, and are led.
Point Simulation::end_of(const ToolState& t) const noexcept {
    const Point& master_m = t.record.master_m;
    const Point end_m = t.at_the_end(master_m, period_s_);
    if (t.touched < 0 || !on_law(t) || !t.friction.finite()) return end_m;
    const Point outside_m = outside_cone(t, end_m, states_[static_cast<std::size_t>(t.touched)].displacement);
    const double far_m = outside_m.norm();
    if (!(far_m > 0)) return end_m;
    const Point direction = outside_m / far_m;
    return end_m - std::clamp((end_m - master_m).dot(direction), 0.0, far_m) * direction;
}

/// The contact goes along the surface where the tool, at the time to which the mesh has come (on spring sets where it was measured), is outside the cone of friction.
Simulation::Slip Simulation::slide(ToolState& t) noexcept {
    const auto m = static_cast<std::size_t>(t.touched);
    const HapticMesh& mesh = *model_.meshes[m];
    const MovingSurface& now = *surfaces_[m];
    Slip slip;
    slip.went_on = t.friction.slipping();
    if (mesh.law) {
        slip.slid_m = -t.touched_m;
        slip.drags = t.friction.slide(model_.surface, mesh.springs, *laws_[0], states_[m].displacement, t.at_m - mesh.place_m, t.contact.where, t.touched_m, t.spring,
                                      t.memory[m], t.memory.size() > 1 ? &t.memory[1 - m] : nullptr);
        slip.slid_m += t.touched_m;
        t.contact.where.position_m = now.at(t.contact.where.facet, t.contact.where.weight);
    } else {
        slip.slid_m = -t.contact.where.position_m;
        slip.drags = t.friction.slide(model_.surface, mesh.springs, now, t.coupling_N_m, t.record.master_m, t.contact.where);
        slip.slid_m += t.contact.where.position_m;
        if (t.friction.slipping()) lay_tool(t, push_of(t, t.at_m, m));  // the law's mesh beside gets the force there
    }
    t.contact.proxy_m = t.contact.where.position_m;
    slip.went_on = slip.went_on && t.friction.slipping();
    t.record.slipping = t.record.slipping || t.friction.slipping();
    return slip;
}

/// How far a contact goes along with its tool while that goes from at_m to to_m (D), so that the force stays on the cone. One that slips goes on as it did, since tissue moves beneath it;
/// one that reaches the cone on the way goes as far as the tool then is outside. It is laid there with the next step, when the tissue has answered.
Point Simulation::glide(ToolState& t, const Slip& slip, const Point& to_m, double seconds) noexcept {
    constexpr double most = 2;
    const Point way_m = to_m - t.at_m;
    if (!on_law(t)) return slip.slid_m;
    if (!t.friction.finite()) return Point::Zero(way_m.size());
    if (slip.drags.isZero(0)) {
        const MeshState& state = states_[static_cast<std::size_t>(t.touched)];
        held_ = state.displacement + seconds * state.velocity;
        const Point outside_m = outside_cone(t, to_m, held_);
        const double far_m = outside_m.norm();
        return far_m > 0 ? Point(std::clamp(way_m.dot(outside_m) / far_m, 0.0, far_m) / far_m * outside_m) : outside_m;
    }
    const double moved_m = t.went_m.dot(slip.drags);
    if (!slip.went_on) t.share = 1;
    else if (moved_m > 0) t.share += (std::clamp(slip.slid_m.dot(slip.drags) / moved_m, 0.0, most) - t.share) / 2;  // at once it would swing where friction is little
    return t.share * std::max(0.0, way_m.dot(slip.drags)) * slip.drags;
}

/// A free proxy, on its way from where it was to the master, against every mesh but the one it has just left.
void Simulation::look_for_contact(ToolState& t, const ContactState& from, int left) noexcept {
    for (std::size_t m = 0; m < surfaces_.size(); ++m) {
        if (static_cast<int>(m) == left) continue;
        t.contact = from;
        update_contact(*surfaces_[m], t.record.master_m, t.contact);
        if (!t.contact.contact) continue;
        return begin_contact(t, static_cast<int>(m));
    }
}

/// No contact yet: the proxy is the master's, or while that is inside, the nearest place on the surface.
void Simulation::wait_for_outside(ToolState& t) noexcept {
    const Point& master_m = t.record.master_m;
    t.no_contact(master_m);
    for (const auto& surface : surfaces_)
        if (surface->contains(master_m)) {
            ++t.unarmed;
            t.contact.proxy_m = surface->nearest(master_m).position_m;
            return;
        }
    t.armed = true;
    t.contact.has_proxy = true;
}

Point Simulation::displacement_at_contact(std::size_t mesh, int tool) const noexcept {
    const ToolState& t = of(tool);
    if (t.record.mesh < 0) return Point::Zero(model_.dimension());
    const HapticMesh& asked = *model_.meshes[mesh];
    const NodeColumns& u = states_[mesh].displacement;
    if (asked.law && static_cast<int>(mesh) == t.record.mesh) return t.spring.shown_push(push_of(t, t.record.master_m, mesh), u, t.memory[mesh].empty() ? nullptr : &t.memory[mesh]);
    if (asked.law) return t.spring.push_at(-t.record.coupling_N, u, &t.memory[mesh]);
    const Cells& facets = asked.springs.facets();
    Point sum = Point::Zero(model_.dimension());
    for (Eigen::Index k = 0; k < facets.cols(); ++k) sum += t.record.weight[k] * u.row(facets(t.record.facet, k)).transpose();
    return sum;
}

void Simulation::seen(std::size_t mesh, NodeColumns& displacement_m) const noexcept {
    displacement_m = states_[mesh].displacement;
    if (!laws_[mesh]) return;
    for (int k = 0; k < tool_count(); ++k)
        if (const TickRecord& r = record(k); r.mesh >= 0) laws_[mesh]->show_skin(r.facet, {r.weight[0], r.weight[1], r.weight[2]}, displacement_at_contact(mesh, k), displacement_m);
}

/// What a tool does to a mesh: the hand holds it on the mesh that it touches, and the others get its force.
ContactLoad Simulation::load_of(ToolState& t, std::size_t m) noexcept {
    ContactLoad load;
    load.tool = laws_[m] ? &t.spring : nullptr;
    load.memory = t.memory[m].empty() ? nullptr : &t.memory[m];
    if (!model_.is_solid())  // on springs the ends of the segment, on a law its own contact
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

/// A tool on the mesh that it touches, in a tick without a step: its force as it stands.
void Simulation::stand_on(ToolState& t, std::size_t m) noexcept {
    const HapticMesh& mesh = *model_.meshes[m];
    const MeshState& state = states_[m];
    ContactLoad load = load_of(t, m);
    const Point moved_m = t.at_the_end(t.record.master_m, period_s_) + (model_.options.dt_s - due_s_[m] - period_s_) * t.velocity_m_s - t.at_m;  // since the last step
    held_ = state.displacement + load.ahead_s * state.velocity;
    const Point outside_m = outside_cone(t, t.at_m + moved_m, held_);  // it slides with the next step; till then its force is that on the cone
    const double far_m = outside_m.norm();
    if (load.tool) *load.push_m += moved_m - outside_m;
    else load.master_m += moved_m - outside_m;
    if (far_m > 0) load.velocity_m_s -= load.velocity_m_s.dot(outside_m) / (far_m * far_m) * outside_m;
    t.record.slipping = t.record.slipping || far_m > 0;
    t.record.coupling_N = -load.force_at(mesh.springs, held_);
}

/// A mesh to the end of the time in which this tick's force is held. A tool that is held goes straight on to where the hand will be then, and its record gets
/// the mean of its force over that time. A tick of two dt or more goes through them one by one: whether a law's tool presses is asked anew in each, or tissue that swings would be let go for as long as the tick is.
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
    const bool in_parts = held && mesh.law && steps >= 2 * mesh.substeps;
    const int of_last = std::clamp(static_cast<int>(std::lround(period_s_ / h)), 1, steps), most = in_parts ? mesh.substeps : steps;
    Point sum_N[most_tools];
    for (std::size_t k = 0; k < tools_.size(); ++k) sum_N[k] = Point::Zero(model_.dimension());
    bool pressed[most_tools] = {};
    for (int done = 0; done < steps;) {
        const int n = std::min(most, steps - done), last = std::clamp(of_last - (steps - done - n), 0, n);
        ContactLoads loads;
        int of[most_tools] = {-1, -1};  // which tool a load holds; none where the mesh gets its force alone
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

/// The tick's record of a tool that presses, or did in a part of it.
void Simulation::record_contact(ToolState& t) noexcept {
    t.untouched_s = 0;
    t.record.proxy_m = t.contact.proxy_m;
    t.record.mesh = t.touched;
    t.record.facet = t.contact.where.facet;
    t.record.weight = t.contact.where.weight;
}

/// Every mesh. The touched one goes first: its coupling, or patch, gives the force that the others get as well.
void Simulation::step_meshes() noexcept {
    for (ToolState& t : tools_) {
        t.record.proxy_m = t.contact.proxy_m;
        t.record.set = model_.is_law() ? -1 : set_;
        if (t.contact.pressing) record_contact(t);
    }
    const auto first = static_cast<std::size_t>(std::max(tools_[0].touched, 0));  // of two tools there is one mesh
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
    }
}

/// A law's contact that does not press for a while forgets as time goes by: its gap goes on.
void Simulation::remember_contact(ToolState& t, const Point& tool_m, int steps) noexcept {
    const auto m = static_cast<std::size_t>(t.touched);
    if (t.memory[m].empty()) return;
    for (int k = 0; k < steps; ++k) t.spring.remember(push_of(t, tool_m, m), states_[m].displacement, t.memory[m]);
}

}  // namespace tissue
