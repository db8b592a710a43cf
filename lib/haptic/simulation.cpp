#include "haptic/simulation.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "error.h"
#include "flush_denormals.h"
#include "haptic/dynamics_kinds.h"
#include "haptic/law_spectrum.h"
#include "haptic/session_options.h"
#include "haptic/spectrum.h"
#include "hot_loop.h"
#include "springs/spring_sets.h"
#include "version.h"

namespace tissue {
namespace kernel {

/// (19): theta = (1 - gamma) theta + gamma theta_set.
TISSUE_HOT void average(int n, double gamma, const double* __restrict set, double* __restrict theta) {
    for (int k = 0; k < n; ++k) theta[k] = (1 - gamma) * theta[k] + gamma * set[k];
}

}  // namespace kernel

namespace {

constexpr double elastic_law_damping_ratio = 0.17, relaxing_damping_ratio = 0.01;
constexpr double usual_innovation = 0.05, usual_coupling_ratio = 10;
constexpr double swings_out_s = 0.5;  ///< a tool that touches again so soon meets what its last contact has left in motion, and belongs to it
constexpr double carried_s = 0.1;    ///< a force of a session that was taken over fades with this time constant
constexpr int most_periods = 16;  ///< that a mesh goes through in one tick, to make up for late ones
constexpr double turn = 2 * 3.14159265358979323846;

std::unique_ptr<HapticMesh> make_mesh(const std::string& name, const TissueModel& model, const std::string& law,
                                      const Eigen::Ref<const NodeField>& theta, const Point& place_m) {
    if (!theta.allFinite() || !(theta.minCoeff() > 0))
        throw MismatchError(fmt::format("the {} mesh has springs that are not positive", name));
    auto mesh = std::make_unique<HapticMesh>(
        HapticMesh{name, RealtimeMesh(model.mesh, law, model.node_mass_kg), {}, nullptr, place_m, "", 1, 0, 0, 0, 0, 0, 0, 0});
    mesh->theta_of_set.resize(mesh->springs.slot_count(), theta.rows());
    for (Eigen::Index c = 0; c < theta.rows(); ++c) mesh->theta_of_set.col(c) = mesh->springs.to_slots(theta.row(c).transpose());
    return mesh;
}

std::unique_ptr<HapticMesh> make_law_mesh(const std::string& name, const TissueModel& model, const Point& place_m) {
    const NodeField theta = model.energy_law->constants.head(model.mesh.spring_count()).transpose();
    auto mesh = make_mesh(name, model, "geometric", theta, place_m);
    mesh->law = std::make_unique<RealtimeLaw>(model, mesh->springs);
    return mesh;
}

/// In space: Van Gelder's springs as they are, without cells, under the learned law's contact. A point load on a lattice in space
/// has no stiffness of its own, so that springs under a virtual coupling would say nothing (in the plane they do).
TissueModel untrained(const TissueModel& model) {
    TissueModel heuristic = model;
    Eigen::VectorXd& constants = heuristic.energy_law->constants;
    constants.setZero();
    constants.head(model.mesh.spring_count()) = model.heuristic_a;
    return heuristic;
}

/// The tool goes straight on through a tick's steps, so that their mean force is that of (n - 1) / 2n of dt after its start.
double lead_of(const HapticMesh& mesh, double dt_s) {
    return (mesh.substeps - 1) / (2.0 * mesh.substeps) + mesh.contact_damping_s / dt_s;
}

/// Which step runs, and with how much damping: from the spectrum, of the instantaneous stiffness.
void choose_law_dynamics(const TissueModel& model, HapticMesh& mesh, const HapticOptions& o) {
    const LawSpectrum spectrum = law_spectrum(model, mesh.springs);
    const double lowest = std::sqrt(spectrum.smallest);
    mesh.largest_eigenvalue_1_s2 = spectrum.largest;
    mesh.contact_N_m = o.stiffest * spectrum.contact_N_m;
    mesh.static_N_m = o.stiffest * spectrum.static_N_m;
    mesh.dynamics = o.dynamics == "auto" ? "symplectic" : o.dynamics;
    mesh.substeps = law_substeps(o.stiffest * spectrum.largest, o.dt_s);
    mesh.lowest_frequency_Hz = lowest / turn;
    mesh.damping_1_s = 2 * *o.damping_ratio * lowest;
    mesh.contact_damping_s = law_contact_damping_s(o.stiffest * spectrum.largest, o.dt_s, mesh.substeps);
    mesh.lead = lead_of(mesh, o.dt_s);
    make_dynamics(mesh.dynamics, mesh.springs, {o.dt_s / mesh.substeps, mesh.damping_1_s, mesh.law.get()});  // throws here, if at all
}

void choose_dynamics(HapticMesh& mesh, const HapticOptions& o, double damping_ratio, double coupling_N_m) {
    double bare = 0;
    for (Eigen::Index c = 0; c < mesh.theta_of_set.cols(); ++c) {
        const double here = largest_eigenvalue(mesh.springs, mesh.theta_of_set.col(c));
        if (here > bare || std::isnan(here)) bare = here;  // std::max would lose what is no number
    }
    double lightest = 0;
    for (int node : mesh.springs.outline()) lightest = std::max(lightest, mesh.springs.inverse_mass()[node]);
    mesh.largest_eigenvalue_1_s2 = bare + coupling_N_m * lightest;
    mesh.contact_N_m = coupling_N_m;
    mesh.static_N_m = coupling_N_m / *o.coupling_ratio;
    mesh.dynamics = o.dynamics == "auto" ? stable_dynamics(mesh.largest_eigenvalue_1_s2, o.dt_s) : o.dynamics;
    mesh.contact_damping_s = mesh.dynamics == paper_dynamics.name ? 0 : contact_damping_s(o.dt_s, 1);
    if (mesh.dynamics == symplectic_dynamics.name) {  // as many steps as the contact's damper needs: omega^2 + 2 ahead / h coupling / mass within the step's limit
        constexpr int most_steps = 8;
        const auto room = [&](double h) { return std::pow(symplectic_dynamics.stable_omega_dt / h, 2) - mesh.largest_eigenvalue_1_s2; };
        for (mesh.substeps = 1;; ++mesh.substeps) {
            const double h = o.dt_s / mesh.substeps, longest_s = room(h) * h / (2 * coupling_N_m * lightest), wanted_s = contact_damping_s(o.dt_s, mesh.substeps);
            mesh.contact_damping_s = std::clamp(longest_s, 0.0, wanted_s);
            if (longest_s >= wanted_s || mesh.substeps == most_steps) break;
        }
    }
    mesh.lead = lead_of(mesh, o.dt_s);
    const Eigen::VectorXd mean = mesh.theta_of_set.rowwise().mean();
    const double lowest = std::sqrt(smallest_eigenvalue(mesh.springs, mean));
    mesh.lowest_frequency_Hz = lowest / turn;
    // a mesh that can move for nothing has no lowest mode: a hundredth of its highest stands in
    mesh.damping_1_s = 2 * damping_ratio * (lowest > 0 ? lowest : 0.01 * std::sqrt(bare));
}

/// Both limits are on what the device feels: newtons and metres of its own.
void check_device(const HapticOptions& o, const HapticMesh& mesh) {
    const double scale = o.map.force_scale * o.map.scale;
    const auto refuse = [&](double tissue_N_m, const char* when, double limit_N_m, const std::string& whose) {
        const double most = o.map.force_scale * limit_N_m / (scale * tissue_N_m);
        if (!(most >= o.map.force_scale))
            throw MismatchError(fmt::format("the {} mesh is up to {:.0f} N/m stiff to the device {}, at force-scale {:g}; {} {:.0f} N/m: force-scale may be {:.2f} at most", mesh.name, scale * tissue_N_m, when,
                                            o.map.force_scale, whose, limit_N_m, std::floor(100 * most) / 100));
    };
    refuse(mesh.static_N_m, "at rest", o.device.stiffness_N_m, "the device can show");
    if (o.device.mass_kg > 0)
        refuse(mesh.contact_N_m, "at once", stable_stiffness_N_m(o.device, o.dt_s, mesh.lead),
               fmt::format("a device of {:g} kg and {:g} Ns/m, dt {:g} s, is stable in any hand up to", o.device.mass_kg, o.device.damping_Ns_m, o.dt_s));
}

}  // namespace

void check_options(const HapticOptions& o) {
    for (const SessionOption& option : session_options()) option.check(o);
    if (!(o.dt_s <= o.safety.hold_s / 2)) throw MismatchError(fmt::format("dt must be at most half of hold, {:g} s, not {:g}: the device may let go of an older force", o.safety.hold_s / 2, o.dt_s));
    Friction{o.friction};  // throws where static and kinetic friction contradict each other
    if (!(o.stiffest >= 1)) throw MismatchError("a law may become stiffer by a factor of 1 or more");
    if (!(o.safety.damping_max_Ns_m >= 0)) throw MismatchError("the most that the passivity controller damps must not be negative");
    if (!std::isfinite(o.place_m)) throw MismatchError("the position of the second mesh must be finite");
}

namespace {

std::uint64_t fingerprint_of(const HapticModel& model) {
    XXH3_state_t* hash = XXH3_createState();
    XXH3_64bits_reset(hash);
    const auto add = [&](const void* data, std::size_t bytes) { XXH3_64bits_update(hash, data, bytes); };
    const auto add_array = [&](const auto& values) { add(values.data(), sizeof(*values.data()) * static_cast<std::size_t>(values.size())); };
    add_array(std::string(version));
    const double numbers[] = {model.options.dt_s, model.options.safety.stale_s, model.options.safety.damping_max_Ns_m, *model.options.innovation, static_cast<double>(model.options.select_by), model.options.safety.hold_s, model.options.safety.force_max_N, model.options.safety.slew_N_s, model.options.safety.speed_max_m_s, model.options.stiffest,
                              static_cast<double>(model.options.safety.passivity), static_cast<double>(model.options.energy_book)};
    add(numbers, sizeof numbers);
    for (const auto& mesh : model.meshes) {
        add_array(mesh->springs.rest());
        add_array(mesh->springs.mass());
        add_array(mesh->springs.facets());
        add_array(mesh->theta_of_set);
        const double steps[] = {static_cast<double>(mesh->substeps), mesh->contact_damping_s, mesh->damping_1_s, mesh->contact_N_m, mesh->place_m[0]};
        add(steps, sizeof steps);
        add_array(mesh->dynamics);
        add_array(mesh->springs.law().name());
        if (!mesh->law) continue;
        add_array(mesh->law->stiffness().constants);
        add_array(mesh->law->stiffness().patch.log_N_m);
        add_array(mesh->law->relaxation().tau_s);
        add_array(mesh->law->relaxation().share);
        add_array(mesh->law->relaxation().contact_share);
    }
    const std::uint64_t fingerprint = XXH3_64bits_digest(hash);
    XXH3_freeState(hash);
    return fingerprint;
}

}  // namespace

HapticModel::HapticModel(const TissueModel& model, const HapticOptions& given)
    : study(model.study), options(given), set_names(model.case_names), surface(model.mesh), rest(model.mesh) {
    check_options(given);
    if (model.mesh.is_solid() && !model.energy_law) throw MismatchError("a model in space is a law; this one has none");
    if (!model.mesh.nodes.allFinite()) throw MismatchError("positions of nodes must be finite");
    HapticOptions& o = options;
    const bool damping_asked = o.damping_ratio.has_value();
    if (!o.damping_ratio) o.damping_ratio = !model.energy_law ? 0.05 : model.energy_law->relaxation.empty() ? elastic_law_damping_ratio : relaxing_damping_ratio;
    if (!o.innovation) o.innovation = usual_innovation;
    if (!o.coupling_ratio) o.coupling_ratio = usual_coupling_ratio;
    o.map.fit(model.mesh.dimension());
    o.safety.dt_s = o.dt_s;
    o.safety.force_max_N = std::min(o.safety.force_max_N, o.device.force_max_N);
    low_m = model.mesh.nodes.colwise().minCoeff();
    high_m = model.mesh.nodes.colwise().maxCoeff();
    if (o.place_m == 0) o.place_m = 1.5 * (high_m - low_m).x();

    std::vector<int> first_set(static_cast<std::size_t>(model.mesh.facets.rows()), 0);  // the heuristic mesh has one
    if (model.energy_law) {
        if (!o.sets.empty()) throw MismatchError(fmt::format("spring sets '{}': the model is a law, and has none", o.sets));
        if (o.select_by != SelectBy::displacement) throw MismatchError("the model is a law: there is nothing to select by force");
        if (given.innovation) throw MismatchError("innovation: the model is a law, and averages no sets");
        set_names.clear();
        meshes.push_back(make_law_mesh("learned", model, Point::Zero(dimension())));
    } else {
        const NodeField& theta = sets_of(model, o.sets);
        if (o.sets.empty()) o.sets = model.trained.front().optimizer;
        selector = std::make_unique<Selector>(model, theta, o.select_by);
        for (std::size_t b = 0; b < first_set.size(); ++b) first_set[b] = selector->select(static_cast<int>(b), 0.5, Eigen::Vector2d::Zero());
        meshes.push_back(make_mesh("learned", model, model.law, theta, Eigen::Vector2d::Zero()));
    }
    Point beside = Point::Zero(dimension());
    beside[0] = o.place_m;
    if (o.heuristic_mesh && is_solid())
        meshes.push_back(make_law_mesh("heuristic", untrained(model), beside));
    else if (o.heuristic_mesh)
        meshes.push_back(make_mesh("heuristic", model, model.law, model.heuristic_a.transpose(), beside));  // of the instantaneous E: it remembers nothing
    const auto springs = std::find_if(meshes.begin(), meshes.end(), [](const auto& mesh) { return !mesh->law; });
    if (springs == meshes.end() && given.coupling_ratio) throw MismatchError("coupling: the model is a law with a contact of its own, and no mesh of springs stands beside it");
    if (o.energy_book && (!is_law() || model.energy_law->relaxation.empty())) throw MismatchError("energy-book: the model does not relax, and has no branches to book");
    if (springs != meshes.end())
        stiffness = std::make_unique<ContactStiffness>((*springs)->springs, first_set, (*springs)->theta_of_set);
    for (auto& mesh : meshes) {
        if (mesh->law)
            choose_law_dynamics(mesh->name == "learned" ? model : untrained(model), *mesh, o);
        else
            choose_dynamics(*mesh, o, damping_asked || !model.energy_law ? *o.damping_ratio : elastic_law_damping_ratio, *o.coupling_ratio * stiffness->largest());
        check_device(o, *mesh);
    }
    fingerprint = fingerprint_of(*this);
}

Simulation::Simulation(const HapticModel& model)
    : model_(model), options_(model.options), safety_(model.options.safety), due_s_(model.meshes.size(), 0.0), period_s_(model.options.dt_s), friction_(model.options.friction) {
    for (const auto& mesh : model.meshes) {
        laws_.push_back(mesh->law ? std::make_unique<RealtimeLaw>(*mesh->law) : nullptr);
        states_.emplace_back(mesh->springs, mesh->theta_of_set.col(0));
        surfaces_.push_back(make_moving_surface(model.rest));
        dynamics_.push_back(make_dynamics(mesh->dynamics, mesh->springs,
                                          {model.options.dt_s / mesh->substeps, mesh->damping_1_s, laws_.back().get()}));
        tool_memory_.emplace_back();
        if (!mesh->law) continue;
        const double step_s = model.options.dt_s / mesh->substeps;
        states_.back().memory = mesh->law->memory(step_s);
        if (model.options.energy_book) states_.back().memory.book();
        tool_memory_.back() = mesh->law->tool_memory(step_s);
    }
    record_.master_m = record_.proxy_m = record_.contact_displacement_m = record_.coupling_N = record_.measured_N = Point::Zero(model.dimension());
    no_contact(record_.proxy_m);
    velocity_m_s_ = slid_m_ = slide_m_s_ = Point::Zero(model.dimension());
    held_ = states_.front().displacement;
    place_surfaces();
}

void Simulation::law_changed() noexcept {
    if (touched_ < 0 || !model_.is_law()) return;
    const auto m = static_cast<std::size_t>(touched_);
    const bool remembers = !tool_memory_[m].empty();
    if (remembers) changed_ = tool_;
    laws_[0]->contact(contact_.where.facet, contact_.where.weight, tool_);
    if (remembers) tool_.take_over(changed_, record_.master_m - model_.meshes[m]->place_m - touched_m_, states_[m].displacement, tool_memory_[m]);
}

void Simulation::reset() noexcept {
    rest_meshes();
    reset_ = true;
}

Simulation::Simulation(const Simulation& other) : Simulation(other.model_) {
    options_ = other.options_;
    std::vector<std::byte> state(other.state_size());
    other.save(state.data());
    restore(state.data(), state.size());
}

void Simulation::fields(StateBytes& state) noexcept {
    DeviceImpedance& device = options_.device;
    state(options_.map, device_m_, device.mass_kg, device.damping_Ns_m, device.stiffness_N_m, device.force_max_N, safety_, due_s_, period_s_, same_position_s_, expected_s_, has_master_, clutched_,
          taken_over_, carried_N_, states_, contact_, touched_, coupling_N_m_, tool_memory_, tool_m_, velocity_m_s_, slid_m_, slide_m_s_, touched_m_, friction_, armed_, sound_, rested_s_,
          reset_, untouched_s_, set_, counters_, record_);
    for (const auto& law : laws_)
        if (law) state(*law);
    for (const auto& surface : surfaces_) surface->fields(state);
    if (!state.reads()) return;
    options_.friction = friction_.options();
    place_surfaces();
    if (touched_ >= 0 && model_.is_law()) laws_[0]->contact(contact_.where.facet, contact_.where.weight, tool_);
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
    for (const auto& mesh : model_.meshes) check_device(next, *mesh);
    const FlushDenormals mode;
    friction_.become(next.friction);
    const bool tool_stays = next.map.same_as(options_.map);
    options_ = std::move(next);
    if (tool_stays || !has_master_) return;
    const Point now = options_.map.to_tissue(device_m_), moved = now - record_.master_m;
    record_.master_m = now;
    tool_m_ += moved;
    velocity_m_s_.setZero();
    if (moved.norm() <= options_.safety.speed_max_m_s * options_.map.scale * options_.dt_s) return;
    forget_taken_over();
    no_contact(now);
    touched_ = -1;
    armed_ = false;
}

void Simulation::forget_taken_over() noexcept {
    carried_N_.setZero();
    taken_over_ = false;
}

void Simulation::follow(const Simulation& from) {
    if (from.model_.dimension() != model_.dimension()) throw MismatchError(fmt::format("a session of {} axes cannot go on where one of {} was", model_.dimension(), from.model_.dimension()));
    if (counters_.ticks > 0) throw MismatchError("only a session that has not ticked yet follows another");
    change(from.options_);
    if (!from.armed_) return;
    lead_to(from);
    if (!armed_ || record_.status != TickStatus::done || contact_.contact != (from.touched_ >= 0))
        throw MismatchError("the tool cannot be led to where the other session's is: this tissue is of another shape there, or too stiff");
}

/// The tool goes to where the other session's is, as a hand would: from outside to the place that it touches, on to where it is, and waits there.
void Simulation::lead_to(const Simulation& from) {
    constexpr double most_ticks = 5000, fewest_ticks = 50, waits_s = 0.3, speed_m_s = 0.05;
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
    device_m_ = from.device_m_;
    has_master_ = from.has_master_;
    clutched_ = from.clutched_;
    period_s_ = from.period_s_;
    velocity_m_s_ = from.velocity_m_s_;
    expected_s_ = from.expected_s_;
    same_position_s_ = from.same_position_s_;
    tool_m_ = tool_at_the_end(record_.master_m) - period_s_ * velocity_m_s_;
    taken_over_ = true;
}

double Simulation::kinetic_J() const noexcept {
    double twice = 0;
    const Eigen::VectorXd& mass = model_.meshes[0]->springs.mass();
    for (Eigen::Index n = 0; n < mass.size(); ++n) twice += mass[n] * states_[0].velocity.row(n).squaredNorm();
    return twice / 2;
}

void Simulation::rest_meshes() noexcept {
    for (MeshState& state : states_) {
        state.displacement.setZero();
        state.velocity.setZero();
        state.acceleration.setZero();
        state.memory.forget();
        state.theta_changed = true;
    }
    place_surfaces();
    forget_taken_over();
    no_contact(Point::Zero(model_.dimension()));
    touched_ = -1;
    armed_ = false;
    untouched_s_ = 0;
    rested_s_ = record_.time_s;
}

/// What is no duration says that nobody knows how late the tick is: as late as the device holds a force.
static double since_last_s(double elapsed_s, const HapticOptions& o) noexcept {
    constexpr double longest_s = 3600;
    if (elapsed_s == 0) return o.dt_s;
    if (elapsed_s > 0 && std::isfinite(elapsed_s)) return std::min(elapsed_s, longest_s);
    return std::isfinite(o.safety.hold_s) ? std::min(o.safety.hold_s, longest_s) : force_held_s;
}

/// The tissue has to come to the end of the time in which this tick's force is held, which will be as long as the ticks before were.
void Simulation::time_passes(double seconds) noexcept {
    constexpr double longest_debt_s = 0.5;
    const double longest_period_s = std::max(0.02, 4 * model_.options.dt_s);
    record_.time_s += seconds;
    if (seconds <= longest_period_s) period_s_ += std::max(0.02, 1 / static_cast<double>(counters_.ticks)) * (seconds - period_s_);
    for (double& due_s : due_s_) {
        due_s += seconds;
        if (due_s <= longest_debt_s) continue;
        if (&due_s == &due_s_.front()) counters_.lost_s += due_s - longest_debt_s;
        due_s = longest_debt_s;
    }
    untouched_s_ += std::min(seconds, longest_debt_s);  // of a stall, what meshes go through
}

int Simulation::steps_due(std::size_t m) noexcept {
    const HapticMesh& mesh = *model_.meshes[m];
    const double h = model_.options.dt_s / mesh.substeps, left_s = due_s_[m] - model_.options.dt_s + period_s_;
    const double most = std::max(most_periods * model_.options.dt_s, 2 * period_s_) / h;  // or a slow host would never catch up
    const int steps = static_cast<int>(std::clamp(std::round(left_s / h), 0.0, std::round(most)));
    due_s_[m] -= steps * h;
    return steps;
}

Eigen::Vector3d Simulation::tick(const DeviceSample& sample, double elapsed_s) noexcept {
    const FlushDenormals mode;
    return advance(sample, elapsed_s);
}

/// How fast the master is. A hand faster than speed-max is none, nor is one whose way since its last position nobody knows.
void Simulation::follow_hand(const Point& moved_m) noexcept {
    const HapticOptions& o = options_;
    const double most = o.safety.speed_max_m_s * o.map.scale, between_s = safety_.between_s();
    if (!safety_.has_motion()) {
        velocity_m_s_.setZero();
        expected_s_ = same_position_s_ = 0;
    } else if (between_s > 0) {
        velocity_m_s_ += std::min(1.0, between_s / o.dt_s) * (moved_m / between_s - velocity_m_s_);
        expected_s_ = std::min(between_s, o.safety.stale_s);
        same_position_s_ = 0;
    }
    const double speed = velocity_m_s_.norm();
    if (!std::isfinite(speed))
        velocity_m_s_.setZero();
    else if (speed > most)
        velocity_m_s_ *= most / speed;
}

/// Where the hand will be at the end of the time in which this tick's force is held. Where its positions come less often than ticks it goes on meanwhile, but
/// not for longer than from one to the next.
Point Simulation::tool_at_the_end(const Point& master_m) const noexcept {
    return master_m + (period_s_ + std::min(same_position_s_, expected_s_)) * velocity_m_s_;
}

/// In the mode of tick(): out of line, so that nothing of it is computed before or after.
__attribute__((noinline)) Eigen::Vector3d Simulation::advance(const DeviceSample& sample, double elapsed_s) noexcept {
    const HapticOptions& o = options_;
    if (sample.reset) reset();
    const TickRecord last = record_;
    ++counters_.ticks;
    record_ = {};
    record_.reset = std::exchange(reset_, false);
    record_.proxy_m = record_.contact_displacement_m = record_.coupling_N = Point::Zero(model_.dimension());
    record_.measured_N = o.map.force_to_tissue(sample.measured_N);
    record_.time_s = last.time_s;
    const double since_s = since_last_s(elapsed_s, o);
    time_passes(since_s);
    same_position_s_ += since_s;
    record_.device_m = sample.position_m.allFinite() ? sample.position_m : last.device_m;
    record_.master_m = last.master_m;

    const bool lost = put_to_rest();

    // device position
    if (!safety_.admit(sample, since_s)) return stop(TickStatus::refused);
    if (clutched_ && has_master_) options_.map.offset_m += last.master_m - o.map.to_tissue(sample.position_m);
    const Point master = o.map.to_tissue(sample.position_m);
    record_.master_m = master;
    device_m_ = sample.position_m;
    has_master_ = true;
    follow_hand(master - last.master_m);

    // 4.2 collision detection
    if (lost) return stop(TickStatus::diverged);
    if (!move_surfaces() || !find_contact(master)) return stop(TickStatus::folded);
    if (!armed_) record_.status = TickStatus::not_armed;

    // Coulomb: the contact goes along the surface
    if (contact_.pressing) slide(master);

    // 4.3 selection of mesh constants, and their moving average (18)-(19)
    if (contact_.pressing && !model_.is_law()) select_set(-last.coupling_N);
    if (!model_.is_law()) average_stiffness();

    // 4.1 deformation, with the coupling force of 4.2 on the segment's end nodes, on every mesh alike (4.4)
    const Point on_tissue = step_meshes(master);
    if (put_to_rest()) return stop(TickStatus::diverged);
    record_.coupling_N = -on_tissue;
    if (model_.is_law()) record_.contact_displacement_m = displacement_at_contact(0);

    // safety, device force
    if (untouched_s_ > swings_out_s && safety_.force_N().isZero(0)) safety_.forget_credit();
    if (!armed_) return record_.device_N = safety_.stop();
    Eigen::Vector3d wanted = o.map.force_to_device(-on_tissue);
    if (std::exchange(taken_over_, false)) carried_N_ = safety_.force_N() - wanted;
    if (!contact_.contact) carried_N_.setZero();
    wanted += carried_N_;
    carried_N_ *= std::exp(-since_s / carried_s);
    if (clutched_) wanted.setZero();
    record_.device_N = safety_.limit(wanted, !clutched_);
    return record_.device_N;
}

Eigen::Vector3d Simulation::stand_still() noexcept {
    return record_.device_N = safety_.stop();
}

/// Surfaces to where the meshes are.
void Simulation::place_surfaces() noexcept {
    for (std::size_t m = 0; m < states_.size(); ++m) {
        const HapticMesh& mesh = *model_.meshes[m];
        surfaces_[m]->move(mesh.place_m, mesh.springs.rest(), states_[m].displacement);
    }
}

/// A law, and springs that turn, have other rests than their own: tissue drawn through itself, inside out, stays so. True where nothing has
/// touched a mesh for so long that damping has left e^-5 of any swing, and it still is a tenth of the nodes' distance away.
bool Simulation::come_to_rest_elsewhere() const noexcept {
    for (std::size_t m = 0; m < states_.size(); ++m) {
        const HapticMesh& mesh = *model_.meshes[m];
        if (!mesh.law && mesh.springs.law().linear_in_displacement()) continue;
        const double settled_s = 10 / mesh.damping_1_s + (mesh.law ? 10 * mesh.law->slowest_s() : 0);
        if (untouched_s_ > settled_s && states_[m].displacement.cwiseAbs().maxCoeff() > 0.1 * model_.surface.spacing_m()) return true;
    }
    return false;
}

/// Puts meshes to rest that have flown apart, or came to rest elsewhere; true when it had to. Before and after the steps of every tick, also of those
/// whose input is refused: meshes go on then.
bool Simulation::put_to_rest() noexcept {
    constexpr double apart_m = 1e3;
    bool lost = come_to_rest_elsewhere();
    for (const MeshState& state : states_) lost = lost || !(state.displacement.cwiseAbs().sum() < apart_m);
    if (!lost) return false;
    ++counters_.unstable;
    rest_meshes();
    return true;
}

/// Surfaces to where the meshes are, and false when there is no inside: a surface crosses itself. A contact asks that of the touched mesh alone:
/// the force is that one's, and the mesh beside it, which is only shown, must not end it.
bool Simulation::move_surfaces() noexcept {
    place_surfaces();
    sound_ = true;
    bool lost = false;
    for (std::size_t m = 0; m < surfaces_.size(); ++m) {
        if (surfaces_[m]->simple()) continue;
        sound_ = false;
        if (touched_ >= 0 && static_cast<int>(m) != touched_) continue;
        ++counters_.folded;
        lost = true;
    }
    return !lost;
}

/// The proxy of 4.2 against the mesh in contact, or against each while there is none. Before the master has once been
/// outside there is no contact. False when two meshes lie in one place and both hold the proxy.
bool Simulation::find_contact(const Point& master_m) noexcept {
    if (!armed_) {
        wait_for_outside(master_m);
    } else if (touched_ >= 0) {
        const int left = touched_;
        ContactState from = contact_;
        if (laws_[static_cast<std::size_t>(left)])
            hold_tool(master_m);
        else if (update_contact(*surfaces_[static_cast<std::size_t>(left)], master_m, contact_) == ContactRow::swallowed_release)
            begin_contact(left, master_m);  // at another place of the same surface
        from.contact = false;
        if (!contact_.contact && !sound_) {
            ++counters_.folded;  // whether the other mesh is touched now, nobody can say
            return false;
        }
        if (!contact_.contact) look_for_contact(from, left, master_m);
    } else {
        const ContactState from = contact_;
        look_for_contact(from, -1, master_m);
    }
    if (!contact_.contact) touched_ = -1;
    for (std::size_t m = 0; m < surfaces_.size() && (contact_.contact || !armed_); ++m)
        if (static_cast<int>(m) != touched_ && surfaces_[m]->contains_strictly(contact_.proxy_m, 1e-9)) {
            ++counters_.folded;
            return false;
        }
    return true;
}

/// A contact at a new place: it has its own stiffness, or patch.
void Simulation::begin_contact(int mesh, const Point& master_m) noexcept {
    touched_ = mesh;
    tool_m_ = master_m;
    slid_m_.setZero();
    slide_m_s_.setZero();
    friction_.begin();
    const HapticMesh& pressed = *model_.meshes[static_cast<std::size_t>(mesh)];
    touched_m_ = pressed.springs.rest_place(contact_.where.facet, contact_.where.weight);
    if (model_.is_law()) laws_[0]->contact(contact_.where.facet, contact_.where.weight, tool_);
    for (ToolMemory& memory : tool_memory_) memory.forget();
    if (pressed.law)
        contact_.pressing = tool_pushes(master_m);
    else
        coupling_N_m_ = *model_.options.coupling_ratio * model_.stiffness->at(contact_.where.facet, contact_.where.weight[1]);
}

/// Whether the tool, held where it will be at the time to which the mesh has come, pushes the law's tissue in: its force has a part along the rest's inward normal, whole or
/// without the imprint on single nodes. That swings fast where it is stiff; a contact let go at each swing would be pumped up by them.
bool Simulation::tool_pushes(const Point& master_m) const noexcept {
    const auto m = static_cast<std::size_t>(touched_);
    const Point push = tool_at_the_end(master_m) - model_.meshes[m]->place_m - touched_m_;
    const NodeColumns& u = states_[m].displacement;
    const ToolMemory& memory = tool_memory_[m];
    return tool_.mean_N(push, u, &memory).dot(tool_.inward()) > 0 || tool_.hand_N(push, u, &memory).dot(tool_.inward()) > 0;
}

/// A law's contact keeps its place, and presses while it pushes the tool out. The surface does not say whether:
/// the patch's spline is smoother, and the tool may lie on either side of it. Contact ends when the patch does not push and the
/// tool is out of the surface, or when it is farther out of it than the surface's nodes lie apart, which no patch explains.
void Simulation::hold_tool(const Point& master_m) noexcept {
    const auto m = static_cast<std::size_t>(touched_);
    const MovingSurface& surface = *surfaces_[m];
    contact_.pressing = tool_pushes(master_m);
    if (!surface.contains(master_m) &&
        (!contact_.pressing || surface.nearest(master_m).distance_m > laws_[m]->spacing_m())) {
        contact_.contact = contact_.pressing = false;
        contact_.proxy_m = master_m;
        return;
    }
    contact_.where.position_m = surface.at(contact_.where.facet, contact_.where.weight);
    contact_.where.distance_m = (master_m - contact_.where.position_m).norm();
    contact_.proxy_m = contact_.where.position_m;
}

void Simulation::slide(const Point& master_m) noexcept {
    const auto m = static_cast<std::size_t>(touched_);
    const HapticMesh& mesh = *model_.meshes[m];
    const MovingSurface& now = *surfaces_[m];
    slid_m_ -= mesh.law ? touched_m_ : Point(contact_.where.position_m);
    if (mesh.law) {
        friction_.slide(model_.surface, mesh.springs, *laws_[m], states_[m].displacement, master_m - mesh.place_m, contact_.where, touched_m_, tool_,
                        tool_memory_[m]);
        contact_.where.position_m = now.at(contact_.where.facet, contact_.where.weight);
    } else {
        friction_.slide(model_.surface, mesh.springs, now, coupling_N_m_, master_m, contact_.where);
    }
    slid_m_ += mesh.law ? touched_m_ : Point(contact_.where.position_m);
    contact_.proxy_m = contact_.where.position_m;
    record_.slipping = friction_.slipping();
}

/// A free proxy, on its way from where it was to the master, against every mesh but the one it has just left.
void Simulation::look_for_contact(const ContactState& from, int left, const Point& master_m) noexcept {
    for (std::size_t m = 0; m < surfaces_.size(); ++m) {
        if (static_cast<int>(m) == left) continue;
        contact_ = from;
        update_contact(*surfaces_[m], master_m, contact_);
        if (!contact_.contact) continue;
        return begin_contact(static_cast<int>(m), master_m);
    }
}

void Simulation::no_contact(const Point& proxy_m) noexcept {
    contact_ = {};
    contact_.proxy_m = proxy_m;
}

/// No contact yet: the proxy is the master's, or while that is inside, the nearest place on the surface.
void Simulation::wait_for_outside(const Point& master_m) noexcept {
    no_contact(master_m);
    for (const auto& surface : surfaces_)
        if (surface->contains(master_m)) {
            ++counters_.unarmed;
            contact_.proxy_m = surface->nearest(master_m).position_m;
            return;
        }
    armed_ = true;
    contact_.has_proxy = true;
}

/// 4.3: from where the contact is and how far the learned mesh gave way there, or from the force on it a tick ago.
void Simulation::select_set(const Point& on_tissue_N) noexcept {
    const Cells& facets = model_.meshes[0]->springs.facets();
    const double w = contact_.where.weight[1];
    const int i = facets(contact_.where.facet, 0), j = facets(contact_.where.facet, 1);
    const Eigen::Vector2d displacement = (1 - w) * states_[0].displacement.row(i) + w * states_[0].displacement.row(j);
    const bool by_force = model_.options.select_by == SelectBy::force;
    set_ = model_.selector->select(contact_.where.facet, w, by_force ? Eigen::Vector2d(on_tissue_N) : displacement);
    record_.contact_displacement_m = displacement;
}

Point Simulation::displacement_at_contact(std::size_t mesh) const noexcept {
    if (record_.mesh < 0) return Point::Zero(model_.dimension());
    const HapticMesh& asked = *model_.meshes[mesh];
    const NodeColumns& u = states_[mesh].displacement;
    if (asked.law) return static_cast<int>(mesh) == record_.mesh ? Point(record_.master_m - asked.place_m - touched_m_) : tool_.push_at(-record_.coupling_N, u, &tool_memory_[mesh]);
    const Cells& facets = asked.springs.facets();
    Point sum = Point::Zero(model_.dimension());
    for (Eigen::Index k = 0; k < facets.cols(); ++k) sum += record_.weight[k] * u.row(facets(record_.facet, k)).transpose();
    return sum;
}

/// (19): K^t = gamma K_l + (1 - gamma) K^{t-1}, on theta, in which K is linear. The heuristic mesh has one set.
void Simulation::average_stiffness() noexcept {
    MeshState& learned = states_[0];
    kernel::average(static_cast<int>(learned.theta.size()), *model_.options.innovation, model_.meshes[0]->theta_of_set.col(set_).data(),
                    learned.theta.data());
    learned.theta_changed = true;
}

/// A mesh to the end of the time in which this tick's force is held. A tool that is held goes straight on to where the hand will be then. Returns
/// the mean force of the tool on the tissue over that time; where no step is due, the force as it stands [N].
Point Simulation::advance_mesh(std::size_t m, ContactLoad& load, const Point& master_m) noexcept {
    const HapticMesh& mesh = *model_.meshes[m];
    MeshState& state = states_[m];
    const double h = model_.options.dt_s / mesh.substeps;
    const int steps = steps_due(m);
    if (steps == 0) {
        if (load.velocity_m_s.size() == 0) return load.given_N;
        const Point moved_m = tool_at_the_end(master_m) + (model_.options.dt_s - due_s_[m] - period_s_) * velocity_m_s_ - tool_m_;  // since the last step
        if (load.tool) *load.push_m += moved_m;
        else load.master_m += moved_m;
        load.velocity_m_s -= slide_m_s_;
        held_ = state.displacement + load.ahead_s * state.velocity;
        return load.force_at(mesh.springs, held_);
    }
    if (load.velocity_m_s.size() > 0) {
        load.velocity_m_s = (tool_at_the_end(master_m) - tool_m_) / (steps * h);
        tool_m_ += steps * h * load.velocity_m_s;
        slide_m_s_ = slid_m_ / (steps * h);
        slid_m_.setZero();
        load.velocity_m_s -= slide_m_s_;  // a place that goes along with the tool is neither stretched nor damped by that
    }
    const int of_last = std::clamp(static_cast<int>(std::lround(period_s_ / h)), 1, steps);
    return dynamics_[m]->advance(state, load, h, steps, of_last);
}

/// Every mesh. The touched one goes first: its coupling, or patch, gives the force that the others get as well. Returns that [N].
Point Simulation::step_meshes(const Point& master_m) noexcept {
    const auto touched = static_cast<std::size_t>(std::max(touched_, 0));
    record_.proxy_m = contact_.proxy_m;
    record_.set = model_.is_law() ? -1 : set_;
    if (!contact_.pressing) {
        for (std::size_t m = 0; m < states_.size(); ++m) {
            ContactLoad free;
            const double before_s = due_s_[m];
            advance_mesh(m, free, master_m);
            if (contact_.contact && m == touched) remember_contact(master_m, static_cast<int>(std::lround((before_s - due_s_[m]) * model_.meshes[m]->substeps / model_.options.dt_s)));
        }
        tool_m_ = tool_at_the_end(master_m);
        slid_m_.setZero();
        return Point::Zero(model_.dimension());
    }
    untouched_s_ = 0;
    record_.mesh = touched_;
    record_.facet = contact_.where.facet;
    record_.weight = contact_.where.weight;

    // on springs the ends of the segment, on a law its own contact: held by the hand, then given the force
    ContactLoad load;
    const auto advance = [&](std::size_t m) {
        load.tool = laws_[m] ? &tool_ : nullptr;
        load.memory = tool_memory_[m].empty() ? nullptr : &tool_memory_[m];
        return advance_mesh(m, load, master_m);
    };
    const Point tool = tool_m_ - model_.meshes[touched]->place_m;
    if (!model_.is_solid()) {
        for (int end : {0, 1}) {
            load.node[end] = model_.meshes[touched]->springs.facets()(contact_.where.facet, end);
            load.weight[end] = contact_.where.weight[end];
        }
        load.master_m = tool;
    }
    load.coupling_N_m = coupling_N_m_;
    load.push_m = Point(tool - touched_m_);
    load.velocity_m_s = velocity_m_s_;
    load.ahead_s = model_.meshes[touched]->contact_damping_s;
    const Point force = advance(touched);
    ContactLoad given = load;
    given.coupling_N_m = given.ahead_s = 0;
    given.push_m.reset();
    given.velocity_m_s.resize(0);
    given.given_N = force;
    load = given;
    for (std::size_t m = 0; m < states_.size(); ++m)
        if (m != touched) advance(m);
    return force;
}

/// A law's contact that does not press for a while forgets as time goes by: its gap goes on.
void Simulation::remember_contact(const Point& master_m, int steps) noexcept {
    const auto m = static_cast<std::size_t>(touched_);
    if (tool_memory_[m].empty()) return;
    const HapticMesh& mesh = *model_.meshes[m];
    for (int k = 0; k < steps; ++k) tool_.remember(master_m - mesh.place_m - touched_m_, states_[m].displacement, tool_memory_[m]);
}

/// No force in this tick, whatever slew says, and none until the master has been outside. Meshes go on by themselves.
Eigen::Vector3d Simulation::stop(TickStatus why) noexcept {
    record_.status = why;
    record_.fault = why == TickStatus::refused;
    if (record_.fault) velocity_m_s_.setZero();
    forget_taken_over();
    no_contact(record_.master_m);
    touched_ = -1;
    armed_ = false;
    if (!model_.is_law()) average_stiffness();
    step_meshes(record_.master_m);
    put_to_rest();
    record_.device_N = safety_.stop();
    return record_.device_N;
}

}  // namespace tissue
