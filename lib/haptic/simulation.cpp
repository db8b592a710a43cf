#include "haptic/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "flush_denormals.h"
#include "hot_loop.h"

namespace tissue {
namespace kernel {

/// (19): theta = (1 - gamma) theta + gamma theta_set.
TISSUE_HOT void average(int n, double gamma, const double* __restrict set, double* __restrict theta) {
    for (int k = 0; k < n; ++k) theta[k] = (1 - gamma) * theta[k] + gamma * set[k];
}

}  // namespace kernel

namespace {

/// A tool that touches again within this time meets tissue that still moves from its last contact, and belongs to that
/// contact's energy.
constexpr double swings_out_s = 0.5;
constexpr double carried_s = 0.1;    ///< time constant with which the force of a session that was taken over fades
constexpr int most_periods = 16;  ///< largest number of dt that a mesh advances in one tick, to make up for late ticks

}  // namespace

Simulation::Simulation(const HapticModel& model) : model_(model), due_s_(model.meshes.size(), 0.0), spare_s_(due_s_), period_s_(model.options.dt_s) {
    std::vector<ToolMemory> tool_memory;
    for (const auto& mesh : model.meshes) {
        energy_models_.push_back(mesh->energy_model ? std::make_unique<RealtimeEnergyModel>(*mesh->energy_model) : nullptr);
        states_.emplace_back(mesh->springs, mesh->theta_of_set.col(0));
        surfaces_.push_back(make_moving_surface(model.rest));
        dynamics_.push_back(make_dynamics(mesh->dynamics, mesh->springs,
                                          {model.options.dt_s / mesh->substeps, mesh->damping_1_s, energy_models_.back().get()}));
        tool_memory.emplace_back();
        if (!mesh->energy_model) continue;
        const double step_s = model.options.dt_s / mesh->substeps;
        states_.back().memory = mesh->energy_model->memory(step_s);
        if (model.options.energy_book) states_.back().memory.book();
        tool_memory.back() = mesh->energy_model->tool_memory(step_s);
    }
    tools_.assign(static_cast<std::size_t>(model.options.tools), ToolState(model.options, model.dimension(), tool_memory));
    for (int k = 0; k < model.options.tools; ++k)
        if (!model.grasps(k)) of(k).options.grasp_max_N = std::numeric_limits<double>::infinity();
    held_ = states_.front().displacement;
    place_surfaces();
}

void Simulation::energy_model_changed() noexcept {
    if (!model_.is_energy_model()) return;
    for (ToolState& t : tools_) {
        if (t.touched < 0) continue;
        Point push_m[2];  // tool displacement on each mesh, before the contact changes
        for (std::size_t m = 0; m < t.memory.size(); ++m)
            if (!t.memory[m].empty())
                push_m[m] = static_cast<int>(m) == t.touched ? push_of(t, t.record.master_m, m)
                                                             : t.spring.push_at(-t.record.coupling_N, states_[m].displacement, &t.memory[m]);
        t.changed = t.spring;
        contacts_of(t).at(t.contact.where.facet, t.contact.where.weight, t.changed.growth(), t.spring);
        for (std::size_t m = 0; m < t.memory.size(); ++m)
            if (push_m[m].size() > 0) t.spring.take_over(t.changed, push_m[m], states_[m].displacement, t.memory[m]);
    }
}

void Simulation::reset() noexcept {
    rest_meshes();
    reset_ = true;
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
    for (ToolState& t : tools_) {
        t.disarm(Point::Zero(model_.dimension()));
        t.untouched_s = 0;
    }
    rested_s_ = record().time_s;
}

/// Time since the last tick. An elapsed_s that is no duration means that it is unknown: then as long as the device
/// holds a force.
static double since_last_s(double elapsed_s, const HapticOptions& o) noexcept {
    constexpr double longest_s = 3600;
    if (elapsed_s == 0) return o.dt_s;
    if (elapsed_s > 0 && std::isfinite(elapsed_s)) return std::min(elapsed_s, longest_s);
    return std::isfinite(o.safety.hold_s) ? std::min(o.safety.hold_s, longest_s) : force_held_s;
}

/// Limits the time by which meshes advance in this tick (longest_s_). Time that is owed from late ticks is made up for
/// while a tick costs less than 0.45 of the time by which it advances.
///
/// If two ticks in a row cost more (a single one may have been interrupted), a tick that makes up for all owed time
/// would delay the next one, which would owe more. Then a tick advances by 1.1 times the usual time between ticks at
/// most. A host that keeps up loses no time while its periods vary by less than that. If this would cost more than 0.9
/// of the usual time, the tick advances by less, so that it costs 0.9 of it. Time owed beyond the limit is lost. A tick
/// always advances by dt.
///
/// The usual time follows a shorter time at once and a longer one slowly. So a stall does not change it, and ticks that
/// were long become short again. A single tick after less than half of it does not change it either.
void Simulation::keep_ticks_short(double since_s, double cost_s) noexcept {
    constexpr double half = 0.45, most = 0.9, growth = 1.02, strays = 1.1;
    if (advanced_s_ > 0) cost_[0] = std::exchange(cost_[1], std::max(0.0, cost_s) / advanced_s_);
    const bool early = since_s < usual_s_ / 2 && since_[0] >= usual_s_ / 2;  // a single early tick, as after a stall
    if (!early) usual_s_ = usual_s_ > 0 ? std::min(since_s, growth * usual_s_) : since_s;
    const double least = cost_s > 0 ? std::min(cost_[0], cost_[1]) : 0;
    longest_s_ = least > half ? std::max(model_.options.dt_s, std::min(strays, most / least) * usual_s_) : std::numeric_limits<double>::infinity();
    advanced_s_ = 0;
}

/// Adds the time since the last tick to what meshes owe. They have to reach the end of the time for which this tick's
/// force is held. That time is predicted as the mean time between ticks, period_s_. One tick that comes much later than
/// dt was stalled and does not count in the mean; after two in a row the host is slow.
void Simulation::time_passes(double seconds) noexcept {
    constexpr double longest_debt_s = 0.5;
    // a clock's differences are rounded
    const double longest_period_s = std::max(longest_dt_s, 4 * model_.options.dt_s) * (1 + 1e-9);
    since_[0] = std::exchange(since_[1], seconds);
    if (seconds <= longest_period_s || steady_s() > longest_period_s)
        period_s_ += std::max(0.02, 1 / static_cast<double>(counters_.ticks)) * (std::min(seconds, slowest_period_s) - period_s_);
    for (double& due_s : due_s_) {
        due_s += seconds;
        if (due_s <= longest_debt_s) continue;
        if (&due_s == &due_s_.front()) counters_.lost_s += due_s - longest_debt_s;
        due_s = longest_debt_s;
    }
    pass_untouched(std::min(seconds, longest_debt_s));  // of a stall only the time that meshes go through
}

/// Time since any tool or its force was on the meshes.
double Simulation::untouched_s() const noexcept {
    double least_s = tools_.front().untouched_s;
    for (const ToolState& t : tools_) least_s = std::min(least_s, t.untouched_s);
    return least_s;
}

void Simulation::pass_untouched(double seconds) noexcept {
    for (ToolState& t : tools_) t.untouched_s = std::max(0.0, t.untouched_s + seconds);
}

int Simulation::steps_due(std::size_t m) noexcept {
    const HapticMesh& mesh = *model_.meshes[m];
    const double dt_s = model_.options.dt_s, h = dt_s / mesh.substeps;
    const bool too_dear = longest_s_ < usual_s_;  // then steps are rounded down
    const double longest_s = too_dear ? h * std::floor(longest_s_ / h * (1 + 1e-9)) : longest_s_ + spare_s_[m];
    // else a slow host would never catch up
    const double most_s = std::max({most_periods * dt_s, 2 * period_s_, steady_s()});
    double left_s = due_s_[m] - dt_s + period_s_;
    if (const double lost_s = left_s - longest_s; lost_s > 1e-6 * h) {
        due_s_[m] -= lost_s;
        left_s = longest_s;
        lost_s_ = std::max(lost_s_, lost_s);
    }
    const int steps = std::max(0, static_cast<int>(std::lround(std::min(left_s, most_s) / h)));
    spare_s_[m] = too_dear ? 0 : std::min(longest_s - steps * h, h / 2);
    due_s_[m] -= steps * h;
    advanced_s_ = std::max(advanced_s_, steps * h);
    return steps;
}

namespace {

/// Samples of all tools for a caller that has one tool's sample: those of other tools are invalid.
struct OneSample {
    explicit OneSample(const DeviceSample& sample) {
        samples[0] = sample;
        for (DeviceSample* other = samples + 1; other != samples + most_tools; ++other) other->valid = false;
    }
    DeviceSample samples[most_tools];
    Eigen::Vector3d force_N[most_tools];
};

}  // namespace

Eigen::Vector3d Simulation::tick(const DeviceSample& sample, double elapsed_s, double cost_s) noexcept {
    OneSample one(sample);
    tick(one.samples, one.force_N, elapsed_s, cost_s);
    return one.force_N[0];
}

void Simulation::tick(const DeviceSample* samples, Eigen::Vector3d* force_N, double elapsed_s, double cost_s) noexcept {
    const FlushDenormals mode;
    const double lost_s = counters_.lost_s;
    advance(samples, force_N, elapsed_s, cost_s);
    for (ToolState& t : tools_) t.record.overrun = counters_.lost_s > lost_s;
}

/// Starts the tick's record of a tool, before anything has happened.
void Simulation::begin_record(ToolState& t, const DeviceSample& sample, double since_s) noexcept {
    const TickRecord last = t.record;
    t.record = {};
    t.record.reset = reset_;
    t.record.proxy_m = t.record.contact_displacement_m = t.record.coupling_N = Point::Zero(model_.dimension());
    t.record.measured_N = t.options.map.force_to_tissue(sample.measured_N);
    t.record.time_s = last.time_s + since_s;
    t.record.device_m = sample.position_m.allFinite() ? sample.position_m : last.device_m;
    t.record.master_m = last.master_m;
    t.same_position_s += since_s;
}

/// Begins a grasp where the contact has a force of its own.
void Simulation::begin_grasp(ToolState& t) noexcept {
    if (!t.contact.pressing || !on_energy_model(t) || !model_.grasps(index_of(t))) return;
    t.grasps = true;
    t.friction.begin();
}

/// Moves the master to the device's position, if safety admits it.
void Simulation::move_hand(ToolState& t, const DeviceSample& sample, double since_s) noexcept {
    const long long late = t.safety.counters().late;
    const bool admitted = t.safety.admit(sample, since_s + std::exchange(t.stood_s, 0.0));
    t.record.late = t.safety.counters().late > late;
    if (t.record.late) t.grasps = false;
    if (!admitted) {
        t.record.status = TickStatus::refused;
        return;
    }
    DeviceMap& map = t.options.map;
    const Point last_m = t.record.master_m;
    if (t.clutched && t.has_master) map.offset_m += last_m - map.to_tissue(sample.position_m);
    t.record.master_m = map.to_tissue(sample.position_m);
    t.device_m = sample.position_m;
    t.has_master = true;
    t.follow_hand(t.record.master_m - last_m, sample.age_s);
}

/// Runs in the floating-point mode of tick(). Not inlined, so that nothing of it is computed before or after that mode.
__attribute__((noinline)) void Simulation::advance(const DeviceSample* samples, Eigen::Vector3d* force_N, double elapsed_s, double cost_s) noexcept {
    if (std::any_of(samples, samples + tools_.size(), [](const DeviceSample& sample) { return sample.reset; })) reset();
    ++counters_.ticks;
    begun_ = true;
    const double since_s = since_last_s(elapsed_s, options());
    if (elapsed_s > since_s && std::isfinite(elapsed_s)) counters_.lost_s += elapsed_s - since_s;
    time_passes(since_s);
    keep_ticks_short(since_s, cost_s);
    const Point last_N = record().coupling_N;
    bool goes_on[most_tools];  // the grasp, which was not asked for in the tick before
    for (std::size_t k = 0; k < tools_.size(); ++k) {
        ToolState& t = tools_[k];
        const bool was_on = t.record.grasp;
        begin_record(t, samples[k], since_s);
        t.record.grasp = samples[k].grasp || t.grasp_asked;
        goes_on[k] = t.record.grasp && !was_on;
        if (!t.record.grasp) t.grasps = false;
    }
    reset_ = false;

    const bool lost = put_to_rest();

    // device positions
    for (std::size_t k = 0; k < tools_.size(); ++k) {
        move_hand(tools_[k], samples[k], since_s);
        if (lost && tools_[k].record.status == TickStatus::done) tools_[k].record.status = TickStatus::diverged;
    }

    // 4.2 collision detection
    if (std::any_of(tools_.begin(), tools_.end(), [](const ToolState& t) { return t.record.status == TickStatus::done; })) move_surfaces();
    bool folded = false;
    for (std::size_t k = 0; k < tools_.size(); ++k) {
        ToolState& t = tools_[k];
        if (t.record.status == TickStatus::done && !find_contact(t)) {
            t.record.status = TickStatus::folded;
            folded = true;
        }
        if (t.record.status != TickStatus::done) {
            stop(t);
            continue;
        }
        if (!t.armed) t.record.status = TickStatus::not_armed;
        if (goes_on[k]) begin_grasp(t);
    }
    if (folded) ++counters_.folded;

    // 4.3 selection of mesh constants, and their moving average (18)-(19)
    if (!model_.is_energy_model()) {
        if (tools_[0].contact.pressing) select_set(tools_[0], -last_N);
        average_stiffness();
    }

    // 4.1 deformation of every mesh (4.4), with the coupling force of 4.2 on the segment's end nodes
    step_meshes();
    if (put_to_rest())
        for (ToolState& t : tools_) {
            if (t.record.status != TickStatus::refused) t.record.status = TickStatus::diverged;
            stop(t);
        }

    for (ToolState& t : tools_) {
        t.record.grasped = t.grasps;
        // above the device's limit the force on the tissue grows no more
        const bool too_much = std::isfinite(t.options.grasp_max_N) && held_back(index_of(t));
        if (!t.grasps || !(too_much || t.record.coupling_N.norm() > t.options.grasp_max_N)) continue;
        t.grasps = false;
        ++t.let_go;
    }

    // safety, device force
    for (std::size_t k = 0; k < tools_.size(); ++k) force_N[k] = force_out(tools_[k], since_s);
}

/// Ends the contact in this tick. There is no force, at once and without the limit of slew, until the master has been
/// outside.
void Simulation::stop(ToolState& t) noexcept {
    if (t.record.fault()) t.velocity_m_s.setZero();
    t.record.coupling_N.setZero();
    t.record.contact_displacement_m.setZero();
    t.record.facet = -1;
    t.record.weight.setZero();
    t.record.slipping = false;
    t.disarm(t.record.master_m);
    t.record.proxy_m = t.contact.proxy_m;
}

/// Force for the device of a tool, from the tool's force on the tissue in this tick.
Eigen::Vector3d Simulation::force_out(ToolState& t, double since_s) noexcept {
    const TickStatus status = t.record.status;
    if (status != TickStatus::done && status != TickStatus::not_armed) return t.record.device_N = t.safety.stop();
    if (model_.is_energy_model()) t.record.contact_displacement_m = displacement_at_contact(0, index_of(t));
    if (t.untouched_s > swings_out_s && t.safety.force_N().isZero(0)) t.safety.forget_credit();
    if (!t.armed) return t.record.device_N = t.safety.stop();
    Eigen::Vector3d wanted = t.options.map.force_to_device(t.record.coupling_N);
    if (std::exchange(t.taken_over, false)) {
        if (!t.record.slipping) t.carried = 0;
        t.carried_N = t.carried > 0 ? t.safety.force_N() : Eigen::Vector3d(t.safety.force_N() - wanted);
    }
    if (!t.contact.contact) {
        t.carried = 0;
        t.carried_N.setZero();
    }
    const double fades = std::exp(-since_s / carried_s);
    // the contact slips to the present position of the hand, which makes the tissue oscillate: its force is blended in
    // slowly
    if (t.carried > 0) {
        wanted += t.carried * (t.carried_N - wanted);
        t.carried *= fades;
    } else {
        wanted += t.carried_N;
        t.carried_N *= fades;
    }
    if (t.clutched) wanted.setZero();
    return t.record.device_N = t.safety.limit(wanted, !t.clutched);
}

Eigen::Vector3d Simulation::skip_tick(const DeviceSample& sample, double passed_s) noexcept {
    OneSample one(sample);
    skip_tick(one.samples, one.force_N, passed_s);
    return one.force_N[0];
}

void Simulation::skip_tick(const DeviceSample* samples, Eigen::Vector3d* force_N, double passed_s) noexcept {
    const FlushDenormals mode;
    if (std::any_of(samples, samples + tool_count(), [](const DeviceSample& s) { return s.reset; })) reset();
    for (int k = 0; k < tool_count(); ++k) {
        ToolState& t = of(k);
        constexpr double moved_m = 1e-3;
        if (!(samples[k].grasp || t.grasp_asked)) t.grasps = t.record.grasp = false;
        if (!((samples[k].position_m - t.record.device_m).norm() < moved_m)) t.grasps = false;
        if (t.safety.force_N().isZero(0))
            t.stood_s += passed_s;
        else if (!t.safety.admit(samples[k], passed_s))
            t.disarm(t.record.master_m);
        else
            t.safety.begin_way();  // else the next tick would take the motion of both periods for its own
        force_N[k] = t.record.device_N = t.safety.stop();
    }
}

/// Moves surfaces to the positions of the meshes.
void Simulation::place_surfaces() noexcept {
    for (std::size_t m = 0; m < states_.size(); ++m) {
        const HapticMesh& mesh = *model_.meshes[m];
        surfaces_[m]->move(mesh.place_m, mesh.springs.rest(), states_[m].displacement);
    }
}

/// Time in which damping leaves e^-5 of any oscillation of an untouched mesh, and relaxation e^-10 of any displacement.
double Simulation::settled_s(const HapticMesh& mesh) noexcept { return 10 / mesh.damping_1_s + (mesh.energy_model ? 10 * mesh.energy_model->slowest_s() : 0); }

/// Energy models and springs that turn have equilibria other than rest: tissue that was drawn through itself stays
/// inverted. True where nothing has touched a mesh for so long that damping has left e^-5 of any oscillation, and a
/// displacement is still above a tenth of the nodes' spacing.
bool Simulation::come_to_rest_elsewhere() const noexcept {
    const double untouched_s = this->untouched_s();
    for (std::size_t m = 0; m < states_.size(); ++m) {
        const HapticMesh& mesh = *model_.meshes[m];
        if (!mesh.energy_model && mesh.springs.law().linear_in_displacement()) continue;
        if (untouched_s > settled_s(mesh) && states_[m].displacement.cwiseAbs().maxCoeff() > 0.1 * model_.surface.spacing_m()) return true;
    }
    return false;
}

/// Puts all meshes to rest where one has diverged or has settled in another equilibrium; returns true then. Called
/// before and after the steps of every tick. That includes ticks whose input is refused, since meshes advance in them
/// too.
bool Simulation::put_to_rest() noexcept {
    constexpr double apart_m = 1e3;
    bool lost = come_to_rest_elsewhere();
    for (const MeshState& state : states_) {
        const auto size = state.displacement.cwiseAbs();
        // the sum bounds the largest, and takes a quarter of its time
        lost = lost || (!(size.sum() < apart_m) && !(size.maxCoeff<Eigen::PropagateNaN>() < apart_m));
    }
    if (!lost) return false;
    ++counters_.unstable;
    rest_meshes();
    return true;
}

/// 4.3: selects the set by the place of the contact and the learned mesh's displacement there, or the force on it a
/// tick ago.
void Simulation::select_set(ToolState& t, const Point& on_tissue_N) noexcept {
    const Cells& facets = model_.meshes[0]->springs.facets();
    const double w = t.contact.where.weight[1];
    const int i = facets(t.contact.where.facet, 0), j = facets(t.contact.where.facet, 1);
    const Eigen::Vector2d displacement = (1 - w) * states_[0].displacement.row(i) + w * states_[0].displacement.row(j);
    const bool by_force = model_.options.select_by == SelectBy::force;
    set_ = model_.selector->select(t.contact.where.facet, w, by_force ? Eigen::Vector2d(on_tissue_N) : displacement);
    t.record.contact_displacement_m = displacement;
}

/// (19): K^t = gamma K_l + (1 - gamma) K^{t-1} for each dt that has passed, applied to theta, in which K is linear. The
/// heuristic mesh has one set.
void Simulation::average_stiffness() noexcept {
    MeshState& learned = states_[0];
    const double gamma = *model_.options.innovation, periods = since_[1] / model_.options.dt_s;
    kernel::average(static_cast<int>(learned.theta.size()), periods == 1 ? gamma : 1 - std::pow(1 - gamma, periods), model_.meshes[0]->theta_of_set.col(set_).data(),
                    learned.theta.data());
    learned.theta_changed = true;
}

}  // namespace tissue
