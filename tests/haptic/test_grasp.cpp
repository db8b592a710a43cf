// A tool that grasps: a bilateral contact without slip, which lifts and drags the tissue until it lets go.
#include <catch2/catch.hpp>
#include <cmath>

#include "../allocations.h"
#include "../example.h"
#include "../refusal.h"
#include "../springs/several_discs.h"
#include "graspable.h"
#include "hand.h"
#include "haptic/virtual_device.h"
#include "haptic_example.h"
#include "springs/energy_model_at_radius.h"
#include "springs/indentation_solver.h"

using namespace tissue;
using namespace tissue::test;
using Catch::Matchers::Contains;

namespace {

const Eigen::Vector3d place(0.043, 0.056, 0.05), inward(0, 0, -1);

HapticOptions one_mesh(double friction = std::numeric_limits<double>::infinity()) {
    HapticOptions options;
    options.heuristic_mesh = false;
    options.friction.stick = friction;
    options.safety.force_max_N = 100;
    options.safety.slew_N_s = 1e6;
    options.safety.hold_s = 0.05;
    return options;
}

/// Touches a place, and grasps it.
void take(Led& hand, const Eigen::Vector3d& contact_m, double depth_m = 5e-4) {
    hand.lead(contact_m + depth_m * inward);
    hand.grasp = true;
    hand.wait(0.1);
}

Eigen::Vector3d above(const Eigen::Vector3d& at) { return at - 0.005 * inward; }

}  // namespace

TEST_CASE("a tool that grasps lifts the tissue to the equilibrium of the energy model at any rate of ticks", "[grasp][long]") {
    const TissueModel tissue = graspable_solid();
    const HapticModel model(tissue, one_mesh());
    const IndentationSolver solver(tissue);
    for (const double rate_Hz : {1000.0, 4000.0, 100.0}) {
        Led hand(model, above(place), 1 / rate_Hz);
        take(hand, place);
        for (const Eigen::Vector3d& pull : {Eigen::Vector3d(-0.006 * inward), Eigen::Vector3d(0.003, -0.002, 0.005)}) {
            hand.lead(place + pull);
            hand.wait(3);
            const TickRecord& r = hand.simulation.record();
            INFO(rate_Hz << " Hz, " << pull.transpose() << " m");
            REQUIRE(r.mesh == 0);
            CHECK(r.grasped);
            CHECK(r.status == TickStatus::done);
            const Point touched_m = model.meshes[0]->springs.rest_place(r.facet, r.weight);
            const Equilibrium rest = solver.at(touched_m, r.contact_displacement_m);
            REQUIRE(rest);
            CHECK((r.contact_displacement_m - (place + pull - touched_m)).norm() < 1e-9);
            CHECK((r.coupling_N + rest.contact_force).norm() < 0.01 * rest.contact_force.norm());
            CHECK(hand.force_N.dot(pull) < -0.9 * hand.force_N.norm() * pull.norm());
        }
    }
}

TEST_CASE("a tool without a grasp leaves the tissue and a grasp that goes off drops it", "[grasp]") {
    const HapticModel model(graspable_solid(), one_mesh());
    Led hand(model, above(place));
    hand.lead(place + 5e-4 * inward);
    hand.lead(place - 0.004 * inward);
    CHECK(hand.simulation.record().mesh == -1);
    CHECK(hand.force_N.isZero(0));

    take(hand, place);
    hand.lead(place - 0.004 * inward);
    hand.wait(0.3);
    REQUIRE(hand.force_N.norm() > 0.01);
    hand.grasp = false;
    hand.tick(hand.at);
    CHECK(hand.force_N.isZero(0));
    CHECK(hand.simulation.record().mesh == -1);
    hand.wait(1);
    CHECK(hand.force_N.isZero(0));
    CHECK(hand.simulation.let_go() == 0);
    // inside the tissue the contact goes on as any other
    take(hand, place);
    hand.lead(place + 0.003 * inward);
    hand.wait(0.5);
    const Eigen::Vector3d held_N = hand.force_N;
    hand.grasp = false;
    hand.wait(0.5);
    CHECK((hand.force_N - held_N).norm() < 0.01 * held_N.norm());
}

TEST_CASE("a grasp lets go above its limit and begins again only when it has been off", "[grasp]") {
    HapticOptions options = one_mesh();
    options.grasp_max_N = 0.1;
    const HapticModel model(graspable_solid(), options);
    Led hand(model, above(place));
    take(hand, place);
    double most_N = 0;
    for (int k = 0; k < 1000 && hand.simulation.grasps(); ++k) {
        hand.tick(hand.at - 1e-5 * inward);
        most_N = std::max(most_N, hand.simulation.record().coupling_N.norm());
    }
    CHECK(!hand.simulation.grasps());
    CHECK(most_N > 0.1);
    CHECK(most_N < 0.105);
    CHECK(hand.simulation.let_go() == 1);
    hand.tick(hand.at);
    CHECK(hand.force_N.isZero(0));
    hand.lead(above(place));
    hand.lead(place + 5e-4 * inward);  // still on: it presses, and holds nothing
    hand.wait(0.2);
    CHECK(hand.simulation.record().mesh == 0);
    CHECK(!hand.simulation.grasps());
    hand.grasp = false;
    hand.wait(0.01);
    take(hand, place);
    CHECK(hand.simulation.grasps());
    HapticOptions other = hand.simulation.options();
    other.grasp_max_N = 1;
    hand.simulation.change(other);
    hand.lead(place - 0.004 * inward);
    CHECK(hand.simulation.grasps());
}

TEST_CASE("a grasp in the air takes nothing, and neither does one of a ball", "[grasp]") {
    const HapticModel model(graspable_solid(), one_mesh());
    Led hand(model, above(place));
    hand.grasp = true;
    hand.lead(place + 0.002 * inward);
    CHECK(hand.simulation.record().mesh == 0);
    CHECK(hand.simulation.record().grasp);
    CHECK(!hand.simulation.grasps());
    hand.lead(above(place));
    CHECK(hand.simulation.record().mesh == -1);
    // the button goes down in the tick in which the tool has left the tissue
    hand.grasp = false;
    hand.lead(place + 0.001 * inward);
    REQUIRE(hand.simulation.record().mesh == 0);
    hand.grasp = true;
    hand.tick(place - 0.0009 * inward);
    CHECK(!hand.simulation.grasps());

    // nor where the contact was not trained to be pulled
    const HapticModel pressed(solid_example(), one_mesh());
    CHECK(!pressed.grasps());
    Led third(pressed, above(place));
    take(third, place);
    CHECK(!third.simulation.grasps());
    HapticOptions limited = one_mesh();
    limited.grasp_max_N = 1;
    CHECK_THROWS_WITH(HapticModel(solid_example(), limited), Contains("cannot grasp"));
    CHECK_THROWS_WITH(third.simulation.change(limited), Contains("cannot grasp"));

    HapticOptions with_ball = one_mesh();
    with_ball.tool = {{ToolChoice::Shape::ball, 0.008}};
    TissueModel pulled = several_discs();
    for (std::string& term : pulled.energy_model->terms)
        if (term == "contact.hardening.size") term = "contact.compression.size";
    pulled.energy_model->patch.curve = ContactCurve::compression;
    CHECK(HapticModel(pulled, one_mesh()).grasps());
    const HapticModel ball(pulled, with_ball);
    const Eigen::Vector3d top(0.021, 0.033, 0.02);
    Led other(ball, above(top));
    take(other, top, 0.002);
    CHECK(!other.simulation.grasps());
    CHECK(other.simulation.record().mesh == 0);
}

TEST_CASE("tissue that is grasped does not slip from a tool with little friction", "[grasp]") {
    const HapticModel model(graspable_solid(), one_mesh(0.1));
    Led hand(model, above(place));
    take(hand, place, 0.002);
    const int facet = hand.simulation.record().facet;
    const Eigen::Vector3d weight = hand.simulation.record().weight;
    const double before_J = hand.simulation.friction().dissipated_J();
    hand.lead(place + 0.002 * inward + Eigen::Vector3d(0.004, 0, 0));
    hand.wait(0.5);
    CHECK(hand.simulation.record().facet == facet);
    CHECK(hand.simulation.record().weight == weight);
    CHECK(!hand.simulation.record().slipping);
    const Eigen::Vector3d f = hand.force_N;
    CHECK(-f.x() > 0.3 * std::abs(f.z()));
    CHECK(hand.simulation.friction().dissipated_J() == before_J);
    hand.grasp = false;
    hand.wait(0.5);
    CHECK(std::hypot(hand.force_N.x(), hand.force_N.y()) < 0.11 * hand.force_N.z());
    CHECK(hand.simulation.friction().dissipated_J() > before_J);
}

TEST_CASE("a hand that grasps and goes round gets no energy out of the tissue", "[grasp]") {
    for (const bool relaxes : {false, true}) {
        const TissueModel tissue = relaxes ? relaxing(energy_model_example()) : energy_model_example();
        const HapticModel model(tissue, one_mesh());
        const Eigen::Vector3d top(0.045, 0.1, 0), down(0, -1, 0);
        Led hand(model, top - 0.005 * down);
        hand.lead(top + 0.001 * down);
        hand.grasp = true;
        hand.wait(0.05);
        REQUIRE(hand.simulation.grasps());
        double most_given_J = 0;
        for (int round = 0; round < 6; ++round)
            for (const Eigen::Vector3d& to : {Eigen::Vector3d(0.003, 0.004, 0), Eigen::Vector3d(-0.003, 0.005, 0), Eigen::Vector3d(-0.002, -0.004, 0), Eigen::Vector3d(0.002, -0.003, 0)}) {
                hand.lead(top + to, 0.2);
                most_given_J = std::max(most_given_J, -hand.work_J);
            }
        hand.lead(top + 0.001 * down);
        hand.grasp = false;
        hand.lead(top - 0.005 * down);
        INFO((relaxes ? "relaxing" : "elastic") << ": given at most " << most_given_J << " J, in all " << -hand.work_J << " J");
        CHECK(most_given_J < 1e-9);
        CHECK(hand.work_J > 0);
    }
}

TEST_CASE("a grasp lets go where the force on the tissue is limited by the device and after a late tick", "[grasp]") {
    HapticOptions options = one_mesh();
    options.safety.force_max_N = 0.2;
    options.grasp_max_N = 1;
    const HapticModel model(graspable_solid(), options);
    Led hand(model, above(place));
    take(hand, place);
    for (int k = 0; k < 2000 && hand.simulation.grasps(); ++k) hand.tick(hand.at - 1e-5 * inward);
    CHECK(hand.simulation.let_go() == 1);

    const HapticModel free(graspable_solid(), one_mesh());
    Led other(free, above(place));
    take(other, place);
    REQUIRE(other.simulation.grasps());
    DeviceSample sample;
    sample.position_m = place - 0.02 * inward;
    sample.grasp = true;
    const Eigen::Vector3d late_N = other.simulation.tick(sample, 0.4);
    INFO(late_N.transpose() << " N; contact " << other.simulation.contact().contact << " pressing " << other.simulation.contact().pressing << " late " << other.simulation.record().late << " coupling " << other.simulation.record().coupling_N.transpose());
    CHECK(other.simulation.record().coupling_N.isZero(0));  // the passivity controller may still slow the hand
    CHECK(!other.simulation.grasps());
    CHECK(other.simulation.let_go() == 0);
}

TEST_CASE("a grasp outlasts a pause in which the hand stands still and no other", "[grasp]") {
    const HapticModel model(graspable_solid(), one_mesh());
    for (const double moved_m : {0.0, 0.002}) {
        Led hand(model, above(place));
        take(hand, place);
        DeviceSample sample;
        sample.position_m = hand.at - moved_m * inward;
        sample.grasp = true;
        CHECK(hand.simulation.skip_tick(sample, 1e-3).isZero(0));
        CHECK(hand.simulation.grasps() == (moved_m == 0));
        sample.position_m = hand.at;
        sample.grasp = false;  // the button goes up in a pause
        hand.simulation.skip_tick(sample, 1e-3);
        CHECK(!hand.simulation.grasps());
    }
}

TEST_CASE("the force on grasped tissue stays within the limit however far the hand goes", "[grasp]") {
    HapticOptions options = one_mesh();
    options.safety.force_max_N = 0.3;
    const HapticModel model(graspable_solid(), options);
    for (const Eigen::Vector3d& way : {Eigen::Vector3d(0.2, 0, 0.02), Eigen::Vector3d(0.1, 0.1, 0.15), Eigen::Vector3d(0, 0, 0.3)}) {
        Led hand(model, above(place));
        take(hand, place);
        const Eigen::Vector3d from = hand.at;
        for (int k = 1; k <= 300; ++k) {
            hand.tick(from + k / 300.0 * way);
            REQUIRE(hand.simulation.record().coupling_N.norm() < 0.3 * 1.01);
        }
        CHECK(hand.simulation.grasps());
        CHECK(hand.simulation.counters().unstable == 0);
        CHECK(hand.force_N.dot(way) < 0);
    }
}

TEST_CASE("a hand with mass that hangs on grasped tissue comes to rest", "[grasp][long]") {
    const TissueModel tissue = graspable_solid();
    const HapticModel model(tissue, one_mesh());
    const IndentationSolver solver(tissue);
    for (const Hand& device : {hands[0], hands[1], hands[3]}) {
        Led led(model, above(place));
        take(led, place);
        // 20 integration steps a tick, pulled out by a constant force
        Eigen::Vector3d x = led.at, v = Eigen::Vector3d::Zero();
        const Eigen::Vector3d pull_N = -0.2 * inward;
        double lowest = 1, highest = 0;
        for (int k = 0; k < 6000; ++k) {
            for (int i = 0; i < 20; ++i) {
                v += 5e-5 / device.mass_kg * (pull_N + led.force_N - device.damping_Ns_m * v - device.stiffness_N_m * (x - place));
                x += 5e-5 * v;
            }
            led.tick(x);
            if (k > 5000) lowest = std::min(lowest, x.z()), highest = std::max(highest, x.z());
        }
        const TickRecord& r = led.simulation.record();
        INFO(device.name << ": swings by " << 1e3 * (highest - lowest) << " mm");
        REQUIRE(led.simulation.grasps());
        CHECK(highest - lowest < 1e-4);
        CHECK(x.z() > place.z());
        const Equilibrium rest = solver.at(model.meshes[0]->springs.rest_place(r.facet, r.weight), r.contact_displacement_m);
        REQUIRE(rest);
        CHECK((r.coupling_N + rest.contact_force).norm() < 0.02 * rest.contact_force.norm());
    }
}

TEST_CASE("a grasp is part of a session's value, and no other model takes over meanwhile", "[grasp][state]") {
    const HapticModel model(graspable_solid(), one_mesh());
    Led hand(model, above(place));
    take(hand, place);
    hand.lead(place - 0.003 * inward);
    std::vector<std::byte> state(hand.simulation.state_size());
    hand.simulation.save(state.data());
    Simulation other(model);
    other.restore(state.data(), state.size());
    CHECK(other.grasps());
    DeviceSample sample;
    sample.position_m = hand.at;
    sample.grasp = true;
    for (int k = 0; k < 50; ++k) REQUIRE(other.tick(sample, 1e-3) == hand.simulation.tick(sample, 1e-3));

    Simulation next(model);
    CHECK_THROWS_WITH(next.follow(hand.simulation), Contains("grasps"));
    sample.grasp = false;
    hand.simulation.tick(sample, 1e-3);
    Simulation free(model);
    CHECK_NOTHROW(free.follow(hand.simulation));
    HapticOptions limited = hand.simulation.options();
    limited.grasp_max_N = 0.7;
    hand.simulation.change(limited);
    free.take_over(hand.simulation);  // with the limit that was changed after follow()
    CHECK(free.options().grasp_max_N == 0.7);
    const HapticModel other_model(solid_example(), one_mesh());
    Simulation cannot(other_model);
    cannot.follow(hand.simulation);  // a model that cannot grasp has no limit
    CHECK(std::isinf(cannot.options().grasp_max_N));
    // by the session's own call, and ended by a fault
    hand.grasp = false;
    hand.lead(above(place));
    hand.lead(place + 5e-4 * inward);
    hand.simulation.grasp(true);
    hand.wait(0.01);
    CHECK(hand.simulation.grasps());
    {
        const Allocations counted;
        hand.wait(0.1);
    }
    CHECK(Allocations::count() == 0);
    sample.position_m.x() = std::nan("");
    hand.simulation.tick(sample, 1e-3);
    CHECK(!hand.simulation.grasps());
}

TEST_CASE("the scripted motion pull lifts the top of a solid and lets it go", "[grasp][device]") {
    const TissueModel tissue = graspable_solid();
    const HapticModel model(tissue, one_mesh());
    Simulation s(model);
    MotionOptions motion;
    motion.name = "pull";
    motion.depth_m = 0.006;
    motion.rest = &tissue.mesh;
    motion.seconds = 3;
    VirtualDevice device(make_motion(motion), model.options.map);
    double highest_m = 0, pulled_N = 0;
    bool held = false, dropped = false;
    for (int k = 0; k < 3200; ++k) {
        const DeviceSample sample = device.read(1e-3 * k);
        const Eigen::Vector3d force_N = s.tick(sample, 1e-3);
        held = held || s.grasps();
        if (s.grasps()) {
            highest_m = std::max(highest_m, sample.position_m.z() - 0.05);
            pulled_N = std::max(pulled_N, -force_N.z());
        }
        dropped = dropped || (held && !s.grasps() && force_N.isZero(0));
    }
    CHECK(highest_m == Approx(0.006).margin(1e-5));
    CHECK(pulled_N > 0.05);
    CHECK(dropped);
}
