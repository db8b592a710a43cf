#include <Eigen/Eigenvalues>
#include <array>
#include <catch2/catch.hpp>

#include "../example.h"
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

/// A hand that is let go near the middle of the top, and pushes straight in.
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

TEST_CASE("what a hand's own damping leaves of its way on a spring is that of its two exponentials", "[hand]") {
    // 100 g and 1 Ns/m on 1.5 N/m: s^2 + 10 s + 15 = 0; of the way that is left, what each exponential has when the force has risen
    const double slow = 5 - std::sqrt(10.0), fast = 5 + std::sqrt(10.0), T = 0.2;
    const double slow_left = fast * -std::expm1(-slow * T) / (slow * T), fast_left = slow * -std::expm1(-fast * T) / (fast * T);
    const double first = slow_left * -std::expm1(-slow) + fast_left * std::expm1(-fast), last = slow_left * std::exp(-2 * slow) * -std::expm1(-0.25 * slow);
    CHECK(left_by_damping(hands[1], 1.5, 3.2) == Catch::Detail::Approx(last / first).epsilon(0.01));
    CHECK(left_by_damping(hands[0], 269, 3.2) == Catch::Detail::Approx(std::exp(-0.2 * 2 / (2 * 0.045))).epsilon(0.2));  // the envelope of its swings
}

TEST_CASE("a hand with mass comes to rest on the tissue, where the tissue's own equilibrium is", "[hand][long]") {
    // a small part of scripts/hand_probe.cpp
    for (const bool relaxes : {false, true}) {
        const TissueModel tissue = relaxes ? relaxing(law_example()) : law_example();
        const LawPress answer(tissue);
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

TEST_CASE("a hand comes to rest also where its positions are up to half of dt old when they are used", "[hand][long]") {
    const TissueModel tissue = law_example();
    const FreeSurface surface(tissue.mesh);
    for (const double scale : {1.0, 2.0})
        for (const double age_s : {3e-4, 5e-4})
            for (const Hand& hand : hands) {
                HapticOptions options = alone(scale);
                options.device.mass_kg = hand.mass_kg;  // or it is refused
                const HapticModel model(tissue, options);
                const Release release = at_the_top(surface);
                const Rest rest = let_go(model, hand, {"old", 0, 0, age_s}, release);
                INFO(hand.name << ", force scale " << scale << ", " << 1e3 * age_s << " ms old: swing " << 1e3 * rest.swing_m << " mm, " << rest.swing_N << " N of " << rest.force_N << " N, controller in "
                               << 100 * rest.controlled << " %");
                REQUIRE(rest.contact);
                CHECK(rest.faults == 0);
                CHECK(rest.swing_m < 1e-4);
                CHECK(rest.swing_N < 0.05 * rest.force_N);
                CHECK(rest.controlled < 0.01);
            }
}

TEST_CASE("who taps, lets go or drags gets no energy out of the tissue, and nothing trembles", "[hand][long]") {
    for (const bool relaxes : {false, true})
        for (const double friction : {std::numeric_limits<double>::infinity(), 0.3}) {
            HapticOptions options = alone();
            options.friction.stick = friction;
            const HapticModel model(relaxes ? relaxing(law_example()) : law_example(), options);
            const FreeSurface surface(model.rest);
            for (const Hand& hand : hands)
                for (const test::Clock& clock : clocks)
                    for (const Deed deed : {Deed::taps, Deed::lets_go, Deed::drags}) {
                        Release release = at_the_top(surface);
                        const Ride ride = does(deed, model, hand, clock, release);
                        INFO(hand.name << ", " << clock.name << (relaxes ? ", relaxing" : "") << ", friction " << friction << ", deed " << static_cast<int>(deed) << ": " << 1e6 * ride.most_given_J
                                       << " uJ given of " << 1e6 * ride.put_in_J << ", tremor " << 1e3 * ride.tremor_m << " mm, controller in " << 100 * ride.controlled << " %");
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

TEST_CASE("a hand that drags a disc ten millimetres comes to rest there and gets no energy, though its contact couples in and across", "[hand][solid][long]") {
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
                               << 1e6 * loop.most_given_J << " uJ given of " << 1e6 * loop.put_in_J << ", controller in " << 100 * loop.controlled(0, 0) << " %");
                CHECK(least_N_m > 0);  // the tissue follows, so that the contact itself stays where its energy is convex
                CHECK_FALSE(lost);
                CHECK(loop.faults == 0);
                CHECK((loop.x - start).dot(along) > 0.7 * drag_m);
                CHECK(swing_m < 1e-4);
                CHECK(loop.most_given_J <= 1e-6 + 0.01 * loop.put_in_J);
                CHECK(loop.controlled(0, 0) < 0.01);
            }
    }
}

TEST_CASE("a tool whose device cannot show the force stays behind the hand, and gives it no energy", "[hand]") {
    HapticOptions options = alone();
    options.map.force_scale = 3;
    TissueModel muscle = law_example();
    muscle.energy_law->constants *= 3.7;
    muscle.energy_law->contact_log_scale = Eigen::VectorXd::Constant(muscle.mesh.node_count(), std::log(3.7));
    for (const bool relaxes : {false, true}) {
        const HapticModel model(relaxes ? relaxing(muscle) : muscle, options);
        const FreeSurface surface(model.rest);
        for (const test::Clock& clock : clocks) {
            const FreeSurface::Place place = surface.nearest(Eigen::Vector2d(0.052, 0.1));
            Release release;
            release.contact_m = place.point_m;
            release.inward = place.inward;
            const Ride ride = does(Deed::taps, model, hands[3], clock, release);
            INFO(clock.name << (relaxes ? ", relaxing: " : ": ") << 1e6 * ride.most_given_J << " uJ given of " << 1e6 * ride.put_in_J << ", controller in " << 100 * ride.controlled << " %");
            CHECK(ride.put_in_J > 5e-3);
            CHECK(ride.passive());
            CHECK(ride.controlled < 0.01);

            HandLoop loop(model, hands[3], clock);  // led in far beyond: no more than the device's limit, and what the tissue gets is that
            loop.lead(place.point_m - 0.003 * place.inward, place.point_m + 0.012 * place.inward, 0.5);
            CHECK(loop.force.norm() == Approx(3.3).epsilon(1e-4));
            CHECK(loop.simulation.record().coupling_N.norm() == Approx(1.1).epsilon(1e-4));
            CHECK(loop.simulation.safety().counters().clamped > 100);
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

TEST_CASE("a hand that rests feels the same at a slow host as at 1 kHz, wherever and however fast it came", "[hand][long]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(law_example(), options);
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
                    CHECK(swing_N < 1.5 * usual[1] + 0.01 * usual[0]);  // what the tissue itself still swings
                    CHECK(mean_N == Approx(usual[0]).epsilon(0.01));
                }
            }
}

TEST_CASE("a tool that has left a dent behind touches the tissue anew, at a slow host too", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(relaxing(law_example()), options);
    const auto aside = [&](double rate_Hz) {  // largest force while the tool goes along the dent's floor, and after it has pressed beside it: along and in
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
    s.tick(sample, 8 * 3600.0);
    CHECK(s.counters().lost_s == Approx(3 + 8 * 3600 - 0.5).margin(0.05));  // but for what may be made up for, and was
}

TEST_CASE("a tissue that is too stiff for a device is refused, with the numbers", "[hand][long]") {
    const TissueModel tissue = law_example();
    HapticOptions options = alone(3);
    const double contact_N_m = HapticModel(tissue, options).meshes[0]->contact_N_m;
    options.device.force_max_N = 2;
    const double lead = HapticModel(tissue, options).meshes[0]->lead;
    DeviceImpedance one;
    one.mass_kg = 1;
    options.device.mass_kg = 0.9 * 3 * contact_N_m / stable_stiffness_N_m(one, 1e-3, lead);
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("force-scale may be 2.70 at most") || Contains("force-scale may be 2.69 at most"));
    options.map.force_scale = 2.69;
    CHECK(HapticModel(tissue, options).options.safety.force_max_N == 2);
    options.dt_s = 2e-3;  // four times as strict
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("a force every 0.002 s"));
    options.dt_s = 1e-3;
    options.map.force_scale = std::numeric_limits<double>::infinity();
    CHECK_THROWS_AS(HapticModel(tissue, options), MismatchError);
    options.map.force_scale = 2.69;
    options.device.stiffness_N_m = 100;
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("the device can show 100 N/m"));
}

TEST_CASE("a contact is stable on a device up to the stiffness that is said, and not far beyond", "[hand][long]") {
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
                std::deque<double> was(late + 3, x);  // at this tick and those before
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
    CHECK(stable_stiffness_N_m(device, dt, 0.5) == 0);  // nothing is left of the contact's damping
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
    DeviceImpedance damped;  // nearly all damping: up to twice its damping over dt, whatever its mass is
    damped.mass_kg = 1e-5;
    damped.damping_Ns_m = 1;
    CHECK(stable_stiffness_N_m(damped, dt, 1) > 0.45 * 0.4 * damped.damping_Ns_m / dt);
}

TEST_CASE("a Touch rests on the tissue up to the force-scale that is said of it, its force one servo period late", "[hand][long]") {
    const TissueModel tissue = law_example();
    const FreeSurface surface(tissue.mesh);
    HapticOptions options = alone(1);
    const HapticModel any(tissue, options);
    const double contact_N_m = any.meshes[0]->contact_N_m, lead = any.meshes[0]->lead;
    options.device = touch_impedance;
    options.device.stiffness_N_m = std::numeric_limits<double>::infinity();  // what it can show at rest is another question
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
                INFO(hand.name << ", " << clock.name << ", force scale " << options.map.force_scale << ", " << force << " N: swing " << 1e3 * rest.swing_m << " mm, of " << 1e3 * rest.damped_m << " that its damping leaves, "
                               << rest.swing_N << " N of " << rest.force_N << " N, controller in " << 100 * rest.controlled << " %");
                REQUIRE(rest.contact);
                CHECK(rest.faults == 0);
                CHECK(rest.swing_m < std::max(1e-4, 1.05 * rest.damped_m));
                CHECK(rest.controlled < 0.01);
            }
}

TEST_CASE("one tick that comes early loses no time to a host whose ticks take half of theirs", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(law_example(), options);
    for (const double early_s : {1e-6, 1e-3}) {
        Simulation s(model);
        DeviceSample sample;
        sample.position_m = led(0.4);
        for (int k = 0; k < 1500; ++k) s.tick(sample, k == 700 ? early_s : 0.01, 0.5 * s.went_s());
        INFO("early by all but " << early_s << " s");
        CHECK(s.counters().lost_s <= 0.03);
    }
}

TEST_CASE("the mesh that loses most says how much time is lost", "[hand]") {
    HapticOptions options;
    const HapticModel model(law_example(), options);
    REQUIRE(model.meshes.size() == 2);
    REQUIRE(model.meshes[0]->substeps != model.meshes[1]->substeps);
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0);
    constexpr double period_s = 1.57e-3;
    constexpr int ticks = 4000;
    for (int k = 0; k < ticks; ++k) s.tick(sample, period_s, 0.95 * s.went_s());
    CHECK(s.counters().lost_s > 0.2 * ticks * period_s);
}

TEST_CASE("a device that measures less often than a session ticks is judged by its own period", "[hand]") {
    const TissueModel tissue = law_example();
    HapticOptions options = alone();
    const HapticModel any(tissue, options);
    const HapticMesh& mesh = *any.meshes[0];
    options.device.mass_kg = 1;
    options.device.mass_kg = 1.5 * mesh.contact_N_m / stable_stiffness_N_m(options.device, options.dt_s, mesh.lead);
    options.device.rate_Hz = 1 / options.dt_s;
    CHECK_NOTHROW(HapticModel(tissue, options));
    options.device.rate_Hz = 4 / options.dt_s;  // no faster than the ticks
    CHECK_NOTHROW(HapticModel(tissue, options));
    options.device.rate_Hz = 0.25 / options.dt_s;
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(tissue, options); }), Contains("a force every 0.004 s"));
    const HapticModel model(tissue, alone());
    Simulation simulation(model);
    CHECK_THAT(refusal<MismatchError>([&] { simulation.change(options); }), Contains("a force every 0.004 s"));
}

TEST_CASE("the force of a tick is that of a hand so far ahead as is said", "[hand]") {
    for (const bool law : {true, false})
        for (const double stiffest : {1.0, 1e6}) {
            // nodes so heavy that they stand still; of a law, with as many steps as it has otherwise
            TissueModel tissue = law ? law_example() : haptic_example();
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
            INFO((law ? "law, " : "springs, ") << mesh.substeps << " steps, lead " << mesh.lead);
            REQUIRE(still.record().coupling_N.norm() > 1e-3);
            CHECK(moving.record().coupling_N.norm() == Approx(still.record().coupling_N.norm()).epsilon(1e-3));
            CHECK((mesh.substeps > 1) == (law && stiffest > 1));
            CHECK(mesh.lead >= Approx(mesh.substeps > 1 ? 0.55 : 0.75));
        }
}

TEST_CASE("a stall while the tool presses leaves the tissue pressed", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = std::numeric_limits<double>::infinity();
    const HapticModel model(law_example(), options);
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

TEST_CASE("a tick of unknown length is as late as the device holds a force", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 0.2;
    const HapticModel model(law_example(), options);
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0);
    s.tick(sample);
    s.tick(sample, -1);
    CHECK(s.record().time_s == Approx(0.201));
}

TEST_CASE("a reset takes the force away at once", "[hand]") {
    const HapticModel model(law_example(), alone());
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

TEST_CASE("no time is lost to a host that is slower than the device's step", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    options.dt_s = 1e-3;
    for (const double rate_Hz : {50.0, 60.0}) {
        const HapticModel model(law_example(), options);
        Simulation s(model);
        DeviceSample sample;
        sample.position_m = led(0);
        for (int k = 0; k < 4 * rate_Hz; ++k) s.tick(sample, 1 / rate_Hz);
        CHECK(s.counters().lost_s == 0);
        CHECK(s.record().time_s == Approx(4));
    }
}

namespace {

/// A host whose tick takes so long a share of the time that the tissue goes through in it. The next one comes at once when it is due, or, as the loop has it, with the next period.
struct Host {
    Simulation& s;
    double period_s, share;
    bool by_schedule;
    double elapsed_s = period_s, cost_s = 0, time_s = 0, went_s = 0;

    void tick(double stall_s = 0) {
        DeviceSample sample;
        sample.position_m = led(0.4);
        s.tick(sample, elapsed_s, cost_s);
        time_s += elapsed_s;
        went_s += s.went_s();
        cost_s = share * s.went_s();
        const double busy_s = cost_s + stall_s;
        elapsed_s = by_schedule ? period_s * std::max(1.0, std::ceil(busy_s / period_s - 1e-9)) : std::max(period_s, busy_s);
    }
};

}  // namespace

TEST_CASE("ticks that cost more than their time stay short, and the time that the tissue loses is told", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(law_example(), options);
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
                                     << host.time_s << " s, went " << host.went_s << " s");
                CHECK(longest_s < std::max(1.01 * share, by_schedule ? 0.91 * std::ceil(share) : 0) * 1e-3);  // that of 1 ms, or of the periods that it takes
                CHECK(s.counters().lost_s == Approx(host.time_s - host.went_s).margin(0.005));
                if (share > 1) CHECK(s.counters().lost_s > 0.02 * host.time_s);
                CHECK(s.record().time_s == Approx(host.time_s));
            }
}

TEST_CASE("a host that is slow by its own choice loses no time, nor does one that stalls", "[hand][long]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(law_example(), options);
    for (const double share : {0.05, 0.4, 0.5, 0.7, 0.89})
        for (const double period_s : {1e-3, 0.01, 0.02})
            for (const bool by_schedule : {true, false}) {
                Simulation s(model);
                Host host{s, period_s, share, by_schedule};
                for (int k = 0; k < 1000; ++k) host.tick(k == 500 ? 0.03 : 0);
                INFO(period_s << " s, a tick costs " << share << " of its time" << (by_schedule ? ", by a schedule" : ""));
                CHECK(s.counters().lost_s <= (share < 0.45 ? 0 : 0.03 + 2 * period_s));  // where ticks cost half of their time neither the stall nor what a start owes is made up for
                CHECK(host.went_s + s.counters().lost_s == Approx(host.time_s).margin(0.03));
                CHECK(host.cost_s == Approx(share * period_s).epsilon(0.2));
            }
}

TEST_CASE("a host whose ticks take over half of a period that is no multiple of their steps, or strays, loses no time", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    for (const TissueModel& tissue : {haptic_example(), law_example()}) {
        const HapticModel model(tissue, options);
        for (const double rate_Hz : {300.0, 700.0, 970.0})
            for (const double share : {0.5, 0.6, 0.8}) {
                Simulation s(model);
                Host host{s, 1 / rate_Hz, share, false};
                for (int k = 0; k < 3 * rate_Hz; ++k) host.tick();
                INFO(rate_Hz << " Hz, a tick costs " << share << " of its time, " << model.meshes[0]->substeps << " steps: went " << host.went_s << " of " << host.time_s << " s");
                CHECK(s.counters().lost_s <= 2 / rate_Hz);
                CHECK(host.went_s == Approx(host.time_s).epsilon(0.005));
            }
        Simulation s(model);
        Draw draw(2008);
        DeviceSample sample;
        sample.position_m = led(0.4);
        constexpr double period_s = 5e-3, strays_s = 1e-4;
        double offset_s = 0;
        for (int k = 0; k < 3000; ++k) {
            const double next_s = draw(-strays_s, strays_s);
            s.tick(sample, period_s + next_s - std::exchange(offset_s, next_s), 0.7 * s.went_s());
        }
        INFO("strays, " << model.meshes[0]->substeps << " steps");
        CHECK(s.counters().lost_s < 0.003 * 3000 * period_s);
    }
}

TEST_CASE("a host that becomes slow loses no time where its device holds the force, and one that stalls is none", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = std::numeric_limits<double>::infinity();
    const HapticModel model(law_example(), options);
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0.4);
    double time_s = 0, went_s = 0;
    const auto ticks = [&](int count, double elapsed_s) {
        for (int k = 0; k < count; ++k) {
            s.tick(sample, elapsed_s);
            time_s += elapsed_s;
            went_s += s.went_s();
        }
    };
    ticks(1000, 1e-3);
    for (int k = 0; k < 10; ++k) {
        ticks(1, 0.06);
        ticks(50, 1e-3);
    }
    CHECK(s.went_s() <= 1.1e-3);  // what the hand does is not guessed farther ahead after stalls
    CHECK(went_s == Approx(time_s).margin(2e-3));
    ticks(200, 0.05);
    CHECK(s.counters().lost_s == 0);
    CHECK(went_s == Approx(time_s).margin(0.06));
    ticks(1000, 1e-3);
    CHECK(went_s == Approx(time_s).margin(3e-3));
}

TEST_CASE("a tick that was interrupted once is made up for", "[hand]") {
    HapticOptions options = alone();
    options.safety.hold_s = 1;
    const HapticModel model(law_example(), options);
    Simulation s(model);
    DeviceSample sample;
    sample.position_m = led(0.4);
    double went_s = 0, time_s = 0;
    for (int k = 0; k < 200; ++k) {
        const double elapsed_s = k == 100 ? 0.03 : 1e-3;
        s.tick(sample, elapsed_s, k == 100 ? 0.0299 : 1e-4);
        went_s += s.went_s();
        time_s += elapsed_s;
    }
    CHECK(s.counters().lost_s == 0);
    CHECK(went_s == Approx(time_s).margin(2e-3));
}

TEST_CASE("the energy log has what a late hand is given by its true motion", "[hand][long]") {
    for (const double late_s : {3e-4, 1e-3, 0.0104, 0.03})
        for (const double jitter_s : {0.0, 3e-4}) {
            HapticOptions options = alone(2);
            options.safety.passivity = false;  // the log alone, whatever it is
            const HapticModel model(law_example(), options);
            Simulation s(model);
            Draw draw(2008);
            const double dt = options.dt_s;
            const auto hand = [&](double time) { return Eigen::Vector3d(0.052, 0.096 + 0.003 * std::cos(2 * 3.14159265 * 5 * time) + 0.006 * std::clamp(1 - time / 0.1, 0.0, 1.0), 0); };
            double given_J = 0, most_J = 0;
            std::vector<double> given_by;  // at each tick
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

TEST_CASE("springs with several steps a tick press alike at any rate, and at one that changes", "[hand]") {
    for (const double stiffer : {1.0, 8.0, 300.0}) {
        ExampleModel example;
        example.spread = 0;  // which of two sets is nearest may differ at a rate of its own
        example.stiffer = stiffer;
        HapticOptions options = alone(20);
        options.dynamics = "symplectic";
        options.safety.hold_s = 1;
        const HapticModel model(haptic_example(example), options);
        const HapticMesh& mesh = *model.meshes[0];
        REQUIRE(mesh.substeps > 1);
        REQUIRE(mesh.contact_damping_s == contact_damping_s(1e-3, mesh.substeps));  // however many steps that takes
        const std::vector<double> usual = held_force(model, 1000);
        constexpr std::size_t after_landing = 25;
        INFO(mesh.substeps << " steps a tick, lead " << mesh.lead);
        for (const double rate_Hz : {250.0, 500.0, 4000.0, 8000.0}) {
            INFO(rate_Hz << " Hz");
            CHECK(largest_difference(usual, held_force(model, rate_Hz), after_landing) < 0.02);
        }
        // the rate changes while it presses
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

TEST_CASE("a place that slides is not damped by that, at any rate", "[hand]") {
    HapticOptions options = alone();
    options.friction.stick = 0.3;
    const HapticModel model(law_example(), options);
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
    REQUIRE(std::abs(usual.x()) > 0.2 * std::abs(usual.y()));  // it slips
    for (const double rate_Hz : {250.0, 4000.0, 8000.0}) CHECK((dragged(rate_Hz) - usual).norm() < 0.01 * usual.norm());
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
