// Contact detection of Simulation: where a tool touches the meshes, and whether it still does. Sliding and time steps
// are in simulation_steps.cpp.
#include "haptic/simulation.h"

#include <algorithm>
#include <cmath>

namespace tissue {

/// Moves surfaces to the positions of the meshes, and determines which of them do not cross themselves.
void Simulation::move_surfaces() noexcept {
    place_surfaces();
    sound_ = true;
    for (std::size_t m = 0; m < surfaces_.size(); ++m) {
        simple_[m] = surfaces_[m]->simple();
        sound_ = sound_ && simple_[m];
    }
}

/// Whether a surface crosses itself, so that there is no inside. In contact only the touched mesh counts: the force is
/// that mesh's, and the mesh beside it, which is only displayed, must not end the contact.
bool Simulation::is_folded(const ToolState& t) const noexcept {
    return t.touched >= 0 ? !simple_[t.touched] : !sound_;
}

/// Updates the proxy of 4.2 against the touched mesh, or without contact against each mesh. There is no contact before
/// the master has been outside once. False where there is no inside, and where two meshes overlap and the proxy of one
/// is inside the other.
bool Simulation::find_contact(ToolState& t) noexcept {
    if (is_folded(t)) return false;
    const Point& master_m = t.record.master_m;
    if (!t.armed) {
        wait_for_outside(t);
    } else if (t.touched >= 0) {
        const int left = t.touched;
        ContactState from = t.contact;
        if (on_energy_model(t))
            hold_tool(t);
        else if (update_contact(*surfaces_[static_cast<std::size_t>(left)], master_m, t.contact) == ContactRow::swallowed_release)
            begin_contact(t, left);  // the proxy was put on another place of the same surface
        from.contact = false;
        if (!t.contact.contact && !sound_) return false;  // contact with the other mesh is undefined
        if (!t.contact.contact) look_for_contact(t, from, left);
    } else {
        look_for_contact(t, ContactState(t.contact), -1);
    }
    if (!t.contact.contact) t.touched = -1;
    for (std::size_t m = 0; m < surfaces_.size() && (t.contact.contact || !t.armed); ++m)
        if (static_cast<int>(m) != t.touched && surfaces_[m]->contains_strictly(t.contact.proxy_m, 1e-9)) return false;
    return true;
}

/// Starts a contact at a new place, with the stiffness or patch of that place.
void Simulation::begin_contact(ToolState& t, int mesh) noexcept {
    const Point& master_m = t.record.master_m;
    t.touched = mesh;
    ++t.contacts;
    t.at_m = master_m;
    t.went_m.setZero();
    t.slid_m.setZero();
    t.slide_m_s.setZero();
    t.friction.begin();
    const HapticMesh& pressed = *model_.meshes[static_cast<std::size_t>(mesh)];
    t.touched_m = pressed.springs.rest_place(t.contact.where.facet, t.contact.where.weight);
    t.spring.grow({});
    lay_tool(t, push_of(t, t.at_the_end(master_m, period_s_), static_cast<std::size_t>(mesh)));
    t.show_no_more(on_energy_model(t));
    for (ToolMemory& memory : t.memory) memory.forget();
    if (pressed.energy_model)
        t.contact.pressing = tool_pushes(t, t.at_the_end(master_m, period_s_));
    else
        t.coupling_N_m = *model_.options.coupling_ratio * model_.stiffness->at(t.contact.where.facet, t.contact.where.weight[1]);
}

/// Sets the energy model's contact at the tool's place, for that tool displacement.
void Simulation::lay_tool(ToolState& t, const Point& push_m) noexcept {
    if (model_.is_energy_model()) contacts_of(t).at(t.contact.where.facet, t.contact.where.weight, push_m, states_[static_cast<std::size_t>(t.touched)].displacement, t.spring);
}

/// Whether the tool at tool_m pushes into the energy model's tissue: its force has a positive part along the inward
/// normal at rest. Both the whole force and the force without the imprint on single nodes are tried. The imprint
/// oscillates fast where it is stiff, and a contact released at each oscillation would feed energy into it. tool_m is,
/// for example, the tool's position at the time to which the mesh has advanced. A tool that grasps also pulls.
bool Simulation::tool_pushes(const ToolState& t, const Point& tool_m) const noexcept {
    if (t.grasps) return true;
    const auto m = static_cast<std::size_t>(t.touched);
    const Point push = push_of(t, tool_m, m);
    const NodeColumns& u = states_[m].displacement;
    const ToolMemory& memory = t.memory[m];
    return t.spring.mean_N(push, u, &memory).dot(t.spring.inward()) > 0 || t.spring.tool_force_N(push, u, &memory).dot(t.spring.inward()) > t.spring.growth().force_N;
}

/// Updates an energy model's contact, which keeps its place. It presses while its force pushes the tool out
/// (tool_pushes()). The surface does not decide that: the patch's spline is smoother than the surface, and the tool may
/// lie on either side of it.
///
/// The contact ends if it does not press and the tool is outside the surface. It also ends if the tool is farther
/// outside than the spacing of the surface's nodes, which is more than spline and surface differ by.
///
/// Where ticks come less often than dt, oscillating tissue may be away from the tool at one tick and back before the
/// next. There a contact that does not press lasts for one period of the lowest mode, while the tool is deeper than the
/// point at rest that it touched, and its displacement along the surface is less than its depth. A contact that ended
/// and began at every tick would feed energy into the tissue.
void Simulation::hold_tool(ToolState& t) noexcept {
    const auto m = static_cast<std::size_t>(t.touched);
    const MovingSurface& surface = *surfaces_[m];
    const Point& master_m = t.record.master_m;
    if (contacts_of(t).grows()) lay_tool(t, t.spring.shown_push(push_of(t, end_of(t), m), states_[m].displacement));
    t.contact.pressing = tool_pushes(t, end_of(t));
    // of the tool for which the contact was set
    const Point inward = t.spring.inward(), placed = push_of(t, t.at_m, m);
    const double in_m = push_of(t, master_m, m).dot(inward), swing_s = 1 / std::max(model_.meshes[m]->lowest_frequency_Hz, 1.0);
    const bool waits = !t.contact.pressing && period_s_ > 1.5 * model_.options.dt_s && t.untouched_s < swing_s && in_m > (placed - placed.dot(inward) * inward).norm();
    if (!t.grasps && !surface.contains(master_m) &&
        ((!t.contact.pressing && !waits) || surface.nearest(master_m).distance_m > contacts_of(t).spacing_m())) {
        t.contact.contact = t.contact.pressing = false;
        t.contact.proxy_m = master_m;
        return;
    }
    t.contact.where.position_m = surface.at(t.contact.where.facet, t.contact.where.weight);
    t.contact.where.distance_m = (master_m - t.contact.where.position_m).norm();
    t.contact.proxy_m = t.contact.where.position_m;
}

/// Checks the path of a free proxy, from its last position to the master, against every mesh except the one it has just
/// left.
void Simulation::look_for_contact(ToolState& t, const ContactState& from, int left) noexcept {
    for (std::size_t m = 0; m < surfaces_.size(); ++m) {
        if (static_cast<int>(m) == left) continue;
        t.contact = from;
        update_contact(*surfaces_[m], t.record.master_m, t.contact);
        if (!t.contact.contact) continue;
        return begin_contact(t, static_cast<int>(m));
    }
}

/// No contact yet: the proxy is at the master, or at the nearest point of the surface while the master is inside.
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
    if (asked.energy_model && static_cast<int>(mesh) == t.record.mesh) return t.spring.shown_push(push_of(t, t.record.master_m, mesh), u, t.memory[mesh].empty() ? nullptr : &t.memory[mesh]);
    if (asked.energy_model) return t.spring.push_at(-t.record.coupling_N, u, &t.memory[mesh]);
    const Cells& facets = asked.springs.facets();
    Point sum = Point::Zero(model_.dimension());
    for (Eigen::Index k = 0; k < facets.cols(); ++k) sum += t.record.weight[k] * u.row(facets(t.record.facet, k)).transpose();
    return sum;
}

void Simulation::displayed(std::size_t mesh, NodeColumns& displacement_m) const noexcept {
    displacement_m = states_[mesh].displacement;
    if (!energy_models_[mesh]) return;
    for (int k = 0; k < tool_count(); ++k)
        if (const TickRecord& r = record(k); r.mesh >= 0) energy_models_[mesh]->contacts(k).show_skin(r.facet, {r.weight[0], r.weight[1], r.weight[2]}, displacement_at_contact(mesh, k), displacement_m);
}

}  // namespace tissue
