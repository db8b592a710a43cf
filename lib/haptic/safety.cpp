#include "haptic/safety.h"

#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

/// Not worth a damping: a press of the weakest tissue here stores ten thousand times as much.
constexpr double negligible_J = 1e-9;

}  // namespace

bool Safety::admit(const DeviceSample& sample, double elapsed_s) noexcept {
    motion_m_.setZero();
    since_good_s_ += elapsed_s;
    if (!sample.valid || !sample.position_m.allFinite()) {
        ++counters_.bad_input;
        return false;
    }
    if (!(sample.age_s <= o_.stale_s)) {
        ++counters_.stale;
        return false;
    }
    const Eigen::Vector3d motion = sample.position_m - position_m_;
    const double farthest = o_.speed_max_m_s * std::max(since_good_s_, o_.dt_s) * (1 + 1e-9);
    const bool jump = has_position_ && !(motion.norm() <= farthest);
    position_m_ = sample.position_m;
    since_good_s_ = 0;
    if (jump) {
        ++counters_.jump;
        return false;
    }
    if (has_position_) motion_m_ = motion;
    has_position_ = true;
    const double given = force_N_.dot(motion_m_);
    counters_.energy_given_J += given;
    observed_J_ += given;
    return true;
}

Eigen::Vector3d Safety::limit(const Eigen::Vector3d& wanted_N) noexcept {
    Eigen::Vector3d force = wanted_N;
    if (!force.allFinite()) force.setZero();

    const Eigen::Vector3d change = force - force_N_;
    const double step = o_.slew_N_s * o_.dt_s;
    if (change.norm() > step) {
        force = force_N_ + change * (step / change.norm());
        ++counters_.slewed;
    }
    if (force.norm() > o_.force_max_N) {
        force *= o_.force_max_N / force.norm();
        ++counters_.clamped;
    }
    if (o_.passivity) {
        // observer: what will have been given if the hand goes on as it did; controller: damp just that away
        const double surplus = observed_J_ + force.dot(motion_m_), motion2 = motion_m_.squaredNorm();
        if (surplus > negligible_J && motion2 > 1e-18) {
            force -= std::min(surplus / motion2, o_.damping_max_Ns_m / o_.dt_s) * motion_m_;
            ++counters_.damped;
        }
        const double cap = o_.force_max_N - std::max(0.0, observed_J_) / (o_.speed_max_m_s * o_.dt_s);
        if (force.norm() > cap) force *= std::max(0.0, cap) / force.norm();
    } else if (force.norm() > o_.force_max_N) {
        force *= o_.force_max_N / force.norm();
    }
    if (!force.allFinite()) force.setZero();
    counters_.force_max_N = std::max(counters_.force_max_N, force.norm());
    return force_N_ = force;
}

Eigen::Vector3d Safety::stop() noexcept {
    force_N_.setZero();
    return force_N_;
}

}  // namespace tissue
