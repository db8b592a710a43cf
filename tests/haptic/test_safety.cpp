#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "flush_denormals.h"
#include "haptic/safety.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Limits so wide that only the one under test acts.
SafetyOptions wide() {
    SafetyOptions o;
    o.force_max_N = 1000;
    o.slew_N_s = 1e9;
    o.passivity = false;
    return o;
}

/// B of haptic/safety.h: energy that the fastest hand takes from the largest force before the next tick, ticks on time
/// [J].
double energy_bound(const SafetyOptions& o) {
    return o.force_max_N * o.speed_max_m_s * o.dt_s;
}

}  // namespace

TEST_CASE("a force above the limit is reduced to it in the same direction", "[safety]") {
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

TEST_CASE("a position repeated under clock jitter does not count as a new measurement", "[safety]") {
    Safety safety(wide());
    Draw draw(7);
    int fresh = 0;
    for (int k = 0; k < 1000; ++k) {
        const int measured = k / 10 * 10;
        DeviceSample sample = sample_at(1e-5 * measured, 0);
        sample.age_s = 1e-3 * (k - measured) + (k > measured ? draw(-2e-4, 2e-4) : 0);
        safety.admit(sample, 1e-3);
        fresh += safety.between_s() > 0;
    }
    CHECK(fresh == 99);
    // A hand at rest that is measured in every tick.
    for (const double elapsed_s : {1e-3, 1.25e-4}) {
        Safety still(wide());
        fresh = 0;
        for (int k = 0; k < 100; ++k) {
            still.admit(sample_at(0, 0), elapsed_s);
            fresh += still.between_s() > 0;
        }
        CHECK(fresh == 99);
    }
}

TEST_CASE("a force that is not finite becomes zero", "[safety]") {
    Safety safety(wide());
    safety.admit(sample_at(0, 0), 1e-3);
    for (double bad : {not_a_number, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()})
        CHECK(safety.limit({0, bad, 1}) == Eigen::Vector3d::Zero());
}

TEST_CASE("a force whose squares and reciprocals overflow is limited like any other", "[safety]") {
    for (const double huge : {1e155, 4.6e307, 1.7e308}) {
        SafetyOptions o = wide();
        o.force_max_N = 3;
        Safety safety(o);
        const FlushDenormals mode;
        safety.admit(sample_at(0, 0), 1e-3);
        CHECK((safety.limit({huge, 0, -huge}) - 3 * Eigen::Vector3d(1, 0, -1).normalized()).norm() < 1e-12);
    }
}

TEST_CASE("implausible positions are refused and the displacement to a position that jumped is not used as motion", "[safety]") {
    Safety safety(wide());
    for (const double far : {1.1e3, 1e200, -1.7e308}) CHECK_FALSE(safety.admit(sample_at(0, far), 1e-3));
    CHECK(safety.counters().bad_input == 3);
    CHECK(safety.admit(sample_at(0, 0), 1e-3));
    CHECK_FALSE(safety.has_motion());
    CHECK(safety.admit(sample_at(1e-3, 0), 1e-3));
    CHECK(safety.has_motion());
    CHECK_FALSE(safety.admit(sample_at(0.5, 0), 1e-3));
    CHECK(safety.admit(sample_at(0.501, 0), 1e-3));
    CHECK_FALSE(safety.has_motion());
    CHECK(safety.admit(sample_at(0.502, 0), 1e-3));
    CHECK(safety.has_motion());
}

TEST_CASE("a force rises by at most slew per tick and stops at once", "[safety]") {
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

TEST_CASE("each kind of fault is refused and counted by itself", "[safety]") {
    Safety safety(wide());
    CHECK(safety.admit(sample_at(0.5, 0), 1e-3));  // the first position may be anywhere
    CHECK(safety.admit(sample_at(0.5 + 1.9e-3, 0), 1e-3));
    CHECK_FALSE(safety.admit(sample_at(0.51, 0), 1e-3));
    CHECK(safety.counters().jump == 1);
    CHECK(safety.admit(sample_at(0.51, 0), 1e-3));  // relative to the position that jumped
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
    CHECK(safety.admit(sample_at(0.52, 0), 1e-3 * 2));  // 6 periods since the last good position: 12 mm are possible
    CHECK(safety.counters().jump == 1);
}

TEST_CASE("the energy at the port is force times motion of each tick", "[safety]") {
    Safety safety(wide());
    safety.admit(sample_at(0, 0), 1e-3);
    safety.limit({2, 0, 0});
    safety.admit(sample_at(1e-3, 0), 1e-3);
    CHECK(safety.counters().energy_given_J == Approx(2e-3));
    safety.limit({0, 3, 0});
    safety.admit(sample_at(1e-3, -1e-3), 1e-3);
    CHECK(safety.counters().energy_given_J == Approx(2e-3 - 3e-3));
}

TEST_CASE("a wall that is stiffer on the way out gives no net energy with the passivity controller", "[safety]") {
    // A virtual wall of 200 N/m inwards and 500 N/m outwards would give 150 J/m^2 x depth^2 per cycle.
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
            // a hundredth of one cycle's surplus, after 40 cycles
            CHECK(safety.counters().energy_given_J < 0.01 * 0.0024);
        else
            CHECK(safety.counters().energy_given_J > 20 * 0.0024);
    }
}

TEST_CASE("the force rises by at most slew per tick at any hand speed and falls to zero at once", "[safety]") {
    for (double speed : {1.0, 2.0}) {
        SafetyOptions o;
        o.slew_N_s = 300;
        Safety safety(o);
        double x = 0, most = 0, largest = 0;
        Eigen::Vector3d before = Eigen::Vector3d::Zero();
        for (int k = 0; k < 100; ++k) {
            if (k >= 20) x += speed * 1e-3;  // the hand rests until the force is full, then moves along it
            REQUIRE(safety.admit(sample_at(x, 0), 1e-3));
            const Eigen::Vector3d now = safety.limit({3, 0, 0});
            most = std::max(most, rise_N(before, now));
            largest = std::max(largest, now.norm());
            before = now;
        }
        CHECK(largest == Approx(3));
        CHECK(most == Approx(o.slew_N_s * 1e-3));
        CHECK(safety.counters().damped > 0);
        safety.admit(sample_at(x, 0), 1e-3);
        CHECK(safety.limit({0, 0, 0}).isZero(0));
    }
}

TEST_CASE("the force falls to zero within the energy bound while the fastest hand moves along it", "[safety]") {
    SafetyOptions o;
    o.damping_max_Ns_m = 0;  // the energy bound alone
    Safety safety(o);
    double x = 0, given = 0;
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    for (int k = 0; k < 2000; ++k) {
        if (k >= 20) x += 2e-3 * (1 - 1e-12);
        REQUIRE(safety.admit(sample_at(x, 0), 1e-3));
        if (k >= 20) given += force.x() * 2e-3;
        force = safety.limit({20, 0, 0});
        REQUIRE(force.x() >= 0);
        if (k == 19) REQUIRE(force.x() == Approx(3.3));
    }
    CHECK(given <= energy_bound(o) * (1 + 2 / surplus_fades_s));
    CHECK(given > 0.8 * energy_bound(o));  // close to the bound
    CHECK(force.norm() < 0.01);            // only the energy that fades is given again
}

TEST_CASE("the force is limited to what the energy bound leaves until the surplus has faded and these ticks are counted", "[safety]") {
    SafetyOptions o;
    o.damping_max_Ns_m = 0;
    Safety safety(o);
    const auto tick = [&](double x) {
        REQUIRE(safety.admit(sample_at(x, 0), o.dt_s));
        return safety.limit({3, 0, 0}).x();
    };
    CHECK(tick(0) == 3);
    CHECK(safety.counters().capped == 0);
    CHECK(tick(1e-3) == Approx((energy_bound(o) - 3e-3) / (o.speed_max_m_s * o.dt_s)));  // 3 mJ given of 6.6: 1.8 N
    CHECK(safety.counters().capped == 1);
    // For the rest of the contact the hand is at rest, and the surplus fades with surplus_fades_s.
    const double until_s = surplus_fades_s * std::log(3e-3 / (energy_bound(o) - 3 * o.speed_max_m_s * o.dt_s));
    const auto ticks = static_cast<int>(until_s / o.dt_s);
    double before = 0;
    for (int k = 0; k < ticks; ++k) {
        const double now = tick(1e-3);
        REQUIRE((now > before && now < 3));
        before = now;
    }
    CHECK(safety.counters().capped == ticks + 1);
    for (int k = 0; k < 1000; ++k) tick(1e-3);
    CHECK(tick(1e-3) == 3);
    CHECK(safety.counters().capped <= ticks + 3);
    CHECK(safety.counters().clamped == 0);
}

TEST_CASE("a tick of five periods gives at most five times the energy bound until the hand has returned the surplus", "[safety]") {
    SafetyOptions o;
    Safety safety(o);
    double x = 0;
    for (int k = 0; k < 20; ++k) {
        REQUIRE(safety.admit(sample_at(x, 0), 1e-3));
        safety.limit({3.3, 0, 0});
    }
    REQUIRE(safety.force_N().x() == Approx(3.3));
    x += 1.9 * 5e-3;  // the longest period that is not late
    REQUIRE(safety.admit(sample_at(x, 0), 5e-3));
    CHECK(safety.counters().energy_given_J == Approx(3.3 * 1.9 * 5e-3));
    CHECK(safety.counters().energy_given_J <= safety.lateness() * safety.bound_J());
    CHECK(safety.lateness() == Approx(5));
    for (int k = 0; k < 250; ++k) {  // out with the force, damped; then in against it
        x += k < 50 ? 0.2e-3 : -0.5e-3;
        safety.limit({3.3, 0, 0});
        REQUIRE(safety.admit(sample_at(x, 0), 1e-3));
        REQUIRE(safety.observed_J() <= safety.lateness() * safety.bound_J());
    }
    CHECK(safety.observed_J() < 0);
    CHECK(safety.lateness() == 1);
}

TEST_CASE("after a released force the worst case is counted and the force rises from zero by slew", "[safety]") {
    SafetyOptions o;
    o.slew_N_s = 300;
    Safety safety(o);
    for (int k = 0; k < 20; ++k) {
        REQUIRE(safety.admit(sample_at(0, 0), 1e-3));
        safety.limit({3.3, 0, 0});
    }
    REQUIRE(safety.admit(sample_at(0, 0), 1));  // a second, in which the motion of the hand is unknown
    CHECK(safety.counters().late == 1);
    CHECK(safety.counters().energy_given_J == Approx(3.3 * o.speed_max_m_s * force_held_s));
    CHECK(safety.limit({3.3, 0, 0}).isZero(0));  // the worst case is the whole bound
    for (int k = 0; k < 2000; ++k) {
        const double before = safety.force_N().x();
        REQUIRE(safety.admit(sample_at(0, 0), 1e-3));
        CHECK(safety.limit({3.3, 0, 0}).x() <= before + o.slew_N_s * o.dt_s * (1 + 1e-12));
    }
    CHECK(safety.force_N().x() > 0.5);  // the force returns as the surplus fades
}

TEST_CASE("early ticks do not raise the rate of change of the force", "[safety]") {
    SafetyOptions o;
    Safety safety(o);
    safety.admit(sample_at(0, 0), 1e-3);
    for (int k = 1; k <= 20; ++k) {  // twenty ticks in one period
        safety.admit(sample_at(0, 0), 5e-5);
        CHECK(safety.limit({3, 0, 0}).x() <= o.slew_N_s * 5e-5 * k * (1 + 1e-9));
    }
}

TEST_CASE("energy and force and its change keep their bounds for any wanted force and hand motion and tick time", "[safety][adversarial]") {
    constexpr double for_ever = std::numeric_limits<double>::infinity();
    struct Kind { double damping_Ns_m, hold_s; };
    for (const auto& [damping, hold_s] : {Kind{0, force_held_s}, Kind{3, force_held_s}, Kind{50, force_held_s}, Kind{3, 0.05}, Kind{0, for_ever}, Kind{3, for_ever}})
        for (bool on_time : {true, false}) {
            INFO("damping " << damping << ", hold " << hold_s << (on_time ? ", on time" : ""));
            SafetyOptions o;
            o.damping_max_Ns_m = damping;
            o.hold_s = hold_s;
            if (damping == 3) o.slew_N_s = 300;  // in the other cases slew allows any force in one tick
            Safety safety(o);
            Draw draw(7);
            Pace pace(8);
            Eigen::Vector3d x(0, 0, 0), force(0, 0, 0), wanted(0, 0, 0);
            // left_s: time for which the fastest hand may move
            double given = 0, total = 0, worst = 0, longest = o.dt_s, left_s = o.dt_s;
            const long long ticks = adversarial_ticks(300000) / 2;
            for (long long k = 0; k < ticks; ++k) {
                const double elapsed = on_time ? o.dt_s : pace.next(o.dt_s);
                if (k > 0) left_s = std::min(left_s + elapsed, std::max(elapsed, o.dt_s));
                const double reach = o.speed_max_m_s * left_s;
                // The worst hand moves along the force as fast as it may; others move randomly.
                Eigen::Vector3d step(draw(-1, 1), draw(-1, 1), draw(-1, 1));
                if (draw.below(3) > 0 && force.norm() > 0) step = force;
                const Eigen::Vector3d before = x;
                x += step.normalized() * (draw.below(2) ? reach : draw(0, reach)) * (1 - 1e-9);
                if (k > 0) left_s = std::max(0.0, left_s - (x - before).norm() / o.speed_max_m_s);
                bool let_go = false;
                if (given > 0) given *= std::exp(-elapsed / surplus_fades_s);  // as in the bound of haptic/safety.h
                const double before_J = given;
                if (elapsed > hold_s / 2) {
                    // The device releases the force some time after half of hold_s. The hand moves along it until then,
                    // and returns.
                    let_go = true;
                    given += force.norm() * o.speed_max_m_s * std::min(elapsed, draw(0.5, 1) * hold_s);
                    longest = std::max(longest, std::min(elapsed, hold_s));
                } else {
                    if (k > 0) given += force.dot(x - before);
                    longest = std::max(longest, elapsed);
                }
                total += given - before_J;
                worst = std::max(worst, given);
                DeviceSample sample;
                sample.position_m = x;
                REQUIRE(safety.admit(sample, elapsed));
                // The inequality of haptic/safety.h, with the true energy.
                REQUIRE(given <= safety.observed_J() + 1e-9);
                REQUIRE(safety.observed_J() <= safety.lateness() * energy_bound(o) * (1 + 1e-9));
                REQUIRE(safety.lateness() <= longest / o.dt_s * (1 + 1e-12));
                if (draw.below(50) == 0) wanted = 20 * Eigen::Vector3d(draw(-1, 1), draw(-1, 1), draw(-1, 1));
                const Eigen::Vector3d held = let_go ? Eigen::Vector3d::Zero().eval() : force;
                force = safety.limit(wanted);
                REQUIRE(force.allFinite());
                REQUIRE(force.norm() <= o.force_max_N * (1 + 1e-12));
                REQUIRE(rise_N(held, force) <= o.slew_N_s * o.dt_s * (1 + 1e-9));
                if (draw.below(1000) == 0) safety.forget_credit();
            }
            CHECK(worst <= longest / o.dt_s * energy_bound(o) * (1 + 1e-9));
            CHECK(worst > 0);
            if (on_time) CHECK(safety.counters().energy_given_J == Approx(total).margin(1e-9));
        }
}

TEST_CASE("energy keeps its bound when positions come less often than ticks", "[safety][adversarial]") {
    SafetyOptions o;
    Safety safety(o);
    Draw draw(9);
    Eigen::Vector3d x(0, 0, 0), step = x, force = x, wanted = x;
    double given = 0, worst = 0;
    int left = 0, between = 1;
    DeviceSample sample;
    REQUIRE(safety.admit(sample, o.dt_s));
    for (long long k = 0; k < adversarial_ticks(300000); ++k) {
        // The hand moves straight until the next position, as fast as it may, mostly along the present force.
        if (left == 0) {
            left = between = 1 + draw.below(20);
            Eigen::Vector3d way(draw(-1, 1), draw(-1, 1), draw(-1, 1));
            if (draw.below(4) > 0 && force.norm() > 0) way = force;
            step = way.normalized() * o.speed_max_m_s * o.dt_s * (1 - 1e-9);
        }
        x += step;
        if (given > 0) given *= std::exp(-o.dt_s / surplus_fades_s);
        given += force.dot(step);
        worst = std::max(worst, given);
        sample.age_s += o.dt_s;
        if (--left == 0) sample.position_m = x, sample.age_s = 0;
        REQUIRE(safety.admit(sample, o.dt_s));
        // fading between positions differs slightly
        if (left == 0) REQUIRE(given <= safety.observed_J() + 1e-3 * energy_bound(o));
        REQUIRE(safety.observed_J() <= safety.lateness() * energy_bound(o) * (1 + 1e-9));
        REQUIRE(safety.lateness() <= 21);
        if (draw.below(50) == 0) wanted = 20 * Eigen::Vector3d(draw(-1, 1), draw(-1, 1), draw(-1, 1));
        force = safety.limit(wanted);
        REQUIRE(force.norm() <= o.force_max_N * (1 + 1e-12));
    }
    CHECK(worst <= 21 * energy_bound(o));
    CHECK(worst > energy_bound(o));
}

TEST_CASE("faster ticks allow no faster hand and unused motion may be made up for within dt", "[safety]") {
    Safety safety(wide());
    const double speed_m_s = safety.options().speed_max_m_s, dt_s = safety.options().dt_s;
    DeviceSample sample;
    REQUIRE(safety.admit(sample, dt_s));
    const auto goes = [&](double share, int ticks) {  // share: of the fastest hand's motion, eight ticks a period
        int good = 0;
        for (int k = 0; k < ticks; ++k) {
            sample.position_m.x() += share * speed_m_s * dt_s / 8;
            good += safety.admit(sample, dt_s / 8);
        }
        return good;
    };
    CHECK(goes(0.99, 80) == 80);
    CHECK(goes(1.5, 80) < 60);
    CHECK(goes(8, 80) < 20);
    CHECK(goes(0, 80) == 80);  // after ten periods at rest it may move as far as in one period
    CHECK(goes(7.9, 1) == 1);
    CHECK(goes(7.9, 1) == 0);
}

TEST_CASE("positions with an overstated age allow no faster hand", "[safety]") {
    Safety safety(wide());
    DeviceSample sample;
    REQUIRE(safety.admit(sample, 1e-3));
    double far_m = 0;
    for (int k = 1; k <= 2000; ++k) {
        sample.age_s = k % 2 ? 0.05 : 0;
        sample.position_m.x() = far_m + 0.01;
        if (safety.admit(sample, 1e-3)) far_m = sample.position_m.x();
        else sample.position_m.x() = far_m, safety.admit(sample, 0);
    }
    CHECK(far_m < 2.0 * 2000 * 1e-3 + 0.2);
}
