#include <Eigen/Eigenvalues>
#include <array>
#include <catch2/catch.hpp>

#include "../example.h"
#include "../refusal.h"
#include "error.h"
#include "hand.h"
#include "haptic_example.h"
#include "mesh/free_surface.h"
#include "springs/indentation_solver.h"

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

/// Position of a hand that is led smoothly: into the top, waits, 2 mm deeper, waits.
Eigen::Vector3d led(double time_s) {
    const auto smooth = [&](double from, double seconds) {
        const double s = std::clamp((time_s - from) / seconds, 0.0, 1.0);
        return s * s * s * (10 - 15 * s + 6 * s * s);
    };
    return {0.052, 0.102 - 0.009 * smooth(0.05, 0.3) - 0.002 * smooth(0.5, 0.2), 0};
}

/// Mean of the held force over each hundredth of a second [N] (100).
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
        // the present force is held until the next tick
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

/// A hand that moves freely near the middle of the top and presses straight in.
Release at_the_top(const FreeSurface& surface) {
    const FreeSurface::Place place = surface.nearest(Eigen::Vector2d(0.052, 0.1));
    Release release;
    release.contact_m = place.point_m;
    release.inward = place.inward;
    return release;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b, std::size_t from = 0) {
    double most = 0;
    for (std::size_t k = from; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
    return most / *std::max_element(a.begin(), a.end());
}

}  // namespace

TEST_CASE("the residual motion of a damped hand on a spring matches the analytical solution", "[hand]") {
    // 100 g and 1 Ns/m on 1.5 N/m: s^2 + 10 s + 15 = 0. slow_left, fast_left: amplitude of each exponential when the
    // force has risen.
    const double slow = 5 - std::sqrt(10.0), fast = 5 + std::sqrt(10.0), T = 0.2;
    const double slow_left = fast * -std::expm1(-slow * T) / (slow * T), fast_left = slow * -std::expm1(-fast * T) / (fast * T);
    const double first = slow_left * -std::expm1(-slow) + fast_left * std::expm1(-fast), last = slow_left * std::exp(-2 * slow) * -std::expm1(-0.25 * slow);
    CHECK(left_by_damping(hands[1], 1.5, 3.2) == Catch::Detail::Approx(last / first).epsilon(0.01));
    // envelope of the oscillation
    CHECK(left_by_damping(hands[0], 269, 3.2) == Catch::Detail::Approx(std::exp(-0.2 * 2 / (2 * 0.045))).epsilon(0.2));
}

TEST_CASE("a hand with mass comes to rest on tissue at the force of the static equilibrium", "[hand][long]") {
    // a subset of scripts/hand_probe.cpp
    for (const bool relaxes : {false, true}) {
        const TissueModel tissue = relaxes ? relaxing(energy_model_example()) : energy_model_example();
        const IndentationSolver answer(tissue);
        const FreeSurface surface(tissue.mesh);
        for (const double scale : {1.0, 2.0}) {
            const HapticModel model(tissue, alone(scale));
            for (const Hand& hand : hands)
                for (const test::Clock& clock : clocks)
                    for (const double force : {0.1, 1.0}) {
                        Release release = at_the_top(surface);
                        release.force_N = force;
                        release.creeps = relaxes;
                        const Rest rest = let_go(model, hand, clock, release);
                        INFO(hand.name << ", " << clock.name << ", force scale " << scale << ", " << force << " N" << (relaxes ? ", relaxing" : "") << ": swing " << 1e3 * rest.swing_m << " mm, "
                                       << rest.swing_N << " N of " << rest.force_N << " N, controller active in " << 100 * rest.controlled << " %");
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

TEST_CASE("a hand comes to rest with positions that are up to half of dt old", "[hand][long]") {
    const TissueModel tissue = energy_model_example();
    const FreeSurface surface(tissue.mesh);
    for (const double scale : {1.0, 2.0})
        for (const double age_s : {3e-4, 5e-4})
            for (const Hand& hand : hands) {
                HapticOptions options = alone(scale);
                options.device.mass_kg = hand.mass_kg;  // else the model is refused
                const HapticModel model(tissue, options);
                const Release release = at_the_top(surface);
                const Rest rest = let_go(model, hand, {"old", 0, 0, age_s}, release);
                INFO(hand.name << ", force scale " << scale << ", " << 1e3 * age_s << " ms old: swing " << 1e3 * rest.swing_m << " mm, " << rest.swing_N << " N of " << rest.force_N << " N, controller active in "
                               << 100 * rest.controlled << " %");
                REQUIRE(rest.contact);
                CHECK(rest.faults == 0);
                CHECK(rest.swing_m < 1e-4);
                CHECK(rest.swing_N < 0.05 * rest.force_N);
                CHECK(rest.controlled < 0.01);
            }
}

TEST_CASE("taps and releases and drags give the hand no net energy and drags have no tremor", "[hand][long]") {
    for (const bool relaxes : {false, true})
        for (const double friction : {std::numeric_limits<double>::infinity(), 0.3}) {
            HapticOptions options = alone();
            options.friction.stick = friction;
            const HapticModel model(relaxes ? relaxing(energy_model_example()) : energy_model_example(), options);
            const FreeSurface surface(model.rest);
            for (const Hand& hand : hands)
                for (const test::Clock& clock : clocks)
                    for (const Deed deed : {Deed::taps, Deed::lets_go, Deed::drags}) {
                        Release release = at_the_top(surface);
                        const Ride ride = does(deed, model, hand, clock, release);
                        INFO(hand.name << ", " << clock.name << (relaxes ? ", relaxing" : "") << ", friction " << friction << ", deed " << static_cast<int>(deed) << ": " << 1e6 * ride.most_given_J
                                       << " uJ given of " << 1e6 * ride.put_in_J << ", tremor " << 1e3 * ride.tremor_m << " mm, controller active in " << 100 * ride.controlled << " %");
                        CHECK(ride.faults == 0);
                        CHECK(ride.put_in_J > 1e-5);
                        CHECK(ride.passive());
                        CHECK(ride.controlled < 0.01);
                        if (deed == Deed::drags) {
                            CHECK(ride.contact);
                            CHECK_FALSE(ride.lost);
                            CHECK(ride.tremor_m < 5e-5);
                        }
                        if (deed == Deed::lets_go) CHECK_FALSE(ride.contact);
                    }
        }
}

TEST_CASE("a hand that drags a disc by 10 mm comes to rest without net energy and the contact stays convex", "[hand][solid][long]") {
    constexpr double drag_m = 0.01;
    for (const bool relaxes : {false, true}) {
        const HapticModel model(relaxes ? relaxing(solid_example()) : solid_example(), alone());
        const FreeSurface::Place place = FreeSurface(model.rest).nearest((Point(3) << 0.03, 0.03, 0.05).finished());
        const Eigen::Vector3d inward = place.inward, along = Eigen::Vector3d::UnitX();
        for (const Hand& hand : hands)
            for (const test::Clock& clock : clocks) {
                HandLoop loop(model, hand, clock);
                loop.lead(place.point_m - 0.006 * inward, place.point_m + 5e-4 * inward, 0.3);
                const Eigen::Vector3d start = loop.x;
                double least_N_m = std::numeric_limits<double>::infinity();
                bool lost = false;
                std::vector<Moment> way;
                const auto applied = [&](double time, const Eigen::Vector3d& x, const Eigen::Vector3d& v) {
                    const double at = drag_m * std::clamp(time - 0.5, 0.0, 1.0);
                    const Eigen::Vector3d off = start + at * along - x;
                    return Eigen::Vector3d(std::min(1.0, time / 0.2) * 0.3 * inward + 300 * (off - off.dot(inward) * inward) - 2 * v.dot(along) * along);
                };
                loop.play(4, applied, [&](const HandLoop& now) {
                    const Simulation& s = now.simulation;
                    lost = lost || !s.contact().pressing;
                    if (lost) return;
                    const Eigen::Matrix3d stiffness = s.tool().stiffness_N_m(s.record().contact_displacement_m, s.state(0).displacement);
                    least_N_m = std::min(least_N_m, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(stiffness).eigenvalues()[0]);
                    if (now.time > 3.5) way.push_back({now.time, now.x, now.force});
                });
                REQUIRE(!way.empty());
                const double swing_m = extent(way, relaxes, [](const Moment& m) { return m.position_m; });
                INFO(hand.name << ", " << clock.name << (relaxes ? ", relaxing" : "") << ": at the least " << least_N_m << " N/m, dragged by " << 1e3 * (loop.x - start).dot(along) << " mm, swing " << 1e3 * swing_m << " mm, "
                               << 1e6 * loop.most_given_J << " uJ given of " << 1e6 * loop.put_in_J << ", controller active in " << 100 * loop.controlled(0, 0) << " %");
                CHECK(least_N_m > 0);  // the tissue follows, so that the contact stays where its energy is convex
                CHECK_FALSE(lost);
                CHECK(loop.faults == 0);
                CHECK((loop.x - start).dot(along) > 0.7 * drag_m);
                CHECK(swing_m < 1e-4);
                CHECK(loop.most_given_J <= 1e-6 + 0.01 * loop.put_in_J);
                CHECK(loop.controlled(0, 0) < 0.01);
            }
    }
}

TEST_CASE("a tool at the device's force limit stays behind the hand and gives it no net energy", "[hand]") {
    HapticOptions options = alone();
    options.map.force_scale = 3;
    TissueModel muscle = energy_model_example();
    muscle.energy_model->constants *= 3.7;
    muscle.energy_model->contact_log_scale = Eigen::VectorXd::Constant(muscle.mesh.node_count(), std::log(3.7));
    for (const bool relaxes : {false, true}) {
        const HapticModel model(relaxes ? relaxing(muscle) : muscle, options);
        const FreeSurface surface(model.rest);
        for (const test::Clock& clock : clocks) {
            const FreeSurface::Place place = surface.nearest(Eigen::Vector2d(0.052, 0.1));
            Release release;
            release.contact_m = place.point_m;
            release.inward = place.inward;
            const Ride ride = does(Deed::taps, model, hands[3], clock, release);
            INFO(clock.name << (relaxes ? ", relaxing: " : ": ") << 1e6 * ride.most_given_J << " uJ given of " << 1e6 * ride.put_in_J << ", controller active in " << 100 * ride.controlled << " %");
            CHECK(ride.put_in_J > 5e-3);
            CHECK(ride.passive());
            CHECK(ride.controlled < 0.01);

            // Led far beyond the limit: the force on the hand is the device's limit, that on the tissue is the limit
            // over the force scale.
            HandLoop loop(model, hands[3], clock);
            loop.lead(place.point_m - 0.003 * place.inward, place.point_m + 0.012 * place.inward, 0.5);
            CHECK(loop.force.norm() == Approx(3.3).epsilon(1e-4));
            CHECK(loop.simulation.record().coupling_N.norm() == Approx(1.1).epsilon(1e-4));
            CHECK(loop.simulation.safety().counters().clamped > 100);
        }
    }
}

TEST_CASE("the contact force does not depend on the host's tick rate", "[hand]") {
    for (const bool relaxes : {false, true}) {
        HapticOptions options = alone();
        options.safety.hold_s = 1;
        const HapticModel model(relaxes ? relaxing(energy_model_example()) : energy_model_example(), options);
        const std::vector<double> usual = held_force(model, 1000);
        // a slow host detects the contact late, and the tissue oscillates from it
        constexpr std::size_t after_landing = 25;
        for (const double rate_Hz : {250.0, 500.0, 2000.0, 4000.0, 8000.0}) {
            INFO(rate_Hz << " Hz" << (relaxes ? ", relaxing" : ""));
            CHECK(largest_difference(usual, held_force(model, rate_Hz), after_landing) < 0.01);
        }
        // the hand's position in 10 ms is extrapolated
        CHECK(largest_difference(usual, held_force(model, 100), after_landing) < 0.05);
        CHECK(largest_difference(usual, held_force(model, 100), 90) < 0.01);             // no extrapolation at rest
        CHECK(largest_difference(usual, held_force(model, 1000, 3e-4)) < 0.01);
        // after a stall of 150 ms and some ticks to make up for it
        CHECK(largest_difference(usual, held_force(model, 1000, 0, 0.3, 0.15), 48) < 0.01);
    }
}

TEST_CASE("the force at rest is the same from 50 Hz to 1 kHz at several places and depths and approach times", "[hand][long]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(energy_model_example(), options);
    const auto rest = [&](double rate_Hz, double x_m, double depth_m, double within_s) {
        Simulation s(model);
        DeviceSample sample;
        double least_N = std::numeric_limits<double>::infinity(), most_N = 0, sum_N = 0;
        int ticks = 0;
        for (double time = 0; time < 2.5; time += 1 / rate_Hz) {
            sample.position_m = {x_m, 0.102 - (0.002 + depth_m) * std::min(1.0, time / within_s), 0};
            const double force_N = s.tick(sample, 1 / rate_Hz).norm();
            if (time < 1.5) continue;
            least_N = std::min(least_N, force_N), most_N = std::max(most_N, force_N), sum_N += force_N;
            ++ticks;
        }
        return std::array{sum_N / ticks, most_N - least_N};
    };
    for (const double x_m : {0.02, 0.035, 0.052, 0.08})
        for (const double depth_m : {0.001, 0.003})
            for (const double within_s : {0.05, 0.1, 0.3}) {
                const auto usual = rest(1000, x_m, depth_m, within_s);
                for (const double rate_Hz : {50.0, 100.0, 125.0, 200.0}) {
                    const auto [mean_N, swing_N] = rest(rate_Hz, x_m, depth_m, within_s);
                    INFO(rate_Hz << " Hz, at " << 1e3 * x_m << " mm, " << 1e3 * depth_m << " mm deep within " << within_s << " s: " << mean_N << " N, swing " << swing_N << " N, at 1 kHz " << usual[0] << " N");
                    CHECK(swing_N < 1.5 * usual[1] + 0.01 * usual[0]);  // remaining oscillation of the tissue itself
                    CHECK(mean_N == Approx(usual[0]).epsilon(0.01));
                }
            }
}

TEST_CASE("a tool moved along its imprint has no larger tangential force at a slow host than at 1 kHz", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(relaxing(energy_model_example()), options);
    // largest tangential force while the tool moves along the floor of its imprint and is pressed in beside it
    const auto aside = [&](double rate_Hz) {
        Simulation s(model);
        DeviceSample sample;
        double along_N = 0;
        for (double time = 0; time < 3.2; time += 1 / rate_Hz) {
            const double lifted_m = std::max(0.0008, 0.006 - 0.05 * (time - 1.5)), deep_m = time < 0.3 ? 0.006 * time / 0.3 : time < 1.5 ? 0.006 : time < 2.4 ? lifted_m : 0.0008 + 0.0032 * std::min(1.0, (time - 2.4) / 0.3);
            sample.position_m = {0.03 + std::clamp(0.02 * (time - 1.7), 0.0, 0.012), 0.1 - deep_m, 0};
            s.tick(sample, 1 / rate_Hz);
            if (time > 1.75 && s.record().mesh >= 0) along_N = std::max(along_N, std::abs(s.record().coupling_N.x()));
        }
        return along_N;
    };
    const double usual_N = aside(1000);
    for (const double rate_Hz : {500.0, 200.0, 50.0}) {
        INFO(rate_Hz << " Hz");
        CHECK(aside(rate_Hz) < 1.2 * usual_N + 0.01);
    }
}

TEST_CASE("time that cannot be made up for is counted as lost", "[hand]") {
    const HapticModel model(energy_model_example(), alone());
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0);
    for (int k = 0; k < 10; ++k) s.tick(sample);
    CHECK(s.counters().lost_s == 0);
    s.tick(sample, 3.0);
    CHECK(s.counters().lost_s == Approx(2.5).margin(0.01));
    CHECK(s.record().time_s == Approx(3.01));
    s.tick(sample, 8 * 3600.0);
    CHECK(s.counters().lost_s == Approx(3 + 8 * 3600 - 0.5).margin(0.05));  // all but the time that may be made up for
}

TEST_CASE("tissue that is too stiff for the device is refused with the limit in the message", "[hand][long]") {
    const TissueModel tissue = energy_model_example();
    HapticOptions options = alone(3);
    const double contact_N_m = HapticModel(tissue, options).meshes[0]->contact_N_m;
    options.device.force_max_N = 2;
    const double lead = HapticModel(tissue, options).meshes[0]->lead;
    DeviceImpedance one;
    one.mass_kg = 1;
    options.device.mass_kg = 0.9 * 3 * contact_N_m / stable_stiffness_N_m(one, 1e-3, lead);
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("set force-scale to at most 2.70") || Contains("set force-scale to at most 2.69"));
    options.map.force_scale = 2.69;
    CHECK(HapticModel(tissue, options).options.safety.force_max_N == 2);
    options.dt_s = 2e-3;  // the allowed stiffness falls to a quarter
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("a force every 0.002 s"));
    options.dt_s = 1e-3;
    options.map.force_scale = std::numeric_limits<double>::infinity();
    CHECK_THROWS_AS(HapticModel(tissue, options), MismatchError);
    options.map.force_scale = 2.69;
    options.device.stiffness_N_m = 100;
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("the device can render at most 100 N/m"));
}

TEST_CASE("stable_stiffness_N_m is 0.45 of the stiffness at which a contact on the device becomes unstable", "[hand][long]") {
    constexpr double dt = 1e-3;
    for (const std::pair<double, double>& given : {std::pair(0.0, 0.0), std::pair(2.0, 0.0), std::pair(0.2, 1e-3), std::pair(2.0, 1e-3), std::pair(2.0, 1.6e-3)})
        for (const double lead : {0.6, 0.75, 1.0}) {
            const double damping = given.first, delay_s = given.second;
            DeviceImpedance device;
            device.mass_kg = 0.1;
            device.damping_Ns_m = damping;
            device.delay_s = delay_s;
            const double limit_N_m = stable_stiffness_N_m(device, dt, lead) / 0.45;
            const auto late = static_cast<std::size_t>(std::ceil(delay_s / dt - 1e-9));
            for (const double share : {0.97, 1.03}) {
                double x = 1e-3, v = 0;
                std::deque<double> was(late + 3, x);  // positions at this tick and earlier ones
                const auto tick = [&] {
                    was.push_front(x);
                    was.pop_back();
                    const auto tool = [&](std::size_t k) { return was[k + late] + (1.0 + static_cast<double>(late)) * (was[k + late] - was[k + late + 1]); };
                    const double force = -share * limit_N_m * (lead * tool(0) + (1 - lead) * tool(1));
                    for (int k = 0; k < 1000; ++k) {
                        const double faster = 1e-3 * dt * (force - damping * v) / device.mass_kg;
                        x += 1e-3 * dt * (v + faster / 2);
                        v += faster;
                    }
                };
                for (int k = 0; k < 20000 && std::abs(x) < 1e3; ++k) tick();
                double swing = 0;
                for (int k = 0; k < 500; ++k) {
                    tick();
                    swing = std::max(swing, std::abs(x));
                }
                INFO("damping " << damping << ", " << delay_s << " s late, lead " << lead << ", " << share << " of " << limit_N_m << " N/m");
                CHECK((swing < 1e-3) == (share < 1));
            }
        }
    DeviceImpedance device;
    device.mass_kg = 1;
    CHECK(stable_stiffness_N_m(device, dt, 1) == Approx(0.3e6));
    CHECK(stable_stiffness_N_m(device, dt, 0.5) == 0);  // no damping of the contact is left
    DeviceImpedance said;
    said.mass_kg = 0.06;
    said.force_max_N = 5;
    const DeviceImpedance both = stricter(said, touch_impedance);
    CHECK(both.mass_kg == 0.06);
    CHECK(both.force_max_N == 3.3);
    CHECK(both.stiffness_N_m == 1020);
    CHECK(both.rate_Hz == 1000);
    said.rate_Hz = 500;
    CHECK(stricter(said, touch_impedance).rate_Hz == 500);
    CHECK(stricter(said, touch_impedance).delay_s == 1e-3);
    DeviceImpedance damped;  // nearly massless: the limit is up to twice its damping over dt, for any mass
    damped.mass_kg = 1e-5;
    damped.damping_Ns_m = 1;
    CHECK(stable_stiffness_N_m(damped, dt, 1) > 0.45 * 0.4 * damped.damping_Ns_m / dt);
}

TEST_CASE("a Touch with a delay of one servo period comes to rest up to the largest accepted force scale", "[hand][long]") {
    const TissueModel tissue = energy_model_example();
    const FreeSurface surface(tissue.mesh);
    HapticOptions options = alone(1);
    const HapticModel any(tissue, options);
    const double contact_N_m = any.meshes[0]->contact_N_m, lead = any.meshes[0]->lead;
    options.device = touch_impedance;
    // its largest stiffness at rest is not tested here
    options.device.stiffness_N_m = std::numeric_limits<double>::infinity();
    const double most = stable_stiffness_N_m(options.device, options.dt_s, lead) / contact_N_m;
    options.map.force_scale = 1.02 * most;
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("a force every 0.001 s and 0.001 s late"));
    options.map.force_scale = 0.98 * most;
    const HapticModel model(tissue, options);
    for (const Hand& hand : hands)
        for (const test::Clock& clock : clocks)
            for (const double force : {0.1, 1.0}) {
                Release release = at_the_top(surface);
                release.force_N = force * options.map.force_scale;
                const Rest rest = let_go(model, hand, {clock.name, clock.jitter_s, clock.late_share, 1e-3}, release);
                INFO(hand.name << ", " << clock.name << ", force scale " << options.map.force_scale << ", " << force << " N: swing " << 1e3 * rest.swing_m << " mm (damping alone: " << 1e3 * rest.damped_m << " mm), "
                               << rest.swing_N << " N of " << rest.force_N << " N, controller active in " << 100 * rest.controlled << " %");
                REQUIRE(rest.contact);
                CHECK(rest.faults == 0);
                CHECK(rest.swing_m < std::max(1e-4, 1.05 * rest.damped_m));
                CHECK(rest.controlled < 0.01);
            }
}

TEST_CASE("a single early tick loses at most 30 ms at a host whose ticks cost half of their time", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(energy_model_example(), options);
    for (const double early_s : {1e-6, 1e-3}) {
        Simulation s(model);
        DeviceSample sample;
        sample.position_m = led(0.4);
        for (int k = 0; k < 1500; ++k) s.tick(sample, k == 700 ? early_s : 0.01, 0.5 * s.advanced_s());
        INFO("a period of " << early_s << " s");
        CHECK(s.counters().lost_s <= 0.03);
    }
}

TEST_CASE("a session counts the time lost by one of its two meshes", "[hand]") {
    HapticOptions options;
    const HapticModel model(energy_model_example(), options);
    REQUIRE(model.meshes.size() == 2);
    REQUIRE(model.meshes[0]->substeps != model.meshes[1]->substeps);
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0);
    constexpr double period_s = 1.57e-3;
    constexpr int ticks = 4000;
    for (int k = 0; k < ticks; ++k) s.tick(sample, period_s, 0.95 * s.advanced_s());
    CHECK(s.counters().lost_s > 0.2 * ticks * period_s);
}

TEST_CASE("a device with a position rate below that of ticks is checked at its own period", "[hand]") {
    const TissueModel tissue = energy_model_example();
    HapticOptions options = alone();
    const HapticModel any(tissue, options);
    const HapticMesh& mesh = *any.meshes[0];
    options.device.mass_kg = 1;
    options.device.mass_kg = 1.5 * mesh.contact_N_m / stable_stiffness_N_m(options.device, options.dt_s, mesh.lead);
    options.device.rate_Hz = 1 / options.dt_s;
    CHECK_NOTHROW(HapticModel(tissue, options));
    options.device.rate_Hz = 4 / options.dt_s;  // not faster than the ticks
    CHECK_NOTHROW(HapticModel(tissue, options));
    options.device.rate_Hz = 0.25 / options.dt_s;
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("a force every 0.004 s"));
    const HapticModel model(tissue, alone());
    Simulation simulation(model);
    CHECK_THAT(refusal<MismatchError>([&] { simulation.change(options); }), Contains("a force every 0.004 s"));
}

TEST_CASE("the force of a tick is that of a hand ahead by the stated lead", "[hand]") {
    for (const bool is_energy_model : {true, false})
        for (const double stiffest : {1.0, 1e6}) {
            // Nodes so heavy that they do not move. For an energy model `stiffest` restores several steps per tick.
            TissueModel tissue = is_energy_model ? energy_model_example() : haptic_example();
            tissue.node_mass_kg *= 1e6;
            HapticOptions options = alone();
            options.stiffest = stiffest;
            options.damping_ratio = 0;
            options.safety.force_max_N = options.safety.slew_N_s = 1e6;
            const HapticModel model(tissue, options);
            const HapticMesh& mesh = *model.meshes[0];
            const double dt = options.dt_s, speed = 0.05;
            const auto hand = [&](double time_s) { return Eigen::Vector3d(0.052, 0.101 - speed * time_s, 0); };
            DeviceSample sample;
            Simulation moving(model);
            double time = 0;
            for (; time < 0.06; time += dt) {
                sample.position_m = hand(time);
                moving.tick(sample);
            }
            time -= dt;
            Simulation still(model);
            sample.position_m = hand(0);
            still.tick(sample);
            for (int k = 0; k < 6; ++k) {
                sample.position_m = hand(k == 0 ? 0.03 : time + mesh.lead * dt);
                still.tick(sample);
            }
            INFO((is_energy_model ? "energy model, " : "spring sets, ") << mesh.substeps << " steps, lead " << mesh.lead);
            REQUIRE(still.record().coupling_N.norm() > 1e-3);
            CHECK(moving.record().coupling_N.norm() == Approx(still.record().coupling_N.norm()).epsilon(1e-3));
            CHECK((mesh.substeps > 1) == (is_energy_model && stiffest > 1));
            CHECK(mesh.lead >= Approx(mesh.substeps > 1 ? 0.55 : 0.75));
        }
}

TEST_CASE("after a stall during an indentation the force returns to its value", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = std::numeric_limits<double>::infinity();
    const HapticModel model(energy_model_example(), options);
    Simulation s(model);
    DeviceSample sample;
    for (int k = 0; k < 2000; ++k) {
        sample.position_m = led(std::min(1e-3 * k, 0.45));
        s.tick(sample);
    }
    const double force = s.record().coupling_N.norm();
    REQUIRE(force > 0.1);
    for (const double stall_s : {5.0, 1e308}) {
        s.tick(sample, stall_s);
        CHECK(s.record().status == TickStatus::done);
        for (int k = 0; k < 300; ++k) s.tick(sample);
        CHECK(s.record().coupling_N.norm() == Approx(force).epsilon(1e-3));
    }
    CHECK(s.counters().unstable == 0);
    const double before_s = s.record().time_s;
    s.tick(sample, std::numeric_limits<double>::quiet_NaN());
    CHECK(s.record().time_s == Approx(before_s + force_held_s));
}

TEST_CASE("a tick of unknown length counts as the time for which the device holds a force", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 0.2;
    const HapticModel model(energy_model_example(), options);
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0);
    s.tick(sample);
    s.tick(sample, -1);
    CHECK(s.record().time_s == Approx(0.201));
}

TEST_CASE("a reset sets the force to zero at once", "[hand]") {
    const HapticModel model(energy_model_example(), alone());
    Simulation s(model);
    DeviceSample sample;
    for (int k = 0; k < 400; ++k) {
        sample.position_m = led(1e-3 * k);
        s.tick(sample);
    }
    REQUIRE(s.record().device_N.norm() > 0.1);
    s.reset();
    CHECK(s.tick(sample).norm() == 0);
    CHECK(s.record().status == TickStatus::not_armed);
}

TEST_CASE("a host that is slower than dt loses no time", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    options.dt_s = 1e-3;
    for (const double rate_Hz : {50.0, 60.0}) {
        const HapticModel model(energy_model_example(), options);
        Simulation s(model);
        DeviceSample sample;
        sample.position_m = led(0);
        for (int k = 0; k < 4 * rate_Hz; ++k) s.tick(sample, 1 / rate_Hz);
        CHECK(s.counters().lost_s == 0);
        CHECK(s.record().time_s == Approx(4));
    }
}

namespace {

/// A host whose tick costs `share` of the time by which the tissue advanced in it. The next tick starts as soon as it
/// is due, or with the next period of the schedule (by_schedule), as in run_loop.
struct Host {
    Simulation& s;
    double period_s, share;
    bool by_schedule;
    double elapsed_s = period_s, cost_s = 0, time_s = 0, advanced_s = 0;

    void tick(double stall_s = 0) {
        DeviceSample sample;
        sample.position_m = led(0.4);
        s.tick(sample, elapsed_s, cost_s);
        time_s += elapsed_s;
        advanced_s += s.advanced_s();
        cost_s = share * s.advanced_s();
        const double busy_s = cost_s + stall_s;
        elapsed_s = by_schedule ? period_s * std::max(1.0, std::ceil(busy_s / period_s - 1e-9)) : std::max(period_s, busy_s);
    }
};

}  // namespace

TEST_CASE("ticks that cost more than their time stay short and the lost time is counted", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(energy_model_example(), options);
    for (const double share : {0.95, 1.05, 1.1, 1.5, 3.0})
        for (const bool by_schedule : {true, false})
            for (const double stall_s : {0.0, 0.03, 2.0}) {
                Simulation s(model);
                Host host{s, 1e-3, share, by_schedule};
                double longest_s = 0;
                for (int k = 0; k < 2000; ++k) {
                    host.tick(k == 1000 ? stall_s : 0);
                    if (k > 300 && k != 1000 && k != 1001) longest_s = std::max(longest_s, host.cost_s);
                }
                INFO("a tick costs " << share << " of its time, " << (by_schedule ? "by a schedule" : "at once") << ", a stall of " << stall_s << " s: " << 1e3 * longest_s << " ms, lost " << s.counters().lost_s << " of "
                                     << host.time_s << " s, advanced " << host.advanced_s << " s");
                // the cost of 1 ms, or of the whole periods that a tick takes
                CHECK(longest_s < std::max(1.01 * share, by_schedule ? 0.91 * std::ceil(share) : 0) * 1e-3);
                CHECK(s.counters().lost_s == Approx(host.time_s - host.advanced_s).margin(0.005));
                if (share > 1) CHECK(s.counters().lost_s > 0.02 * host.time_s);
                CHECK(s.record().time_s == Approx(host.time_s));
            }
}

TEST_CASE("a stall of 30 ms loses no time at loads below 45 % and at most its length above", "[hand][long]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(energy_model_example(), options);
    for (const double share : {0.05, 0.4, 0.5, 0.7, 0.89})
        for (const double period_s : {1e-3, 0.01, 0.02})
            for (const bool by_schedule : {true, false}) {
                Simulation s(model);
                Host host{s, period_s, share, by_schedule};
                for (int k = 0; k < 1000; ++k) host.tick(k == 500 ? 0.03 : 0);
                INFO(period_s << " s, a tick costs " << share << " of its time" << (by_schedule ? ", by a schedule" : ""));
                // Where ticks cost half of their time, neither the stall nor the time owed at the start is made up for.
                CHECK(s.counters().lost_s <= (share < 0.45 ? 0 : 0.03 + 2 * period_s));
                CHECK(host.advanced_s + s.counters().lost_s == Approx(host.time_s).margin(0.03));
                CHECK(host.cost_s == Approx(share * period_s).epsilon(0.2));
            }
}

TEST_CASE("jitter and periods that no step divides lose no time at loads of 50 to 80 %", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    for (const TissueModel& tissue : {haptic_example(), energy_model_example()}) {
        const HapticModel model(tissue, options);
        for (const double rate_Hz : {300.0, 700.0, 970.0})
            for (const double share : {0.5, 0.6, 0.8}) {
                Simulation s(model);
                Host host{s, 1 / rate_Hz, share, false};
                for (int k = 0; k < 3 * rate_Hz; ++k) host.tick();
                INFO(rate_Hz << " Hz, a tick costs " << share << " of its time, " << model.meshes[0]->substeps << " steps: advanced " << host.advanced_s << " of " << host.time_s << " s");
                CHECK(s.counters().lost_s <= 2 / rate_Hz);
                CHECK(host.advanced_s == Approx(host.time_s).epsilon(0.005));
            }
        Simulation s(model);
        Draw draw(2008);
        DeviceSample sample;
        sample.position_m = led(0.4);
        constexpr double period_s = 5e-3, strays_s = 1e-4;
        double offset_s = 0;
        for (int k = 0; k < 3000; ++k) {
            const double next_s = draw(-strays_s, strays_s);
            s.tick(sample, period_s + next_s - std::exchange(offset_s, next_s), 0.7 * s.advanced_s());
        }
        INFO("jitter, " << model.meshes[0]->substeps << " steps");
        CHECK(s.counters().lost_s < 0.003 * 3000 * period_s);
    }
}

TEST_CASE("a host that becomes slow loses no time if its device holds the force and single stalls are made up for", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = std::numeric_limits<double>::infinity();
    const HapticModel model(energy_model_example(), options);
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0.4);
    double time_s = 0, advanced_s = 0;
    const auto ticks = [&](int count, double elapsed_s) {
        for (int k = 0; k < count; ++k) {
            s.tick(sample, elapsed_s);
            time_s += elapsed_s;
            advanced_s += s.advanced_s();
        }
    };
    ticks(1000, 1e-3);
    for (int k = 0; k < 10; ++k) {
        ticks(1, 0.06);
        ticks(50, 1e-3);
    }
    CHECK(s.advanced_s() <= 1.1e-3);  // the hand is not extrapolated farther after stalls
    CHECK(advanced_s == Approx(time_s).margin(2e-3));
    ticks(200, 0.05);
    CHECK(s.counters().lost_s == 0);
    CHECK(advanced_s == Approx(time_s).margin(0.06));
    ticks(1000, 1e-3);
    CHECK(advanced_s == Approx(time_s).margin(3e-3));
}

TEST_CASE("the time of a single interrupted tick is made up for", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(energy_model_example(), options);
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0.4);
    double advanced_s = 0, time_s = 0;
    for (int k = 0; k < 200; ++k) {
        const double elapsed_s = k == 100 ? 0.03 : 1e-3;
        s.tick(sample, elapsed_s, k == 100 ? 0.0299 : 1e-4);
        advanced_s += s.advanced_s();
        time_s += elapsed_s;
    }
    CHECK(s.counters().lost_s == 0);
    CHECK(advanced_s == Approx(time_s).margin(2e-3));
}

TEST_CASE("the energy log of old positions matches the work on the true motion of the hand", "[hand][long]") {
    for (const double late_s : {3e-4, 1e-3, 0.0104, 0.03})
        for (const double jitter_s : {0.0, 3e-4}) {
            HapticOptions options = alone(2);
            options.safety.passivity = false;  // the energy log alone
            const HapticModel model(energy_model_example(), options);
            Simulation s(model);
            Draw draw(2008);
            const double dt = options.dt_s;
            const auto hand = [&](double time) { return Eigen::Vector3d(0.052, 0.096 + 0.003 * std::cos(2 * 3.14159265 * 5 * time) + 0.006 * std::clamp(1 - time / 0.1, 0.0, 1.0), 0); };
            double given_J = 0, most_J = 0;
            std::vector<double> given_by;  // energy given before each tick
            for (int k = 0; k < 1500; ++k) {
                const double time = k * dt, age = late_s + (jitter_s > 0 ? draw(-jitter_s, jitter_s) : 0);
                DeviceSample sample;
                sample.position_m = hand(time - age);
                sample.age_s = age;
                const Eigen::Vector3d force = s.tick(sample);
                given_by.push_back(given_J);
                given_J += force.dot(hand(time + dt) - hand(time));
                most_J = std::max(most_J, std::abs(given_J));
            }
            REQUIRE(s.safety().counters().stale + s.safety().counters().jump == 0);
            const double known_J = given_by[given_by.size() - 1 - static_cast<std::size_t>(std::lround(late_s / dt))];
            INFO(1e3 * late_s << " ms late, jitter " << 1e3 * jitter_s << " ms: " << known_J << " J were given, " << s.safety().counters().energy_given_J << " J are in the log; " << most_J);
            REQUIRE(most_J > 0.003);
            CHECK(s.safety().counters().energy_given_J == Approx(known_J).margin(0.02 * most_J));
        }
}

TEST_CASE("spring sets with several steps per tick have the same force at any constant or changing tick rate", "[hand]") {
    for (const double stiffer : {1.0, 8.0, 300.0}) {
        ExampleModel example;
        example.spread = 0;  // else the nearest set might depend on the tick rate
        example.stiffer = stiffer;
        HapticOptions options = alone(20);
        options.dynamics = "symplectic";
        options.safety.hold_s = 1;
        const HapticModel model(haptic_example(example), options);
        const HapticMesh& mesh = *model.meshes[0];
        REQUIRE(mesh.substeps > 1);
        REQUIRE(mesh.contact_damping_s == contact_damping_s(1e-3, mesh.substeps));  // for any number of steps
        const std::vector<double> usual = held_force(model, 1000);
        constexpr std::size_t after_landing = 25;
        INFO(mesh.substeps << " steps a tick, lead " << mesh.lead);
        for (const double rate_Hz : {250.0, 500.0, 4000.0, 8000.0}) {
            INFO(rate_Hz << " Hz");
            CHECK(largest_difference(usual, held_force(model, rate_Hz), after_landing) < 0.02);
        }
        // The rate changes during the indentation.
        Simulation s(model), on_time(model);
        Draw draw(2008);
        double time = 0, ticked = 0;
        DeviceSample sample;
        int faults = 0;
        for (int k = 0; k < 1000; ++k) {
            time += 1e-3;
            sample.position_m = led(time);
            on_time.tick(sample);
            const double rate_Hz[] = {1000, 250, 4000, 500, 8000};
            const double period = 1 / rate_Hz[k / 100 % 5];
            while (ticked + period <= time + 1e-9) {
                ticked += period;
                sample.position_m = led(ticked);
                s.tick(sample, period);
                faults += s.record().fault();
            }
            if (k > 400 && k % 100 > 60) CHECK(s.record().coupling_N.norm() == Approx(on_time.record().coupling_N.norm()).epsilon(0.02));
        }
        CHECK(faults == 0);
        CHECK(s.counters().unstable == 0);
        CHECK(on_time.record().coupling_N.norm() > 1e-3);
    }
}

TEST_CASE("a sliding contact has the same force at any tick rate", "[hand]") {
    HapticOptions options = alone();
    options.friction.stick = 0.3;
    const HapticModel model(energy_model_example(), options);
    const auto dragged = [&](double rate_Hz) {
        Simulation s(model);
        DeviceSample sample;
        Point sum = Point::Zero(2);
        int count = 0;
        for (double time = 0; time < 1; time += 1 / rate_Hz) {
            sample.position_m = led(std::min(time, 0.45));
            sample.position_m.x() += 0.04 * std::max(0.0, time - 0.5);
            s.tick(sample, 1 / rate_Hz);
            if (time < 0.8) continue;
            sum += s.record().coupling_N;
            ++count;
        }
        return Point(sum / count);
    };
    const Point usual = dragged(1000);
    REQUIRE(std::abs(usual.x()) > 0.2 * std::abs(usual.y()));  // the contact slips
    for (const double rate_Hz : {250.0, 4000.0, 8000.0}) CHECK((dragged(rate_Hz) - usual).norm() < 0.01 * usual.norm());
}

TEST_CASE("force limited by the energy bound is counted and the limit fades", "[hand]") {
    SafetyOptions o;
    Safety safety(o);
    DeviceSample sample;
    // The device releases 3 N repeatedly. Each time the worst case is counted.
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
