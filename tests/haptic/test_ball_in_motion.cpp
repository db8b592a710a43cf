// A rigid ball in the tick: static equilibrium as BallIndentation has it, energy, and saving and copying of sessions.
#include <catch2/catch.hpp>
#include <cmath>

#include "../allocations.h"
#include "../refusal.h"
#include "../springs/several_discs.h"
#include "adapt/adaptation.h"
#include "error.h"
#include "hand.h"
#include "haptic/learner.h"
#include "springs/ball_indentation.h"
#include "springs/energy_model_at_radius.h"

using namespace tissue;
using namespace tissue::test;
using Catch::Matchers::Contains;

namespace {

const Eigen::Vector3d place(0.021, 0.033, 0.02), inward(0, 0, -1);

/// Options without a second mesh.
HapticOptions with_ball(double radius_m) {
    HapticOptions options;
    options.heuristic_mesh = false;
    options.tool = {{ToolChoice::Shape::ball, radius_m}};
    options.safety.force_max_N = 100;
    options.safety.slew_N_s = 1e6;
    return options;
}

struct Ball {
    HapticOptions options;
    TissueModel own = several_discs(), tissue;
    HapticModel model;
    explicit Ball(double radius_m, const HapticOptions& given) : options(given), tissue(with_tool(own, options.tool[0])), model(own, options) { REQUIRE(model.tools[0].radius_m == radius_m); }
    explicit Ball(double radius_m) : Ball(radius_m, with_ball(radius_m)) {}
};

}  // namespace

TEST_CASE("a ball in the tick settles at the force and displacement of its static equilibrium along normal and oblique indentations", "[solid][simulation]") {
    for (const double radius_m : {0.005, 0.010}) {
        const Ball ball(radius_m);
        const BallIndentation answer(ball.own.mesh, *ball.own.energy_model, radius_m);
        for (const Eigen::Vector3d& way : {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.36, 0.48, -0.8)})
            // Depths avoid the contact radii at which the correction has a kink: the static solution differentiates it
            // over 2 %.
            for (const double depth : {0.05, 0.25, 0.6}) {
                Led hand(ball.model, place - 0.002 * way);
                hand.lead(place - 0.0001 * way);
                hand.lead(place + depth * radius_m * way, 0.001);
                hand.wait(3);
                const TickRecord& r = hand.simulation.record();
                REQUIRE(r.mesh == 0);
                const Equilibrium rest = answer.at(ball.model.meshes[0]->springs.rest_place(r.facet, r.weight), hand.simulation.displacement_at_contact(0));
                INFO("ball of " << radius_m << " m, " << depth << " radii deep along " << way.transpose() << ": " << rest.contact_force.norm() << " N");
                REQUIRE(rest);
                CHECK((r.coupling_N + rest.contact_force).norm() < 3e-3 * rest.contact_force.norm());
                NodeColumns seen;
                hand.simulation.displayed(0, seen);
                CHECK((NodeField(seen) - rest.displacement).norm() < 1e-2 * rest.displacement.norm());
            }
    }
}

TEST_CASE("the force of a ball rises without jumps to a depth of 1.6 radii and vanishes after withdrawal", "[solid][simulation]") {
    const Ball ball(0.005);
    Led hand(ball.model, place - 0.002 * inward);
    double before = 0, least = 1, largest = 0;
    for (int k = 1; k <= 32; ++k) {  // to 1.6 R
        hand.lead(place + 0.25e-3 * k * inward);
        hand.wait(1);
        const double now = hand.force_N.norm();
        if (k > 4) least = std::min(least, now / before - 1), largest = std::max(largest, now / before - 1);
        before = now;
    }
    CHECK(least > 0.01);
    CHECK(largest < 0.42);  // d^1.5 from 1 to 1.25 mm: 0.40
    hand.lead(place - 0.002 * inward);
    hand.wait(0.1);
    CHECK(hand.force_N.norm() == 0);
    CHECK(hand.simulation.record().mesh == -1);
}

TEST_CASE("a cycle of indentation and drag with a ball takes net work from the hand with and without slip", "[solid][simulation]") {
    for (const double friction : {std::numeric_limits<double>::infinity(), 0.3}) {
        HapticOptions options = with_ball(0.010);
        options.friction.stick = friction;
        const Ball ball(0.010, options);
        for (const double across_m : {0.0, 0.004, 0.012}) {
            Led hand(ball.model, place - 0.001 * inward);
            const Eigen::Vector3d across(across_m, 0, 0);
            double in_J = 0;
            for (int round = 0; round < 3; ++round) {
                const double before_J = hand.work_J;
                hand.lead(place + 0.004 * inward, 0.05);
                in_J = hand.work_J - before_J;
                hand.lead(place + 0.004 * inward + across, 0.05);
                hand.lead(place - 0.001 * inward + across, 0.05);
                hand.lead(place - 0.001 * inward, 0.05);
                INFO("friction " << friction << ", across " << across_m << ", round " << round << ": " << in_J << " J to the depth, " << hand.work_J - before_J << " J in the cycle");
                CHECK(hand.work_J - before_J > 0);
                if (across_m == 0) CHECK(hand.work_J - before_J < 0.25 * in_J);  // without a drag only damping is lost
            }
            CHECK(hand.simulation.safety().counters().damped == 0);
            if (std::isinf(friction)) CHECK(hand.simulation.friction().dissipated_J() == 0);
            if (friction < 1 && across_m > 0) CHECK(hand.simulation.friction().dissipated_J() > 0);
            CHECK(hand.simulation.friction().dissipated_J() <= hand.work_J);
        }
    }
}

TEST_CASE("the rest force of a ball is independent of the host rate and cycles from 50 Hz on give no energy", "[solid][simulation]") {
    HapticOptions options = with_ball(0.010);
    options.safety.hold_s = std::numeric_limits<double>::infinity();
    const Ball ball(0.010, options);
    const Eigen::Vector3d way(0.36, 0.48, -0.8);
    const auto rest = [&](double rate_Hz) {
        Led hand(ball.model, place - 0.005 * way, 1 / rate_Hz);
        hand.lead(place + 0.005 * way, 0.05);
        hand.wait(3);
        const Eigen::Vector3d force = hand.force_N;
        const double in_J = hand.work_J;
        hand.lead(place - 0.005 * way, 0.05);
        hand.wait(10 / rate_Hz);
        INFO(rate_Hz << " Hz: " << hand.work_J << " J in the cycle");
        CHECK(hand.force_N.norm() == 0);
        // at 20 Hz the hand moves 2.5 mm per tick, and the tissue stiffens meanwhile
        CHECK(hand.work_J > (rate_Hz < 50 ? -0.01 * in_J : 0));
        return force;
    };
    const Eigen::Vector3d usual = rest(1000);
    for (const double rate_Hz : {20.0, 50.0, 100.0, 4000.0}) {
        INFO(rate_Hz << " Hz");
        CHECK((rest(rate_Hz) - usual).norm() < (rate_Hz < 50 ? 0.03 : 0.01) * usual.norm());
    }
}

TEST_CASE("a ball driven deeper by a slow host stays in contact at the device's force limit", "[solid][simulation]") {
    for (const double force_max_N : {0.1, 0.3})
        for (const double rate_Hz : {20.0, 50.0}) {
            HapticOptions options = with_ball(0.010);
            options.safety.hold_s = std::numeric_limits<double>::infinity();
            options.safety.force_max_N = force_max_N;
            const Ball ball(0.010, options);
            Led hand(ball.model, place - 0.005 * inward, 1 / rate_Hz);
            hand.lead(place + 0.010 * inward, 0.1);
            hand.wait(20 / rate_Hz);
            for (int k = 0; k < 50; ++k) {
                hand.tick(hand.at);
                INFO(force_max_N << " N, " << rate_Hz << " Hz, tick " << k);
                REQUIRE(hand.simulation.record().mesh == 0);
                REQUIRE(hand.force_N.norm() == Approx(force_max_N).epsilon(1e-3));
            }
        }
}

TEST_CASE("a hand with mass comes to rest at the static equilibrium of a ball", "[solid][hand][long]") {
    const Ball ball(0.010);
    const BallIndentation answer(ball.own.mesh, *ball.own.energy_model, 0.010);
    for (const Hand& hand : hands)
        for (const test::Clock& clock : clocks) {
            Release release;
            release.contact_m = place;
            release.inward = inward;
            release.force_N = 0.5 + 0.003 * hand.stiffness_N_m;
            const Rest rest = let_go(ball.model, hand, clock, release);
            INFO(hand.name << ", " << clock.name << ": swing " << 1e3 * rest.swing_m << " mm (the hand's damping alone leaves " << 1e3 * rest.damped_m << "), " << rest.swing_N << " N of " << rest.force_N << " N");
            REQUIRE(rest.contact);
            CHECK(rest.faults == 0);
            CHECK(rest.swing_m < std::max(1e-4, rest.damped_m));
            CHECK(rest.controlled < 0.01);
            const Equilibrium exact = answer.at(rest.touched_m, rest.push_m);
            REQUIRE(exact);
            CHECK(exact.contact_force.norm() == Approx(rest.force_N).epsilon(0.02));
        }
}

TEST_CASE("a copied session with a ball continues bit for bit and its ticks allocate nothing", "[solid][simulation]") {
    for (const double force_max_N : {100.0, 0.1}) {
        HapticOptions options = with_ball(0.010);
        options.safety.force_max_N = force_max_N;
        options.friction.stick = 0.3;
        const Ball ball(0.010, options);
        Led hand(ball.model, place - 0.002 * inward);
        hand.lead(place + 0.003 * inward);
        REQUIRE(hand.simulation.held_back() == (force_max_N < 1));
        Simulation copy(hand.simulation);
        CHECK(copy.tool().growth().radius_m == hand.simulation.tool().growth().radius_m);
        CHECK(copy.displacement_at_contact(0) == hand.simulation.displacement_at_contact(0));
        long allocations = 0;
        double largest_m = 0;
        for (int k = 0; k < 400; ++k) {
            DeviceSample sample;
            sample.position_m = place + (0.003 + 2e-3 * std::sin(0.02 * k)) * inward + Eigen::Vector3d(0.004 * std::sin(0.01 * k), 0, 0);
            Eigen::Vector3d one, other;
            {
                const Allocations none;
                one = hand.simulation.tick(sample);
                allocations += Allocations::count();
            }
            other = copy.tick(sample);
            REQUIRE(one == other);
            largest_m = std::max(largest_m, hand.simulation.tool().growth().radius_m);
        }
        CHECK(allocations == 0);
        if (force_max_N > 1) CHECK(largest_m > 0.006);
        if (force_max_N < 1) CHECK(hand.simulation.record().coupling_N.norm() < 1.001 * force_max_N);
        // After withdrawal the session and its copy save equal bytes.
        hand.lead(place - 0.002 * inward);
        hand.wait(0.2);
        CHECK(hand.simulation.record().mesh == -1);
        std::vector<std::byte> one(hand.simulation.state_size()), other(one.size());
        hand.simulation.save(one.data());
        Simulation(hand.simulation).save(other.data());
        CHECK(one == other);
    }
}

TEST_CASE("a ball at the force limit slides without energy gain and with contact radius changes below 5 % per tick", "[solid][simulation]") {
    HapticOptions options = with_ball(0.010);
    options.safety.force_max_N = 0.2;
    options.friction.stick = 0.3;
    const Ball ball(0.010, options);
    Led hand(ball.model, place - 0.001 * inward);
    hand.lead(place + 0.006 * inward);
    hand.wait(0.3);
    REQUIRE(hand.simulation.held_back());
    const double work_J = hand.work_J, dissipated_J = hand.simulation.friction().dissipated_J();
    double before_m = hand.simulation.tool().growth().radius_m, largest_m = 0, slid = 0;
    const Eigen::Vector3d from = hand.at;
    for (int k = 1; k <= 600; ++k) {
        hand.tick(from + 2e-5 * k * Eigen::Vector3d::UnitX());
        slid += hand.simulation.record().slipping;
        const double now_m = hand.simulation.tool().growth().radius_m;
        largest_m = std::max(largest_m, std::abs(now_m / before_m - 1));
        before_m = now_m;
        REQUIRE(hand.force_N.norm() < 1.001 * 0.2);
    }
    CHECK(slid > 100);
    CHECK(largest_m < 0.05);
    CHECK(hand.simulation.friction().dissipated_J() - dissipated_J > 0);
    CHECK(hand.simulation.friction().dissipated_J() - dissipated_J < hand.work_J - work_J);
}

TEST_CASE("a ball also indents the mesh beside and keeps its force after a take-over by another session", "[solid][simulation]") {
    HapticOptions options = with_ball(0.008);
    options.heuristic_mesh = true;
    const Ball ball(0.008, options);
    REQUIRE(ball.model.meshes.size() == 2);
    Led hand(ball.model, place - 0.001 * inward);
    hand.lead(place + 0.003 * inward);
    hand.wait(2);
    const Eigen::Vector3d beside = hand.simulation.displacement_at_contact(1);
    CHECK(beside.allFinite());
    CHECK(beside.dot(inward) > 0.001);
    Simulation next(ball.model);
    next.follow(hand.simulation);
    next.check_take_over(hand.simulation);
    next.take_over(hand.simulation);
    DeviceSample sample;
    sample.position_m = hand.at;
    Eigen::Vector3d force;
    for (int k = 0; k < 2000; ++k) force = next.tick(sample);
    CHECK((force - hand.force_N).norm() < 0.02 * hand.force_N.norm());
}

TEST_CASE("a tool is parsed as shape and radius and a model refuses a tool that it was not made for", "[solid][simulation]") {
    CHECK(tool_choice("disc").is_default());
    CHECK(tool_choice("disc:5mm") == ToolChoice{ToolChoice::Shape::disc, 0.005});
    CHECK(tool_choice("ball:0.004") == ToolChoice{ToolChoice::Shape::ball, 0.004});
    CHECK(tool_choice("ball:4mm") == ToolChoice{ToolChoice::Shape::ball, 0.004});
    for (const auto& [text, radius_m] : {std::pair("disc:9mm", 0.009), std::pair("ball:4.2mm", 0.0042), std::pair("ball:5.1mm", 0.0051)}) CHECK(tool_choice(text).radius_m == radius_m);
    CHECK_THROWS_AS(tool_choice("ball:4e0mm"), MismatchError);
    CHECK(tool_choice("ball:0.004m") == ToolChoice{ToolChoice::Shape::ball, 0.004});
    for (const ToolChoice& tool : {ToolChoice{}, tool_choice("disc:5mm"), tool_choice("ball:4.3mm")}) CHECK(tool_choice(to_string(tool)) == tool);
    for (const char* text : {"", "needle:1mm", "ball", "ball:", "ball:4cm", "ball:-4mm", "ball:0", "ball:nan", "disc:1", "disc:mm", "ball:4 mm"})
        CHECK_THAT(refusal<MismatchError>([&] { tool_choice(text); }), Contains(std::string("tool '") + text + "'") && Contains("ball:4mm"));

    const TissueModel model = several_discs();
    const auto refused = [](const TissueModel& m, const char* tool) { return refusal<MismatchError>([&] { with_tool(m, tool_choice(tool)); }); };
    CHECK_THAT(refused(model, "ball:4.2mm"), Contains("ball:0.0042") && Contains("3.9 mm") && Contains("discs from 4 to 10 mm"));
    CHECK_THAT(refused(model, "ball:11mm"), Contains("discs from 4 to 10 mm"));
    CHECK_THAT(refused(solid_model_example(model.mesh), "ball:5mm"), Contains("only a disc of 7 mm"));
    TissueModel relaxing = model;
    relaxing.energy_model->relaxation.tau_s = Eigen::VectorXd::Constant(1, 0.5);
    CHECK_THAT(refused(relaxing, "ball:5mm"), Contains("relaxes"));
    const HapticOptions options = with_ball(0.005);
    const TissueModel of_ball = with_tool(model, options.tool[0]);
    Adaptation adaptation(model);
    HapticOptions of_disc = options;
    of_disc.tool = {tool_choice("disc:5mm")};
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(of_ball, options); }), Contains("has prepared for a ball"));
    const HapticModel ball(model, options);
    CHECK_THAT(refusal<MismatchError>([&] { Learner(ball, adaptation); }), Contains("not with another tool"));
    CHECK(ball.fingerprint != HapticModel(model, of_disc).fingerprint);

    CHECK(tool_choices("disc:7mm,ball:4mm") == ToolChoices{tool_choice("disc:7mm"), tool_choice("ball:4mm")});
    CHECK(tool_choices(to_string(tool_choices("disc,ball:4mm"))) == tool_choices("disc,ball:4mm"));
    for (const char* text : {"disc,", ",disc", "disc,,disc"}) CHECK_THAT(refusal<MismatchError>([&] { tool_choices(text); }), Contains("tool ''"));
    of_disc.tool = tool_choices("disc,ball:5mm");
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(model, of_disc); }), Contains("tool names 2 tools, and tools is 1"));
}
