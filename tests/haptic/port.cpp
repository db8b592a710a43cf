#include <algorithm>
#include <cmath>
#include <catch2/catch.hpp>

#include "haptic_example.h"

namespace tissue {

bool Port::tick(const DeviceSample& sample, double elapsed_s) {
    const SafetyCounters before = s_.safety().counters();
    const long long no_inside = s_.counters().folded + s_.counters().unstable;
    const Eigen::Vector3d x = sample.position_m, now = s_.tick(sample, elapsed_s);
    const SafetyCounters& after = s_.safety().counters();
    const bool fault = after.bad_input + after.jump + after.stale > before.bad_input + before.jump + before.stale;
    if (given_J_ > 0) given_J_ *= std::exp(-elapsed_s / surplus_fades_s);  // as in the bound of haptic/safety.h
    // Energy at the port, with the force that was held during the hand's motion, or until the device released it.
    if (elapsed_s > o_.safety.hold_s / 2) {
        given_J_ += force_N_.norm() * o_.safety.speed_max_m_s * std::min(elapsed_s, o_.safety.hold_s);
        force_N_.setZero();
    }
    longest_s_ = std::max(longest_s_, std::min(elapsed_s, o_.safety.hold_s));
    if (!fault && known_) given_J_ += force_N_.dot(x - last_m_);
    worst_J_ = std::max(worst_J_, given_J_);
    known_ = true;
    if (after.jump > before.jump || !fault) last_m_ = x;
    const double change = rise_N(force_N_, now);
    force_N_ = now;

    REQUIRE(now.allFinite());
    REQUIRE(now.norm() <= o_.safety.force_max_N * (1 + 1e-12));
    const bool lost = s_.counters().folded + s_.counters().unstable > no_inside;
    if (fault || lost || s_.record().status != TickStatus::done) REQUIRE(now == Eigen::Vector3d::Zero());
    else REQUIRE(change <= o_.safety.slew_N_s * o_.dt_s * (1 + 1e-9));
    faults_ += fault;
    return !fault && !lost;
}

}  // namespace tissue
