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

constexpr double swings_out_s = 0.5;  ///< a tool that touches again so soon meets what its last contact has left in motion, and belongs to it
constexpr double carried_s = 0.1;    ///< a force of a session that was taken over fades with this time constant
constexpr int most_periods = 16;  ///< that a mesh goes through in one tick, to make up for late ones

}  // namespace

Simulation::Simulation(const HapticModel& model)
    : model_(model), options_(model.options), safety_(model.options.safety), due_s_(model.meshes.size(), 0.0), spare_s_(due_s_), period_s_(model.options.dt_s), friction_(model.options.friction) {
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
    Point push_m[2];  // before the contact becomes another
    for (std::size_t m = 0; m < tool_memory_.size(); ++m)
        if (!tool_memory_[m].empty())
            push_m[m] = static_cast<int>(m) == touched_ ? push_of(record_.master_m, m)
                                                        : tool_.push_at(-record_.coupling_N, states_[m].displacement, &tool_memory_[m]);
    changed_ = tool_;
    laws_[0]->contact(contact_.where.facet, contact_.where.weight, changed_.growth(), tool_);
    for (std::size_t m = 0; m < tool_memory_.size(); ++m)
        if (push_m[m].size() > 0) tool_.take_over(changed_, push_m[m], states_[m].displacement, tool_memory_[m]);
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
    disarm(Point::Zero(model_.dimension()));
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

/// Time that is owed is made up for while a tick costs less than half of the time that it goes through. Where it costs more, in two ticks one after the other (one alone was interrupted), a tick
/// that goes through all that is owed makes the next one late, which then owes more. Such a tick goes through the usual time between ticks and a tenth more: a host that keeps up loses none while its periods stray by less than that.
/// Where it would cost more than 0.9 of that time, it goes through less, so that it costs 0.9. The usual time follows a shorter one at once and a longer one slowly: a stall changes nothing,
/// and ticks that were long become short again. What is owed beyond that is lost. A tick always goes through dt.
void Simulation::keep_ticks_short(double since_s, double cost_s) noexcept {
    constexpr double half = 0.45, most = 0.9, growth = 1.02, strays = 1.1;
    if (went_s_ > 0) cost_[0] = std::exchange(cost_[1], std::max(0.0, cost_s) / went_s_);
    usual_s_ = usual_s_ > 0 ? std::min(since_s, growth * usual_s_) : since_s;
    const double least = cost_s > 0 ? std::min(cost_[0], cost_[1]) : 0;
    longest_s_ = least > half ? std::max(model_.options.dt_s, std::min(strays, most / least) * usual_s_) : std::numeric_limits<double>::infinity();
    went_s_ = 0;
}

/// The tissue has to come to the end of the time in which this tick's force is held, which will be as long as the ticks before were. One tick that comes much later than dt was
/// stalled, and does not count; after two in a row the host is slow.
void Simulation::time_passes(double seconds) noexcept {
    constexpr double longest_debt_s = 0.5;
    const double longest_period_s = std::max(longest_dt_s, 4 * model_.options.dt_s) * (1 + 1e-9);  // a clock's differences are rounded
    record_.time_s += seconds;
    since_[0] = std::exchange(since_[1], seconds);
    if (seconds <= longest_period_s || steady_s() > longest_period_s)
        period_s_ += std::max(0.02, 1 / static_cast<double>(counters_.ticks)) * (std::min(seconds, slowest_period_s) - period_s_);
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
    const double dt_s = model_.options.dt_s, h = dt_s / mesh.substeps;
    const bool too_dear = longest_s_ < usual_s_;  // steps are rounded down then
    const double longest_s = too_dear ? h * std::floor(longest_s_ / h * (1 + 1e-9)) : longest_s_ + spare_s_[m];
    const double most_s = std::max({most_periods * dt_s, 2 * period_s_, steady_s()});  // or a slow host would never catch up
    double left_s = due_s_[m] - dt_s + period_s_;
    if (const double lost_s = left_s - longest_s; lost_s > 1e-6 * h) {
        due_s_[m] -= lost_s;
        left_s = longest_s;
        if (m == 0) {
            counters_.lost_s += lost_s;
            untouched_s_ = std::max(0.0, untouched_s_ - lost_s);
        }
    }
    const int steps = std::max(0, static_cast<int>(std::lround(std::min(left_s, most_s) / h)));
    spare_s_[m] = too_dear ? 0 : std::min(longest_s - steps * h, h / 2);
    due_s_[m] -= steps * h;
    went_s_ = std::max(went_s_, steps * h);
    return steps;
}

Eigen::Vector3d Simulation::tick(const DeviceSample& sample, double elapsed_s, double cost_s) noexcept {
    const FlushDenormals mode;
    const double lost_s = counters_.lost_s;
    const Eigen::Vector3d force = advance(sample, elapsed_s, cost_s);
    record_.overrun = counters_.lost_s > lost_s;
    return force;
}

/// How fast the master is. A hand faster than speed-max is none, nor is one whose way since its last position nobody knows.
void Simulation::follow_hand(const Point& moved_m, double age_s) noexcept {
    const HapticOptions& o = options_;
    const double most = o.safety.speed_max_m_s * o.map.scale, between_s = safety_.between_s();
    if (!safety_.has_motion()) {
        velocity_m_s_.setZero();
        expected_s_ = same_position_s_ = old_s_ = 0;
    } else if (between_s > 0) {
        velocity_m_s_ += std::min(1.0, between_s / o.dt_s) * (moved_m / between_s - velocity_m_s_);
        expected_s_ = std::min(between_s, o.safety.stale_s);
        same_position_s_ = 0;
        old_s_ = std::clamp(age_s, 0.0, o.dt_s);
    }
    const double speed = velocity_m_s_.norm();
    if (!std::isfinite(speed))
        velocity_m_s_.setZero();
    else if (speed > most)
        velocity_m_s_ *= most / speed;
}

/// How far the tool at this place has pushed a law's tissue [m].
Point Simulation::push_of(const Point& tool_m, std::size_t mesh) const noexcept { return tool_m - model_.meshes[mesh]->place_m - touched_m_; }

/// A law's tissue gets no more force than the device can show: else it would store, and later give to the hand, what the hand never felt. Not where springs are touched, whose coupling has no such limit.
void Simulation::show_no_more() noexcept {
    tool_.show_at_most(touched_ >= 0 && laws_[static_cast<std::size_t>(touched_)] ? options_.safety.force_max_N / options_.map.force_scale : std::numeric_limits<double>::infinity());
}

/// Where the hand will be at the end of the time in which this tick's force is held. Where its positions come less often than ticks it goes on meanwhile, but
/// not for longer than from one to the next. Of how old a position was when it came, dt at most: farther ahead the noise of a speed is larger than what it tells.
Point Simulation::tool_at_the_end(const Point& master_m) const noexcept {
    return master_m + (period_s_ + old_s_ + std::min(same_position_s_, expected_s_)) * velocity_m_s_;
}

/// In the mode of tick(): out of line, so that nothing of it is computed before or after.
__attribute__((noinline)) Eigen::Vector3d Simulation::advance(const DeviceSample& sample, double elapsed_s, double cost_s) noexcept {
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
    keep_ticks_short(since_s, cost_s);
    same_position_s_ += since_s;
    record_.device_m = sample.position_m.allFinite() ? sample.position_m : last.device_m;
    record_.master_m = last.master_m;

    const bool lost = put_to_rest();

    // device position
    if (!safety_.admit(sample, since_s + std::exchange(stood_s_, 0.0))) return stop(TickStatus::refused);
    if (clutched_ && has_master_) options_.map.offset_m += last.master_m - o.map.to_tissue(sample.position_m);
    const Point master = o.map.to_tissue(sample.position_m);
    record_.master_m = master;
    device_m_ = sample.position_m;
    has_master_ = true;
    follow_hand(master - last.master_m, sample.age_s);

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

Eigen::Vector3d Simulation::stand_still(const DeviceSample& sample, double passed_s) noexcept {
    const FlushDenormals mode;
    if (sample.reset) reset();
    if (safety_.force_N().isZero(0))
        stood_s_ += passed_s;
    else if (!safety_.admit(sample, passed_s))
        disarm(record_.master_m);
    else
        safety_.begin_way();  // or the next tick would take the way of both periods for its own
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
    tool_.grow({});
    lay_tool(push_of(tool_at_the_end(master_m), static_cast<std::size_t>(mesh)));
    show_no_more();
    for (ToolMemory& memory : tool_memory_) memory.forget();
    if (pressed.law)
        contact_.pressing = tool_pushes(master_m);
    else
        coupling_N_m_ = *model_.options.coupling_ratio * model_.stiffness->at(contact_.where.facet, contact_.where.weight[1]);
}

/// The law's contact where the tool is, at that push.
void Simulation::lay_tool(const Point& push_m) noexcept {
    if (model_.is_law()) laws_[0]->contact(contact_.where.facet, contact_.where.weight, push_m, states_[static_cast<std::size_t>(touched_)].displacement, tool_);
}

/// Whether the tool, held where it will be at the time to which the mesh has come, pushes the law's tissue in: its force has a part along the rest's inward normal, whole or
/// without the imprint on single nodes. That swings fast where it is stiff; a contact let go at each swing would be pumped up by them.
bool Simulation::tool_pushes(const Point& master_m) const noexcept {
    const auto m = static_cast<std::size_t>(touched_);
    const Point push = push_of(tool_at_the_end(master_m), m);
    const NodeColumns& u = states_[m].displacement;
    const ToolMemory& memory = tool_memory_[m];
    return tool_.mean_N(push, u, &memory).dot(tool_.inward()) > 0 || tool_.hand_N(push, u, &memory).dot(tool_.inward()) > tool_.growth().force_N;
}

/// A law's contact keeps its place, and presses while it pushes the tool out. The surface does not say whether:
/// the patch's spline is smoother, and the tool may lie on either side of it. Contact ends when the patch does not push and the
/// tool is out of the surface, or when it is farther out of it than the surface's nodes lie apart, which no patch explains.
void Simulation::hold_tool(const Point& master_m) noexcept {
    const auto m = static_cast<std::size_t>(touched_);
    const MovingSurface& surface = *surfaces_[m];
    if (laws_[0]->contact_grows()) lay_tool(tool_.shown_push(push_of(tool_at_the_end(master_m), m), states_[m].displacement));
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
        friction_.slide(model_.surface, mesh.springs, *laws_[0], states_[m].displacement, master_m - mesh.place_m, contact_.where, touched_m_, tool_,
                        tool_memory_[m], tool_memory_.size() > 1 ? &tool_memory_[1 - m] : nullptr);
        contact_.where.position_m = now.at(contact_.where.facet, contact_.where.weight);
    } else {
        friction_.slide(model_.surface, mesh.springs, now, coupling_N_m_, master_m, contact_.where);
        if (friction_.slipping()) lay_tool(push_of(tool_m_, m));  // the law's mesh beside gets the force there
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

/// No contact, and none before the tool has been outside.
void Simulation::disarm(const Point& proxy_m) noexcept {
    forget_taken_over();
    no_contact(proxy_m);
    record_.mesh = touched_ = -1;
    armed_ = false;
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
    if (asked.law && static_cast<int>(mesh) == record_.mesh) return tool_.shown_push(push_of(record_.master_m, mesh), u, tool_memory_[mesh].empty() ? nullptr : &tool_memory_[mesh]);
    if (asked.law) return tool_.push_at(-record_.coupling_N, u, &tool_memory_[mesh]);
    const Cells& facets = asked.springs.facets();
    Point sum = Point::Zero(model_.dimension());
    for (Eigen::Index k = 0; k < facets.cols(); ++k) sum += record_.weight[k] * u.row(facets(record_.facet, k)).transpose();
    return sum;
}

void Simulation::seen(std::size_t mesh, NodeColumns& displacement_m) const noexcept {
    displacement_m = states_[mesh].displacement;
    if (laws_[mesh] && record_.mesh >= 0)
        laws_[mesh]->show_skin(record_.facet, {record_.weight[0], record_.weight[1], record_.weight[2]}, displacement_at_contact(mesh), displacement_m);
}

/// (19): K^t = gamma K_l + (1 - gamma) K^{t-1} of each dt that has passed, on theta, in which K is linear. The heuristic mesh has one set.
void Simulation::average_stiffness() noexcept {
    MeshState& learned = states_[0];
    const double gamma = *model_.options.innovation, periods = since_[1] / model_.options.dt_s;
    kernel::average(static_cast<int>(learned.theta.size()), periods == 1 ? gamma : 1 - std::pow(1 - gamma, periods), model_.meshes[0]->theta_of_set.col(set_).data(),
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
    load.push_m = push_of(tool_m_, touched);
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
    for (int k = 0; k < steps; ++k) tool_.remember(push_of(master_m, m), states_[m].displacement, tool_memory_[m]);
}

/// No force in this tick, whatever slew says, and none until the master has been outside. Meshes go on by themselves.
Eigen::Vector3d Simulation::stop(TickStatus why) noexcept {
    record_.status = why;
    record_.fault = why == TickStatus::refused;
    if (record_.fault) velocity_m_s_.setZero();
    disarm(record_.master_m);
    if (!model_.is_law()) average_stiffness();
    step_meshes(record_.master_m);
    put_to_rest();
    record_.device_N = safety_.stop();
    return record_.device_N;
}

}  // namespace tissue
