#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "haptic/safety.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Limits that only the one under test reaches.
SafetyOptions wide() {
    SafetyOptions o;
    o.force_max_N = 1000;
    o.slew_N_s = 1e9;
    o.passivity = false;
    return o;
}

}  // namespace

TEST_CASE("no force above the limit goes out, and its direction stays", "[safety]") {
    SafetyOptions o = wide();
    o.force_max_N = 3.3;
    Safety safety(o);
    safety.admit(sample_at(0, 0), 1e-3);
    CHECK(safety.limit({1, 2, 0}) == Eigen::Vector3d(1, 2, 0));
    const Eigen::Vector3d f = safety.limit({30, -40, 0});
    CHECK((f - 3.3 * Eigen::Vector3d(0.6, -0.8, 0)).norm() < 1e-12);
    CHECK(safety.counters().clamped == 1);
    CHECK(safety.counters().force_max_N == Approx(3.3));
}

TEST_CASE("a force that is not finite becomes none", "[safety]") {
    Safety safety(wide());
    safety.admit(sample_at(0, 0), 1e-3);
    for (double bad : {not_a_number, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()})
        CHECK(safety.limit({0, bad, 1}) == Eigen::Vector3d::Zero());
}

TEST_CASE("force changes by at most slew a tick, but stops at once", "[safety]") {
    SafetyOptions o = wide();
    o.slew_N_s = 500;
    Safety safety(o);
    safety.admit(sample_at(0, 0), 1e-3);
    CHECK(safety.limit({2, 0, 0}).x() == Approx(0.5));
    CHECK(safety.limit({2, 0, 0}).x() == Approx(1.0));
    CHECK(safety.counters().slewed == 2);
    CHECK(safety.stop() == Eigen::Vector3d::Zero());
    CHECK(safety.limit({2, 0, 0}).x() == Approx(0.5));
}

TEST_CASE("each fault is refused and counted by its kind", "[safety]") {
    Safety safety(wide());
    CHECK(safety.admit(sample_at(0.5, 0), 1e-3));  // the first may be anywhere
    CHECK(safety.admit(sample_at(0.5 + 1.9e-3, 0), 1e-3));
    CHECK_FALSE(safety.admit(sample_at(0.51, 0), 1e-3));
    CHECK(safety.counters().jump == 1);
    CHECK(safety.admit(sample_at(0.51, 0), 1e-3));  // from where it is now
    CHECK_FALSE(safety.admit(sample_at(not_a_number, 0), 1e-3));
    DeviceSample invalid = sample_at(0.51, 0);
    invalid.valid = false;
    CHECK_FALSE(safety.admit(invalid, 1e-3));
    CHECK(safety.counters().bad_input == 2);
    DeviceSample old = sample_at(0.51, 0);
    old.age_s = 0.06;
    CHECK_FALSE(safety.admit(old, 1e-3));
    old.age_s = not_a_number;
    CHECK_FALSE(safety.admit(old, 1e-3));
    CHECK(safety.counters().stale == 2);
    CHECK(safety.admit(sample_at(0.52, 0), 1e-3 * 2));  // 7 ticks since the last good one: 14 mm are possible
    CHECK(safety.counters().jump == 1);
}

TEST_CASE("the port's energy is force times motion, tick by tick", "[safety]") {
    Safety safety(wide());
    safety.admit(sample_at(0, 0), 1e-3);
    safety.limit({2, 0, 0});
    safety.admit(sample_at(1e-3, 0), 1e-3);
    CHECK(safety.counters().energy_given_J == Approx(2e-3));
    safety.limit({0, 3, 0});
    safety.admit(sample_at(1e-3, -1e-3), 1e-3);
    CHECK(safety.counters().energy_given_J == Approx(2e-3 - 3e-3));
}

TEST_CASE("a spring that hardens on the way out gives back no more than it took", "[safety]") {
    // a virtual wall of 200 N/m going in and 500 N/m coming out would give 150 J/m^2 x depth^2 a cycle
    for (bool passivity : {false, true}) {
        SafetyOptions o;
        o.passivity = passivity;
        o.damping_max_Ns_m = 100;
        Safety safety(o);
        double before = 0;
        for (int k = 0; k < 20000; ++k) {
            const double depth = 0.004 * (1 - std::cos(2 * 3.14159265358979 * 2e-3 * k)) / 2;
            REQUIRE(safety.admit(sample_at(-depth, 0), 1e-3));
            safety.limit({(depth > before ? 200 : 500) * depth, 0, 0});
            if (depth < 1e-5) safety.forget_credit();
            before = depth;
        }
        if (passivity)
            CHECK(safety.counters().energy_given_J < 0.01 * 0.0024);  // a hundredth of one cycle's surplus, after 40
        else
            CHECK(safety.counters().energy_given_J > 20 * 0.0024);
    }
}

TEST_CASE("energy out is at most energy in plus one tick's worst, whatever is wanted and however the hand moves", "[safety][adversarial]") {
    for (double damping : {0.0, 3.0, 50.0}) {
        SafetyOptions o;
        o.damping_max_Ns_m = damping;
        Safety safety(o);
        Draw draw(7);
        Eigen::Vector3d x(0, 0, 0), force(0, 0, 0), wanted(0, 0, 0);
        double given = 0, worst = 0;
        const long long ticks = adversarial_ticks(300000);
        for (long long k = 0; k < ticks; ++k) {
            // the worst hand there is goes with the force as fast as it may; others wander
            Eigen::Vector3d step(draw(-1, 1), draw(-1, 1), draw(-1, 1));
            if (draw.below(3) > 0 && force.norm() > 0) step = force;
            const Eigen::Vector3d before = x;
            x += step.normalized() * (draw.below(2) ? 2e-3 : draw(0, 2e-3)) * (1 - 1e-12);
            if (k > 0) given += force.dot(x - before);
            worst = std::max(worst, given);
            DeviceSample sample;
            sample.position_m = x;
            REQUIRE(safety.admit(sample, 1e-3));
            if (draw.below(50) == 0) wanted = 20 * Eigen::Vector3d(draw(-1, 1), draw(-1, 1), draw(-1, 1));
            force = safety.limit(wanted);
            REQUIRE(force.allFinite());
            REQUIRE(force.norm() <= o.force_max_N * (1 + 1e-12));
            if (draw.below(1000) == 0) safety.forget_credit();
        }
        CHECK(worst <= safety.bound_J() * (1 + 1e-9));
        CHECK(worst > 0);
        CHECK(safety.counters().energy_given_J == Approx(given).margin(1e-9));
    }
}
