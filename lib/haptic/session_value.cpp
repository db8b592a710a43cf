// Simulation outside a tick: copies, saved states, changes of options, and take-over of another session.
#include "haptic/simulation.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

#include "error.h"
#include "flush_denormals.h"

namespace tissue {

Simulation::Simulation(const Simulation& other) : Simulation(other.model_) {
    for (std::size_t k = 0; k < tools_.size(); ++k) tools_[k].options = other.tools_[k].options;
    std::vector<std::byte> state(other.state_size());
    other.save(state.data());
    restore(state.data(), state.size());
    for (std::size_t k = 0; k < tools_.size(); ++k) tools_[k].contacts = other.tools_[k].contacts;
    begun_ = other.begun_;
    followed_ = other.followed_;
}

void Simulation::fields(StateBytes& state) noexcept {
    state(due_s_, spare_s_, since_, period_s_, advanced_s_, cost_, usual_s_, states_, tools_, sound_, rested_s_, reset_, set_, counters_);
    for (const auto& law : energy_models_)
        if (law) state(*law);
    for (const auto& surface : surfaces_) surface->fields(state);
    if (!state.reads()) return;
    place_surfaces();
    for (ToolState& t : tools_) {
        if (t.touched >= 0 && model_.is_energy_model()) contacts_of(t).at(t.contact.where.facet, t.contact.where.weight, ToolSpring::Growth(t.spring.growth()), t.spring);
        t.show_no_more(on_energy_model(t));
    }
}

namespace {

/// Header of a saved state.
struct StateHead {
    char magic[8];
    std::uint64_t fingerprint, size, checksum;  ///< fingerprint of the model; size and checksum of the bytes after it
};

constexpr char state_magic[8] = {'T', 'S', 'T', 'A', 'T', 'E', '0', '1'};

}  // namespace

std::size_t Simulation::state_size() const noexcept {
    StateBytes count = StateBytes::counting();
    const_cast<Simulation*>(this)->fields(count);  // counting does not write
    return sizeof(StateHead) + count.size();
}

void Simulation::save(std::byte* to) const noexcept {
    StateBytes bytes = StateBytes::writing(to + sizeof(StateHead));
    const_cast<Simulation*>(this)->fields(bytes);
    StateHead head{{}, model_.fingerprint, bytes.size(), XXH3_64bits(to + sizeof(StateHead), bytes.size())};
    std::copy_n(state_magic, sizeof state_magic, head.magic);
    std::memcpy(to, &head, sizeof head);
}

namespace {

bool same(const SafetyOptions& a, const SafetyOptions& b) {
    const auto all = [](const SafetyOptions& o) { return std::tie(o.dt_s, o.force_max_N, o.slew_N_s, o.speed_max_m_s, o.stale_s, o.hold_s, o.passivity, o.damping_max_Ns_m); };
    return all(a) == all(b);
}

}  // namespace

void Simulation::restore(const std::byte* from, std::size_t size) {
    StateHead head{};
    if (size != state_size()) throw MismatchError(fmt::format("a state of {} bytes for a session that has {}", size, state_size()));
    std::memcpy(&head, from, sizeof head);
    if (std::memcmp(head.magic, state_magic, sizeof state_magic) != 0) throw MismatchError("the bytes are not the state of a session");
    if (head.fingerprint != model_.fingerprint) throw MismatchError("the state is of a session with another model or other options");
    if (head.size != size - sizeof head || head.checksum != XXH3_64bits(from + sizeof head, size - sizeof head)) throw MismatchError("the session's state is damaged");
    const FlushDenormals mode;
    const bool begun = begun_;
    SafetyOptions own[most_tools];
    double device_N[most_tools];
    for (int k = 0; k < tool_count(); ++k) own[k] = of(k).options.safety, device_N[k] = of(k).options.device.force_max_N;
    StateBytes bytes = StateBytes::reading(from + sizeof head);
    fields(bytes);
    for (int k = 0; begun && k < tool_count(); ++k) {
        ToolState& t = of(k);
        t.options.device.force_max_N = device_N[k];
        if (same(t.options.safety, own[k])) continue;  // the state stays as it is, bit for bit
        t.safety.become(own[k]);
        t.options.safety = own[k];
        t.show_no_more(on_energy_model(t));
    }
    for (ToolState& t : tools_) ++t.contacts;
    begun_ = begun || counters_.ticks > 0;
    ++restores_;
}

void Simulation::change(const HapticOptions& given, int tool) {
    ToolState& t = of(tool);
    HapticOptions next = t.options;
    next.map = given.map;
    next.friction = given.friction;
    next.grasp_max_N = given.grasp_max_N;
    next.device = given.device;
    const bool begun = begun_;
    if (begun) next.device.force_max_N = t.options.device.force_max_N;
    else {
        const double hold_s = next.safety.hold_s, dt_s = next.safety.dt_s;
        next.safety = given.safety;
        next.safety.hold_s = hold_s, next.safety.dt_s = dt_s;
        next.safety.force_max_N = std::min(next.safety.force_max_N, next.device.force_max_N);
    }
    next.map.fit(model_.dimension());
    check_options(next);
    if (std::isfinite(next.grasp_max_N)) model_.check_grasp(tool);
    for (const auto& mesh : model_.meshes) check_device(next.device, next.map, next.dt_s, *mesh);
    const FlushDenormals mode;
    t.friction.become(next.friction);
    const bool tool_stays = next.map.same_as(t.options.map);
    t.options = std::move(next);
    if (!begun) t.safety = Safety(t.options.safety);
    t.show_no_more(on_energy_model(t));
    if (tool_stays || !t.has_master) return;
    const Point now = t.options.map.to_tissue(t.device_m), moved = now - t.record.master_m;
    t.record.master_m = now;
    t.at_m += moved;
    t.velocity_m_s.setZero();
    if (moved.norm() <= t.options.safety.speed_max_m_s * t.options.map.scale * t.options.dt_s) return;
    t.disarm(now);
}

void Simulation::follow(const Simulation& from) {
    check_take_over(from);
    if (begun_) throw MismatchError("only a session that has not ticked yet can follow another");
    for (int k = 0; k < tool_count(); ++k) {
        ToolState& t = of(k);
        const ToolState& theirs = from.of(k);
        HapticOptions options = theirs.options;
        if (!model_.grasps(k)) options.grasp_max_N = std::numeric_limits<double>::infinity();
        change(options, k);
        t.safety.go_on_from(theirs.safety);  // gives the limits of `theirs`, which the next line reads
        t.options.safety = t.safety.options();
        t.options.device = theirs.options.device;
        t.safety = Safety(t.options.safety);
    }
    followed_.clear();
    for (const ToolState& theirs : from.tools_) followed_.push_back(theirs.contacts);
    std::vector<Point> at_m;  // positions of the tools
    for (int k = 0; k < tool_count(); ++k) at_m.push_back(way_to(from, k).outside_m);
    for (int k = 0; k < tool_count(); ++k)
        if (from.of(k).armed) lead_to(from, k, at_m);
    for (int k = 0; k < tool_count(); ++k)
        if (const ToolState &t = of(k), &theirs = from.of(k); theirs.armed && (!t.armed || t.record.status != TickStatus::done || t.contact.contact != (theirs.touched >= 0)))
            throw MismatchError("the tool cannot be moved to the place of the other session's tool: this tissue has another shape there, or is too stiff");
}

/// Path to a tool's place in the other session. For a tool that touches nothing there, all three points are its
/// position.
Simulation::Way Simulation::way_to(const Simulation& from, int tool) const {
    const ToolState& theirs = from.of(tool);
    const Point tool_m = theirs.record.master_m;
    if (theirs.touched < 0) return {tool_m, tool_m, tool_m};
    const auto m = static_cast<std::size_t>(theirs.touched);
    const HapticMesh& mesh = *from.model_.meshes[m];
    if (m >= model_.meshes.size() || (model_.meshes[m]->place_m - mesh.place_m).norm() > 1e-9) throw MismatchError("the other session's tool touches a mesh that this session does not have");
    const FreeSurface::Place place = model_.surface.nearest(mesh.springs.rest_place(theirs.contact.where.facet, theirs.contact.where.weight));
    const Point touched_m = place.point_m + mesh.place_m;
    return {touched_m - model_.surface.spacing_m() * place.inward, touched_m, tool_m};
}

/// Moves a tool to its place in the other session, as a hand would: from outside to the point of contact, then to the
/// tool's position, where it waits. The other tools stay where they are.
void Simulation::lead_to(const Simulation& from, int tool, std::vector<Point>& at_m) {
    constexpr double most_ticks = 5000, fewest_ticks = 50, waits_s = 0.3;
    const HapticOptions& o = options(tool);
    // mean speed; the largest is 1.5 times that
    const double speed_m_s = std::min(0.05, o.safety.speed_max_m_s * o.map.scale / 3);
    std::vector<DeviceSample> samples(tools_.size());
    std::vector<Eigen::Vector3d> force_N(tools_.size());
    const auto tick_at = [&](const Point& tool_m) {
        at_m[static_cast<std::size_t>(tool)] = tool_m;
        for (std::size_t k = 0; k < tools_.size(); ++k) {
            samples[k].position_m = tools_[k].options.map.to_device(at_m[k]);
            samples[k].valid = from.tools_[k].armed;  // a tool that is not armed has no contact
        }
        tick(samples.data(), force_N.data());
    };
    const Way way = way_to(from, tool);
    if (from.of(tool).touched < 0) return tick_at(way.tool_m);
    const auto ticks = [&](double seconds) { return static_cast<int>(std::clamp(seconds / o.dt_s, fewest_ticks, most_ticks)); };
    const auto lead = [&](const Point& from_m, const Point& to_m) {
        const int count = ticks((to_m - from_m).norm() / speed_m_s);
        for (int k = 0; k <= count; ++k) {
            const double s = static_cast<double>(k) / count;
            tick_at(from_m + s * s * (3 - 2 * s) * (to_m - from_m));
        }
    };
    lead(way.outside_m, way.touched_m);
    lead(way.touched_m, way.tool_m);
    for (int k = ticks(waits_s); k > 0; --k) tick_at(way.tool_m);
}

void Simulation::take_over(const Simulation& from) noexcept {
    begun_ = begun_ || from.begun_;
    counters_ = from.counters_;
    rested_s_ = from.record().time_s;
    std::copy_n(from.since_, 2, since_);
    period_s_ = from.period_s_;
    usual_s_ = from.usual_s_;
    advanced_s_ = 0;  // the cost of the other session's last tick is not counted
    for (int k = 0; k < tool_count(); ++k) {
        ToolState& t = of(k);
        t.take_over(from.of(k), period_s_);
        if (model_.grasps(k)) t.options.grasp_max_N = from.of(k).options.grasp_max_N;
        t.show_no_more(on_energy_model(t));
    }
}

void Simulation::check_take_over(const Simulation& from) const {
    if (from.model_.dimension() != model_.dimension()) throw MismatchError(fmt::format("a session of {} axes cannot take over from one of {} axes", model_.dimension(), from.model_.dimension()));
    if (from.tool_count() != tool_count()) throw MismatchError(fmt::format("a session of {} tools cannot take over from one of {} tools", tool_count(), from.tool_count()));
    if (const double hold_s = from.options().safety.hold_s; !(model_.options.dt_s <= hold_s / 2))
        throw MismatchError(fmt::format("dt is {:g} s, and the device of the other session holds a force for {:g} s: dt must be at most half of that", model_.options.dt_s, hold_s));
    for (std::size_t k = 0; k < followed_.size(); ++k)
        if (from.tools_[k].touched >= 0 && from.tools_[k].contacts != followed_[k])
            throw MismatchError("the tool has made a new contact since follow(): follow it again with a new session");
    for (const ToolState& theirs : from.tools_) {
        if (theirs.grasps) throw MismatchError("a tool grasps the tissue: release it before another model takes over");
        for (const auto& mesh : model_.meshes) check_device(theirs.options.device, theirs.options.map, model_.options.dt_s, *mesh);
    }
}

}  // namespace tissue
