#include "haptic/safety.h"

#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

/// Largest surplus that is not damped: a tool that touches between two ticks, or a late tick, leaves some microjoules
/// in E. On tissue of 300 N/m an oscillation of that energy has an amplitude of a quarter of a millimetre.
constexpr double negligible_J = 1e-5;

constexpr double rounding = 1 + 1e-9;

constexpr double farthest_m = 1e3;  ///< no hand is farther away, and up to here no sum of squares overflows

/// Norm of any finite vector. Its squares may overflow; where denormals are zero, so may the reciprocals in Eigen's
/// stableNorm.
double length_of(const Eigen::Vector3d& v) noexcept {
    const double largest = v.cwiseAbs().maxCoeff();
    return largest > 0 ? largest * (v / largest).norm() : 0;
}

/// v, shortened to the length `most` where it is longer.
Eigen::Vector3d within(const Eigen::Vector3d& v, double most) noexcept {
    const double largest = v.cwiseAbs().maxCoeff();
    if (!(length_of(v) > most)) return v;
    const Eigen::Vector3d one = v / largest;
    return one * (most / one.norm());
}

}  // namespace

void HeldForces::add(const Eigen::Vector3d& force_N, double seconds, double cell_s) noexcept {
    if (!(seconds > 0)) return;
    if (cell_[first_].seconds + newest_.seconds > cell_s) {
        first_ = (first_ + most_cells - 1) % most_cells;
        cell_[first_] = {};
    }
    cell_[first_].seconds += newest_.seconds;
    cell_[first_].impulse_Ns += newest_.impulse_Ns;
    newest_ = {seconds, seconds * force_N};
}

Eigen::Vector3d HeldForces::mean_N(double from_s, double to_s) const noexcept {
    if (!(from_s > to_s)) return Eigen::Vector3d::Zero();  // so long ago that a double does not distinguish them
    Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
    double ago_s = 0;
    const auto take = [&](const Cell& cell) {
        const double shared_s = std::min(from_s, ago_s + cell.seconds) - std::max(to_s, ago_s);
        if (shared_s > 0) impulse += shared_s / cell.seconds * cell.impulse_Ns;
        ago_s += cell.seconds;
    };
    take(newest_);
    for (int k = 0; k < most_cells && ago_s < from_s; ++k) take(cell_[(first_ + k) % most_cells]);
    return impulse / (from_s - to_s);
}

double Safety::worst_release_J(double force_N) const noexcept { return o_.speed_max_m_s * force_N * o_.dt_s; }

double Safety::releasable_N(double energy_J) const noexcept { return std::max(0.0, energy_J) / (o_.speed_max_m_s * o_.dt_s); }

/// The device has released its force, at an unknown time and position of the hand: counts the worst case.
void Safety::let_go(double elapsed_s) noexcept {
    const double worst = force_N_.norm() * o_.speed_max_m_s * std::min(elapsed_s, o_.hold_s);
    ++counters_.late;
    counters_.energy_given_J += worst;
    observed_J_ += worst;
    force_N_.setZero();
}

bool Safety::admit(const DeviceSample& sample, double elapsed_s) noexcept {
    elapsed_s_ = std::max(0.0, elapsed_s);
    since_good_s_ += elapsed_s_;
    if (observed_J_ > 0) observed_J_ *= std::exp(-elapsed_s_ / surplus_fades_s);
    if (!force_N_.isZero(0)) {
        const double held_s = std::min(elapsed_s_, o_.hold_s);
        lateness_ = std::max(lateness_, (held_s + std::min(since_good_s_ - elapsed_s_, o_.stale_s)) / o_.dt_s);
        if (elapsed_s_ > o_.hold_s / 2 * rounding) let_go(elapsed_s_);
    }
    held_.add(force_N_, elapsed_s_, 2 * o_.stale_s / HeldForces::most_cells);
    long long* fault = nullptr;
    if (!sample.valid || !(sample.position_m.cwiseAbs().maxCoeff() < farthest_m) || !sample.position_m.allFinite())
        fault = &counters_.bad_input;
    else if (!(sample.age_s <= o_.stale_s))
        fault = &counters_.stale;
    else if (!follow(sample.position_m, std::max(0.0, sample.age_s)))
        fault = &counters_.jump;
    if (!fault) return true;
    ++*fault;
    motion_m_.setZero();
    unknown_way_ = true;
    return false;
}

/// Takes a position that was measured age_s ago. False where the motion to it is a jump.
bool Safety::follow(const Eigen::Vector3d& position_m, double age_s) noexcept {
    const Eigen::Vector3d motion = position_m - position_m_;
    const double between_s = std::max(0.0, since_good_s_ - age_s);
    // else it is the same position again; its age may be measured by a clock that differs a little from ours
    const bool fresh = !has_position_ || between_s > 0.5 * std::min(elapsed_s_, o_.dt_s) || !motion.isZero(0);
    between_s_ = 0;
    if (!fresh) return true;
    const double time = std::max(between_s, o_.dt_s);
    allowed_s_ = std::min(allowed_s_ + between_s, time);
    const double taken_s = motion.norm() / o_.speed_max_m_s;
    const bool jump = has_position_ && !(taken_s <= allowed_s_ * rounding + 1e-9 * o_.dt_s);  // positions are rounded
    if (!jump) allowed_s_ = has_position_ ? std::max(0.0, allowed_s_ - taken_s) : o_.dt_s;
    position_m_ = position_m;
    // one tick between the positions, which may take no time
    const bool one_force = age_s == 0 && since_good_s_ <= elapsed_s_;
    // for two positions at one time, the force at that time
    const double before_s = between_s > 0 ? since_good_s_ : age_s + 1e-9 * o_.dt_s;
    since_good_s_ = std::min(since_good_s_, age_s);  // a position measured before the last one gains no time
    has_motion_ = has_position_ && !jump && !jumped_;
    jumped_ = jump;
    if (jump) return false;
    if (has_position_) {
        between_s_ = std::max(between_s, 1e-3 * o_.dt_s);
        motion_m_ = motion * (o_.dt_s / time);
        const double given = unknown_way_ ? 0 : (one_force ? force_N_ : held_.mean_N(before_s, age_s)).dot(motion);
        counters_.energy_given_J += given;
        observed_J_ += given;
    } else {
        since_good_s_ = age_s;
        motion_m_.setZero();
    }
    unknown_way_ = false;
    has_position_ = true;
    return true;
}

void Safety::go_on_from(const Safety& other) noexcept {
    SafetyOptions limits = other.o_;
    limits.dt_s = o_.dt_s;
    *this = other;
    become(limits);
}

void Safety::become(const SafetyOptions& options) noexcept {
    lateness_ = std::max(1.0, lateness_ * o_.dt_s / options.dt_s);
    // forces held before may exceed what the new bound assumes
    if (options.force_max_N < o_.force_max_N || options.speed_max_m_s < o_.speed_max_m_s) unknown_way_ = true;
    o_ = options;
    force_N_ = within(force_N_, o_.force_max_N);
    observed_J_ = std::min(observed_J_, lateness_ * (bound_J() - worst_release_J(force_N_.norm())));
}

Eigen::Vector3d Safety::limit(const Eigen::Vector3d& wanted_N, bool damp) noexcept {
    Eigen::Vector3d wanted = wanted_N;
    if (!wanted.allFinite()) wanted.setZero();
    const double length = length_of(wanted);
    // an energy model's tool never shows more than force_max
    if (length >= o_.force_max_N * (1 - 1e-5)) ++counters_.clamped;
    if (length > o_.force_max_N) wanted = within(wanted, o_.force_max_N);
    double most = o_.force_max_N;
    if (o_.passivity) {
        // observer: E after this tick if the hand keeps its velocity; controller: the damping that removes just that
        const double surplus = observed_J_ + wanted.dot(motion_m_), motion2 = motion_m_.squaredNorm();
        if (damp && surplus > negligible_J && motion2 > 1e-18) {
            wanted -= std::min(surplus / motion2, o_.damping_max_Ns_m / o_.dt_s) * motion_m_;
            ++counters_.damped;
        }
        if (observed_J_ > 0) most = std::min(most, releasable_N(bound_J() - observed_J_ / lateness_));
        if (most < o_.force_max_N && wanted.norm() > most * (1 + 1e-12)) ++counters_.capped;
    }
    wanted = within(wanted, most);

    // the old force is cut at once to the wanted part along its direction; from there the change is limited by slew.
    // Both ends lie in the ball of radius `most`, so every force between them does
    const double before2 = force_N_.squaredNorm(), kept = before2 > 0 ? std::clamp(wanted.dot(force_N_) / before2, 0.0, 1.0) : 0;
    const Eigen::Vector3d from = kept * force_N_, change = wanted - from;
    const double left = o_.slew_N_s * std::min(elapsed_s_, o_.dt_s);
    if (change.norm() > left) ++counters_.slewed;
    force_N_ = from + within(change, left);

    if (observed_J_ + worst_release_J(force_N_.norm()) <= bound_J()) lateness_ = 1;
    counters_.force_max_N = std::max(counters_.force_max_N, force_N_.norm());
    return force_N_;
}

Eigen::Vector3d Safety::stop() noexcept {
    force_N_.setZero();
    return force_N_;
}

}  // namespace tissue
