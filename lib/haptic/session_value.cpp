// A session as a value, and what changes while it runs: everything of Simulation that is no part of a tick.
#include "haptic/simulation.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "error.h"
#include "flush_denormals.h"

namespace tissue {

Simulation::Simulation(const Simulation& other) : Simulation(other.model_) {
    options_ = other.options_;
    std::vector<std::byte> state(other.state_size());
    other.save(state.data());
    restore(state.data(), state.size());
}

void Simulation::fields(StateBytes& state) noexcept {
    DeviceImpedance& device = options_.device;
    state(options_.map, device_m_, device.mass_kg, device.damping_Ns_m, device.stiffness_N_m, device.force_max_N, device.rate_Hz, safety_, due_s_, spare_s_, since_, period_s_, went_s_, cost_, usual_s_, stood_s_, same_position_s_, old_s_, expected_s_, has_master_, clutched_,
          taken_over_, carried_N_, states_, contact_, touched_, coupling_N_m_, tool_memory_, tool_m_, velocity_m_s_, slid_m_, slide_m_s_, touched_m_, friction_, armed_, sound_, rested_s_,
          reset_, untouched_s_, set_, counters_, record_);
    ToolSpring::Growth growth = tool_.growth();
    state(growth);
    for (const auto& law : laws_)
        if (law) state(*law);
    for (const auto& surface : surfaces_) surface->fields(state);
    if (!state.reads()) return;
    options_.friction = friction_.options();
    options_.safety = safety_.options();
    place_surfaces();
    tool_.grow(growth);
    if (touched_ >= 0 && model_.is_law()) laws_[0]->contact(contact_.where.facet, contact_.where.weight, growth, tool_);
    show_no_more();
}

namespace {

/// In front of a state's bytes.
struct StateHead {
    char magic[8];
    std::uint64_t fingerprint, size, checksum;  ///< of the model; of what follows
};

constexpr char state_magic[8] = {'T', 'S', 'T', 'A', 'T', 'E', '0', '1'};

}  // namespace

std::size_t Simulation::state_size() const noexcept {
    StateBytes count = StateBytes::counting();
    const_cast<Simulation*>(this)->fields(count);  // which does not write where it counts
    return sizeof(StateHead) + count.size();
}

void Simulation::save(std::byte* to) const noexcept {
    StateBytes bytes = StateBytes::writing(to + sizeof(StateHead));
    const_cast<Simulation*>(this)->fields(bytes);
    StateHead head{{}, model_.fingerprint, bytes.size(), XXH3_64bits(to + sizeof(StateHead), bytes.size())};
    std::copy_n(state_magic, sizeof state_magic, head.magic);
    std::memcpy(to, &head, sizeof head);
}

void Simulation::restore(const std::byte* from, std::size_t size) {
    StateHead head{};
    if (size != state_size()) throw MismatchError(fmt::format("a state of {} bytes for a session that has {}", size, state_size()));
    std::memcpy(&head, from, sizeof head);
    if (std::memcmp(head.magic, state_magic, sizeof state_magic) != 0) throw MismatchError("these bytes are no session's state");
    if (head.fingerprint != model_.fingerprint) throw MismatchError("the state is of a session of another model, or of other options");
    if (head.size != size - sizeof head || head.checksum != XXH3_64bits(from + sizeof head, size - sizeof head)) throw MismatchError("the session's state is damaged");
    const FlushDenormals mode;
    StateBytes bytes = StateBytes::reading(from + sizeof head);
    fields(bytes);
    ++restores_;
}

void Simulation::change(const HapticOptions& given) {
    HapticOptions next = options_;
    next.map = given.map;
    next.friction = given.friction;
    next.device = given.device;
    next.device.force_max_N = options_.device.force_max_N;
    next.map.fit(model_.dimension());
    check_options(next);
    for (const auto& mesh : model_.meshes) check_device(next.device, next.map, next.dt_s, *mesh);
    const FlushDenormals mode;
    friction_.become(next.friction);
    const bool tool_stays = next.map.same_as(options_.map);
    options_ = std::move(next);
    show_no_more();
    if (tool_stays || !has_master_) return;
    const Point now = options_.map.to_tissue(device_m_), moved = now - record_.master_m;
    record_.master_m = now;
    tool_m_ += moved;
    velocity_m_s_.setZero();
    if (moved.norm() <= options_.safety.speed_max_m_s * options_.map.scale * options_.dt_s) return;
    disarm(now);
}

void Simulation::forget_taken_over() noexcept {
    carried_N_.setZero();
    taken_over_ = false;
}

void Simulation::follow(const Simulation& from) {
    check_take_over(from);
    if (counters_.ticks > 0) throw MismatchError("only a session that has not ticked yet follows another");
    change(from.options_);
    safety_.go_on_from(from.safety_);  // for its limits
    options_.safety = safety_.options();
    options_.device = from.options_.device;
    safety_ = Safety(options_.safety);
    if (!from.armed_) return;
    lead_to(from);
    if (!armed_ || record_.status != TickStatus::done || contact_.contact != (from.touched_ >= 0))
        throw MismatchError("the tool cannot be led to where the other session's is: this tissue is of another shape there, or too stiff");
}

/// The tool goes to where the other session's is, as a hand would: from outside to the place that it touches, on to where it is, and waits there.
void Simulation::lead_to(const Simulation& from) {
    constexpr double most_ticks = 5000, fewest_ticks = 50, waits_s = 0.3;
    const double speed_m_s = std::min(0.05, options_.safety.speed_max_m_s * options_.map.scale / 3);  // on average; the most is half as much again
    const auto tick_at = [&](const Point& tool_m) {
        DeviceSample sample;
        sample.position_m = options_.map.to_device(tool_m);
        tick(sample);
    };
    const Point tool_m = from.record_.master_m;
    if (from.touched_ < 0) return tick_at(tool_m);
    const auto m = static_cast<std::size_t>(from.touched_);
    const HapticMesh& theirs = *from.model_.meshes[m];
    if (m >= model_.meshes.size() || (model_.meshes[m]->place_m - theirs.place_m).norm() > 1e-9) throw MismatchError("the other session's tool touches a mesh that is not here");
    const FreeSurface::Place place = model_.surface.nearest(theirs.springs.rest_place(from.contact_.where.facet, from.contact_.where.weight));
    const Point touched_m = place.point_m + theirs.place_m, outside_m = touched_m - model_.surface.spacing_m() * place.inward;
    const auto ticks = [&](double seconds) { return static_cast<int>(std::clamp(seconds / options_.dt_s, fewest_ticks, most_ticks)); };
    const auto lead = [&](const Point& from_m, const Point& to_m) {
        const int count = ticks((to_m - from_m).norm() / speed_m_s);
        for (int k = 0; k <= count; ++k) {
            const double s = static_cast<double>(k) / count;
            tick_at(from_m + s * s * (3 - 2 * s) * (to_m - from_m));
        }
    };
    lead(outside_m, touched_m);
    lead(touched_m, tool_m);
    for (int k = ticks(waits_s); k > 0; --k) tick_at(tool_m);
}

void Simulation::take_over(const Simulation& from) noexcept {
    safety_.go_on_from(from.safety_);
    counters_ = from.counters_;
    record_.time_s = rested_s_ = from.record_.time_s;
    record_.device_m = from.record_.device_m;
    record_.master_m = from.record_.master_m;
    options_.map = from.options_.map;  // a clutch may have moved it since
    options_.device = from.options_.device;
    options_.safety = safety_.options();
    show_no_more();
    device_m_ = from.device_m_;
    has_master_ = from.has_master_;
    clutched_ = from.clutched_;
    std::copy_n(from.since_, 2, since_);
    period_s_ = from.period_s_;
    usual_s_ = from.usual_s_;
    velocity_m_s_ = from.velocity_m_s_;
    expected_s_ = from.expected_s_;
    same_position_s_ = from.same_position_s_;
    old_s_ = from.old_s_;
    stood_s_ = from.stood_s_;
    went_s_ = 0;  // its ticks cost what they will
    tool_m_ = tool_at_the_end(record_.master_m) - period_s_ * velocity_m_s_;
    taken_over_ = true;
    friction_.become(options_.friction = from.options_.friction);
    if (!from.armed_) disarm(record_.master_m);  // it was stopped after follow()
}

void Simulation::check_take_over(const Simulation& from) const {
    if (from.model_.dimension() != model_.dimension()) throw MismatchError(fmt::format("a session of {} axes cannot go on where one of {} was", model_.dimension(), from.model_.dimension()));
    if (const double hold_s = from.options_.safety.hold_s; !(model_.options.dt_s <= hold_s / 2))
        throw MismatchError(fmt::format("dt is {:g} s, and the device of the other session holds a force for {:g} s: dt must be at most half of that", model_.options.dt_s, hold_s));
    for (const auto& mesh : model_.meshes) check_device(from.options_.device, from.options_.map, model_.options.dt_s, *mesh);
}

}  // namespace tissue
