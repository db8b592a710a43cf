#include "haptic/learner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "error.h"
#include "haptic/realtime_energy_model.h"

namespace tissue {
namespace {

const RealtimeEnergyModel& energy_model_of(const HapticModel& model) {
    if (!model.is_energy_model()) throw MismatchError("only an energy model can learn in a session; this model has spring sets");
    return *model.meshes.front()->energy_model;
}

EnergyModelStiffness stiffness_of(const EnergyModel& energy_model) { return {energy_model.constants, energy_model.patch, energy_model.contact_log_scale}; }

/// Moves `now` towards `goal` by at most `most`. Returns true when it has reached the goal.
bool step_towards(double& now, double goal, double most) noexcept {
    const double way = goal - now;
    if (std::abs(way) <= most) {
        now = goal;
        return true;
    }
    now += way > 0 ? most : -most;
    return false;
}

}  // namespace

std::unique_ptr<Adaptation> live_adaptation(const std::string& file) {
    std::unique_ptr<Adaptation> adaptation = read_adaptation(file, {});
    const Adaptation::State& state = adaptation->state();
    adaptation->in_session(std::max({live_bound, state.x.lpNorm<Eigen::Infinity>(), std::abs(state.scale)}), live_place_error_m);
    return adaptation;
}

HapticOptions live_options(HapticOptions options, const Adaptation& adaptation) {
    options.stiffest = std::exp(adaptation.largest());
    options.heuristic_mesh = false;
    return options;
}

Learner::Learner(const HapticModel& model, Adaptation& adaptation, const LearnerOptions& options)
    : model_(model), adaptation_(adaptation), options_(options), now_(energy_model_of(model).stiffness()), readings_to_learn_(64),
      learned_({now_, 0}) {
    if (!all_default(model.options.tool)) throw MismatchError("a model learns only with its own disc, not with another tool");
    const EnergyModel energy_model = adaptation.energy_model();
    if (energy_model.constants.size() != now_.constants.size() || energy_model.patch.log_N_m.rows() != now_.patch.log_N_m.rows())
        throw MismatchError("the adaptation belongs to a model other than the session's");
    if (adaptation.largest() > std::log(model.options.stiffest) + 1e-12)
        throw MismatchError(fmt::format("the adaptation permits a stiffness factor of {:g}, and the session's time steps are stable up to {:g}", std::exp(adaptation.largest()), model.options.stiffest));
    relaxes_ = !energy_model.relaxation.empty();
    const Point nothing = Point::Zero(model.dimension());
    held_m_ = sum_measured_N_ = sum_model_N_ = sum_push_m_ = nothing;
    publish();
    thread_ = std::thread([this] { learn(); });
}

Learner::~Learner() { stop(); }

/// Passes the adapted energy model to the tick.
void Learner::publish() {
    learned_.back() = {stiffness_of(adaptation_.energy_model()), adaptation_.state().learned};
    learned_.publish();
}

void Learner::stop() {
    stop_.store(true);
    if (thread_.joinable()) thread_.join();
}

bool Learner::before(Simulation& simulation) {
    if (learned_.fetch() || std::exchange(restores_, simulation.restores()) != simulation.restores()) arrived_ = false;
    moves_ = !arrived_;
    if (arrived_) return true;
    RealtimeEnergyModel& energy_model = *simulation.energy_model();
    const EnergyModelStiffness& goal = learned_.front().stiffness;
    now_ = energy_model.stiffness();
    arrived_ = true;
    for (Eigen::Index c = 0; c < now_.constants.size(); ++c) arrived_ &= step_towards(now_.constants[c], goal.constants[c], options_.step * now_.constants[c]);
    for (Eigen::Index n = 0; n < now_.contact_log_scale.size(); ++n) arrived_ &= step_towards(now_.contact_log_scale[n], goal.contact_log_scale[n], options_.step);
    auto patch = now_.patch.log_N_m.reshaped();
    const auto patch_goal = goal.patch.log_N_m.reshaped();
    for (Eigen::Index i = 0; i < patch.size(); ++i) arrived_ &= step_towards(patch[i], patch_goal[i], options_.step);
    energy_model.become(now_);
    simulation.energy_model_changed();
    return true;
}

void Learner::begin_hold() {
    held_s_ = summed_s_ = 0;
    sum_measured_N_.setZero();
    sum_model_N_.setZero();
    sum_push_m_.setZero();
}

void Learner::after(const Simulation& simulation, const TickStatistics& books) {
    const TickRecord& tick = simulation.record();
    const bool feels = tick.mesh == 0 && !tick.fault() && !tick.slipping && !simulation.held_back() && tick.measured_N.allFinite() && !books.left_out;
    const bool same = feels && tick.facet == facet_ && tick.weight == weight_ && (tick.contact_displacement_m - held_m_).norm() < options_.still_m;
    if (!same) {
        facet_ = feels ? tick.facet : -1;
        weight_ = tick.weight;
        held_m_ = tick.contact_displacement_m;
        taken_ = false;
        begin_hold();
        return;
    }
    if (taken_) return;
    if (relaxes_ && moves_) {  // its force belongs to no single set of parameters
        begin_hold();
        return;
    }
    constexpr double rounding = 1 - 1e-9;
    const double advanced_s = simulation.advanced_s();
    held_s_ += advanced_s;
    if (held_s_ > options_.hold_s / 2) {
        sum_measured_N_ += advanced_s * tick.measured_N;
        sum_model_N_ -= advanced_s * tick.coupling_N;
        sum_push_m_ += advanced_s * tick.contact_displacement_m;
        summed_s_ += advanced_s;
    }
    if (held_s_ < options_.hold_s * rounding) return;
    taken_ = true;
    const double n = summed_s_;
    const Reading reading{books.time_s, model_.meshes.front()->springs.rest_place(facet_, weight_), sum_push_m_ / n, sum_measured_N_ / n, sum_model_N_ / n, learned_.front().learned};
    ++readings_;
    if (readings_to_learn_.push(reading)) ++pushed_;
    else ++dropped_;
    while (!books.clock && done_.load() < pushed_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void Learner::learn() noexcept {
    using std::chrono::steady_clock;
    std::optional<steady_clock::time_point> give_up;
    for (;;) {
        const bool last = stop_.load();
        Reading reading;
        bool any = false;
        while (readings_to_learn_.pop(reading)) {
            any = true;
            if (stop_.load() && !give_up) give_up = steady_clock::now() + std::chrono::microseconds(static_cast<long long>(1e6 * options_.patience_s));
            if (ended_ || (give_up && steady_clock::now() >= *give_up))
                ++dropped_;
            else
                try_to_learn_from(reading);
            ++done_;
        }
        if (last) return;
        if (!any) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

/// Catches everything: an exception that leaves a thread ends the program with the force on. The message is stored
/// without an allocation, since memory may have run out.
void Learner::try_to_learn_from(const Reading& reading) noexcept {
    const char* why = "an unknown exception was thrown";
    try {
        return learn_from(reading);
    } catch (const std::exception& e) {
        std::snprintf(failure_.data(), failure_.size(), "%s", *e.what() ? e.what() : why);
    } catch (...) {
        std::snprintf(failure_.data(), failure_.size(), "%s", why);
    }
    ended_ = true;
    if (failed_) failed_(failure(), with_);
}

void Learner::learn_from(const Reading& reading) {
    ForceMeasurement poke{reading.contact_m, reading.push_m, reading.measured_N};
    const auto drop = [this] { ++dropped_; };
    if (relaxes_ && reading.learned != adaptation_.state().learned) return drop();
    if (relaxes_) try {
            const Expected now = adaptation_.expect(poke.contact_m, poke.push_m);
            if (now.status != SolverStatus::converged || !(reading.model_N.norm() > 0)) return drop();
            poke.force_N *= now.force_N.norm() / reading.model_N.norm();
        } catch (const MismatchError&) {  // contact on fixed nodes: Adaptation::learn() refuses it
        }
    Adaptation::State before = adaptation_.state();
    UpdateResult answer;
    try {
        answer = adaptation_.learn(poke);
        if (answer.status == UpdateStatus::learned) publish();
    } catch (...) {
        adaptation_.restore(std::move(before));
        throw;
    }
    if (tell_) tell_({reading.time_s, poke, answer}, adaptation_, with_);
}

}  // namespace tissue
