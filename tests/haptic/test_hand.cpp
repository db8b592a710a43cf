#include <catch2/catch.hpp>

#include "../refusal.h"
#include "error.h"
#include "hand.h"
#include "haptic_example.h"
#include "mesh/free_surface.h"
#include "springs/law_press.h"

using Catch::Contains;

namespace tissue {
namespace {

using namespace test;

HapticOptions alone(double force_scale = 1) {
    HapticOptions options;
    options.heuristic_mesh = false;
    options.map.force_scale = force_scale;
    return options;
}

/// A hand that goes where it is led, smoothly: into the top, waits, a little deeper, waits.
Eigen::Vector3d led(double time_s) {
    const auto smooth = [&](double from, double seconds) {
        const double s = std::clamp((time_s - from) / seconds, 0.0, 1.0);
        return s * s * s * (10 - 15 * s + 6 * s * s);
    };
    return {0.052, 0.102 - 0.009 * smooth(0.05, 0.3) - 0.002 * smooth(0.5, 0.2), 0};
}

/// The force that is held from each hundredth of a second to the next: mean over it [N] (100).
std::vector<double> held_force(const HapticModel& model, double rate_Hz, double jitter_s = 0, double stall_at_s = 10, double stall_s = 0) {
    Simulation s(model);
    Draw draw(2008);
    std::vector<double> sum(100, 0.0);
    double time = 0, offset = 0;
    DeviceSample sample;
    sample.position_m = led(0);
    s.tick(sample);
    while (time < 1) {
        double next = time + 1 / rate_Hz - offset;
        offset = jitter_s > 0 ? draw(-jitter_s, jitter_s) : 0;
        next += offset;
        if (time < stall_at_s && next >= stall_at_s) next += stall_s;
        // what is held now goes on until then
        const double force = s.record().coupling_N.norm();
        for (double from = time; from < std::min(next, 1.0) - 1e-12;) {
            const auto slot = static_cast<std::size_t>(std::min(99.0, std::floor(100 * from + 1e-9)));
            const double to = std::min(next, 0.01 * static_cast<double>(slot + 1));
            sum[slot] += 100 * (to - from) * force;
            from = to;
        }
        const double passed = next - time;
        time = next;
        sample.position_m = led(time);
        s.tick(sample, passed);
    }
    return sum;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b, std::size_t from = 0) {
    double most = 0;
    for (std::size_t k = from; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
    return most / *std::max_element(a.begin(), a.end());
}

}  // namespace

TEST_CASE("a hand with mass comes to rest on the tissue, where the tissue's own equilibrium is", "[hand]") {
    // a small part of tests/bench/bench_hand
    for (const bool relaxes : {false, true}) {
        const TissueModel tissue = relaxes ? relaxing(law_example()) : law_example();
        const LawPress answer(tissue);
        const FreeSurface surface(tissue.mesh);
        for (const double scale : {1.0, 2.0}) {
            const HapticModel model(tissue, alone(scale));
            for (const Hand& hand : hands)
                for (const test::Clock& clock : clocks)
                    for (const double force : {0.1, 1.0}) {
                        Release release;
                        const FreeSurface::Place place = surface.nearest(Eigen::Vector2d(0.052, 0.1));
                        release.contact_m = place.point_m;
                        release.inward = place.inward;
                        release.force_N = force;
                        release.creeps = relaxes;
                        const Rest rest = let_go(model, hand, clock, release);
                        INFO(hand.name << ", " << clock.name << ", force scale " << scale << ", " << force << " N" << (relaxes ? ", relaxing" : "") << ": swing " << 1e3 * rest.swing_m << " mm, "
                                       << rest.swing_N << " N of " << rest.force_N << " N, controller in " << 100 * rest.controlled << " %");
                        REQUIRE(rest.contact);
                        CHECK(rest.faults == 0);
                        CHECK(rest.swing_m < 1e-4);
                        CHECK(rest.swing_N < 0.05 * rest.force_N);
                        CHECK(rest.controlled < 0.01);
                        if (relaxes) continue;
                        const Equilibrium exact = answer.at(rest.touched_m, rest.push_m);
                        REQUIRE(exact);
                        CHECK(scale * exact.contact_force.norm() == Approx(rest.force_N).epsilon(0.02));
                    }
        }
    }
}

TEST_CASE("the force does not depend on how often a host ticks", "[hand]") {
    for (const bool relaxes : {false, true}) {
        HapticOptions options = alone();
        options.safety.hold_s = 1;
        const HapticModel model(relaxes ? relaxing(law_example()) : law_example(), options);
        const std::vector<double> usual = held_force(model, 1000);
        constexpr std::size_t after_landing = 25;  // a slow host learns of it late, and the tissue swings from it
        for (const double rate_Hz : {250.0, 500.0, 2000.0, 4000.0, 8000.0}) {
            INFO(rate_Hz << " Hz" << (relaxes ? ", relaxing" : ""));
            CHECK(largest_difference(usual, held_force(model, rate_Hz), after_landing) < 0.01);
        }
        CHECK(largest_difference(usual, held_force(model, 100), after_landing) < 0.05);  // where the hand will be in 10 ms is a guess
        CHECK(largest_difference(usual, held_force(model, 100), 90) < 0.01);             // and none where it rests
        CHECK(largest_difference(usual, held_force(model, 1000, 3e-4)) < 0.01);
        CHECK(largest_difference(usual, held_force(model, 1000, 0, 0.3, 0.15), 48) < 0.01);  // a stall of 150 ms, and some ticks to make up for it
    }
}

TEST_CASE("time that no tick can make up for is counted", "[hand]") {
    const HapticModel model(law_example(), alone());
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0);
    for (int k = 0; k < 10; ++k) s.tick(sample);
    CHECK(s.counters().lost_s == 0);
    s.tick(sample, 3.0);
    CHECK(s.counters().lost_s == Approx(2.5).margin(0.01));
    CHECK(s.record().time_s == Approx(3.01));
}

TEST_CASE("a tissue that is too stiff for a device is refused, with the numbers", "[hand]") {
    const TissueModel tissue = law_example();
    HapticOptions options = alone(3);
    const double contact_N_m = HapticModel(tissue, options).meshes[0]->contact_N_m;
    options.device.force_max_N = 2;
    options.device.mass_kg = 0.9 * 3 * contact_N_m * 1e-6 / stable_share;
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("force-scale may be 2.70 at most") || Contains("force-scale may be 2.69 at most"));
    options.map.force_scale = 2.69;
    CHECK(HapticModel(tissue, options).options.safety.force_max_N == 2);
    options.dt_s = 2e-3;  // four times as strict
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("dt 0.002 s"));
    options.dt_s = 1e-3;
    options.device.stiffness_N_m = 100;
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("the device can show 100 N/m"));
}

TEST_CASE("the cap that a surplus of energy sets on the force is counted, and goes away", "[hand]") {
    SafetyOptions o;
    Safety safety(o);
    DeviceSample sample;
    // a device that lets go of 3 N again and again: each time the worst is booked
    for (int k = 0; k < 200; ++k) {
        safety.admit(sample, k % 20 == 19 ? 0.012 : 1e-3);
        safety.limit({0, 3, 0});
    }
    CHECK(safety.counters().late > 5);
    CHECK(safety.counters().capped > 0);
    CHECK(safety.force_N().norm() < 2.9);
    for (int k = 0; k < 20000; ++k) {
        safety.admit(sample, 1e-3);
        safety.limit({0, 3, 0});
    }
    CHECK(safety.force_N().norm() == Approx(3));
}

}  // namespace tissue
