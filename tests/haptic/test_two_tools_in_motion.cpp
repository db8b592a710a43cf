// Two devices on one tissue: forces at rest of the common equilibrium; each device has its own energy, faults and
// state.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "../allocations.h"
#include "../mesh/embedded_block.h"
#include "../refusal.h"
#include "../solid_model_example.h"
#include "../springs/several_discs.h"
#include "haptic/energy_model_spectrum.h"
#include "haptic/session_options.h"
#include "haptic/simulation.h"
#include "haptic_example.h"
#include "springs/indentation_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const TissueModel& block() {
    static const TissueModel model = solid_model_example(embedded_block(Lattice{{8, 8, 3}, {0.08, 0.08, 0.03}}));
    return model;
}

HapticOptions of_tools(int tools) {
    HapticOptions options = interface_options();
    options.tools = tools;
    return options;
}

const HapticModel& pressed_by(int tools) {
    static const HapticModel one(block(), of_tools(1)), two(block(), of_tools(2));
    return tools == 1 ? one : two;
}

const Eigen::Vector3d left_m(0.024, 0.041, 0.03), right_m(0.050, 0.041, 0.03), up(0, 0, 0.004);

/// Two hands that move on straight lines from where they are.
struct Hands {
    Simulation& s;
    Eigen::Vector3d at_m[2] = {left_m + up, right_m + up}, force_N[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    void tick() {
        const DeviceSample samples[2] = {sample_at(at_m[0]), sample_at(at_m[1])};
        s.tick(samples, force_N);
    }
    void to(const Eigen::Vector3d& left, const Eigen::Vector3d& right, int ticks, int stay = 0) {
        const Eigen::Vector3d from[2] = {at_m[0], at_m[1]}, aim[2] = {left, right};
        for (int k = 1; k <= ticks + stay; ++k) {
            for (int t = 0; t < 2; ++t) at_m[t] = from[t] + std::min(1.0, static_cast<double>(k) / ticks) * (aim[t] - from[t]);
            tick();
        }
    }
};

const Eigen::Vector3d left_push(0.0005, 0, -0.004), right_push(-0.001, 0.0005, -0.003);

}  // namespace

TEST_CASE("two tools in motion come to rest with the forces of their common equilibrium", "[simulation][solid][two]") {
    Simulation s(pressed_by(2));
    Hands hands{s};
    hands.to(left_m, right_m, 100);
    hands.to(left_m + left_push, right_m + right_push, 300, 6000);
    const IndentationSolver solver(block());
    std::vector<ToolPush> tools;
    for (int t : {0, 1}) {
        REQUIRE(s.record(t).mesh == 0);
        REQUIRE(s.record(t).status == TickStatus::done);
        tools.push_back({s.model().meshes[0]->springs.rest_place(s.record(t).facet, s.record(t).weight), s.record(t).contact_displacement_m});
    }
    CHECK((tools[1].contact_m - right_m).norm() < 1e-3);
    const ToolsEquilibrium rest = solver.at(tools);
    REQUIRE(rest);
    for (std::size_t t : {0u, 1u}) {
        const Point alone_N = solver.at(tools[t].contact_m, tools[t].push_m).contact_force, both_N = rest.contact_force[t];
        CHECK((s.record(static_cast<int>(t)).coupling_N + both_N).norm() < 2e-3 * both_N.norm());
        // else the test would pass with tools that do not interact
        CHECK((alone_N - both_N).norm() > 0.02 * both_N.norm());
    }
    CHECK((s.state(0).displacement - NodeColumns(rest.displacement)).norm() < 2e-3 * rest.displacement.norm());

    // The displayed displacement is that of evaluation, one tool after the other.
    NodeColumns seen = s.state(0).displacement;
    const NodeField wanted = solver.displayed(tools[1].contact_m, tools[1].push_m, solver.displayed(tools[0].contact_m, tools[0].push_m, rest.displacement));
    s.displayed(0, seen);
    CHECK((seen - NodeColumns(wanted)).norm() < 2e-3 * wanted.norm());
}

TEST_CASE("a second tool without contact leaves the first one's force unchanged and either may come and go", "[simulation][solid][two]") {
    Simulation two(pressed_by(2)), one(pressed_by(1));
    Hands hands{two};
    REQUIRE(pressed_by(2).meshes[0]->substeps == pressed_by(1).meshes[0]->substeps);
    const double damper_s = pressed_by(2).meshes[0]->contact_damping_s;
    const bool same_steps = damper_s == pressed_by(1).meshes[0]->contact_damping_s;
    const auto press_left = [&](double depth_m, int ticks) {
        const Eigen::Vector3d from = hands.at_m[0], aim = left_m - Eigen::Vector3d(0, 0, depth_m);
        double apart_N = 0, most_N = 0;
        for (int k = 1; k <= ticks; ++k) {
            hands.at_m[0] = from + static_cast<double>(k) / ticks * (aim - from);
            hands.tick();
            const Eigen::Vector3d alone_N = one.tick(sample_at(hands.at_m[0]));
            apart_N = std::max(apart_N, (hands.force_N[0] - alone_N).norm());
            most_N = std::max(most_N, alone_N.norm());
        }
        REQUIRE(most_N > 0.05);
        CHECK(hands.force_N[1].isZero(0));
        CHECK(apart_N <= (same_steps ? 0 : 0.01 * most_N));
    };
    press_left(0.004, 300);

    // The second tool comes, and both interact. It leaves, and the first is alone again.
    const double before_N = hands.force_N[0].norm();
    const Eigen::Vector3d in = right_m - Eigen::Vector3d(0, 0, 0.004);
    hands.to(hands.at_m[0], in, 300, 1000);
    CHECK(hands.force_N[1].norm() > 0.05);
    CHECK(hands.force_N[0].norm() < 0.99 * before_N);
    hands.to(hands.at_m[0], right_m + up, 300, 4000);
    CHECK(hands.force_N[1].isZero(0));
    CHECK(two.contact(1).contact == false);
    for (int k = 0; k < 5600; ++k) one.tick(sample_at(hands.at_m[0]));
    CHECK((hands.force_N[0] - one.record().device_N).norm() < 2e-3 * before_N);
    // The first tool leaves while the second is in.
    hands.to(hands.at_m[0], in, 300, 1000);
    hands.to(left_m + up, in, 300, 1000);
    CHECK(hands.force_N[0].isZero(0));
    CHECK(hands.force_N[1].norm() > 0.05);
}

TEST_CASE("a fault of one of two tools stops only that one", "[simulation][solid][two]") {
    Simulation s(pressed_by(2));
    Hands hands{s};
    hands.to(left_m, right_m, 100);
    hands.to(left_m + left_push, right_m + right_push, 300, 500);
    const double left_N = hands.force_N[0].norm();
    REQUIRE(hands.force_N[1].norm() > 0.01);
    const Eigen::Vector3d was_m = hands.at_m[1];
    hands.at_m[1].x() = std::nan("");
    hands.tick();
    CHECK(s.record(1).status == TickStatus::refused);
    CHECK(hands.force_N[1].isZero(0));
    CHECK(s.record(0).status == TickStatus::done);
    CHECK(hands.force_N[0].norm() == Approx(left_N).epsilon(0.05));
    hands.at_m[1] = was_m;
    for (int k = 0; k < 500; ++k) {
        hands.tick();
        REQUIRE(hands.force_N[1].isZero(0));
        REQUIRE(s.record(0).status == TickStatus::done);
    }
    CHECK(s.record(1).status == TickStatus::not_armed);
    CHECK(s.safety(1).counters().bad_input == 1);
    CHECK(s.safety(0).counters().bad_input == 0);
    hands.to(left_m + left_push, right_m + up, 100);
    hands.to(left_m + left_push, right_m + right_push, 300);
    CHECK(hands.force_N[1].norm() > 0.01);
}

TEST_CASE("two tools that come and go in turn gain no net energy", "[simulation][solid][two]") {
    HapticOptions slippery = of_tools(2);
    slippery.friction.stick = 0.3;
    const HapticModel model(block(), slippery);
    Simulation s(model);
    Hands hands{s};
    hands.to(left_m, right_m, 100);
    double given_J = 0;
    Eigen::Vector3d last_m[2] = {hands.at_m[0], hands.at_m[1]};
    const auto go = [&](const Eigen::Vector3d& left, const Eigen::Vector3d& right, int ticks) {
        const Eigen::Vector3d from[2] = {hands.at_m[0], hands.at_m[1]}, aim[2] = {left, right};
        for (int k = 1; k <= ticks; ++k) {
            const Eigen::Vector3d held_N[2] = {hands.force_N[0], hands.force_N[1]};
            for (int t = 0; t < 2; ++t) hands.at_m[t] = from[t] + static_cast<double>(k) / ticks * (aim[t] - from[t]);
            for (int t = 0; t < 2; ++t) given_J += held_N[t].dot(hands.at_m[t] - last_m[t]);
            for (int t = 0; t < 2; ++t) last_m[t] = hands.at_m[t];
            hands.tick();
        }
    };
    // Each tool goes in while the other is out, and the other way round. Forces that do not derive from one energy
    // would give net work in a round.
    double stored_J = 0;
    for (int round = 0; round < 4; ++round) {
        go(left_m + left_push, right_m, 200);
        go(left_m + left_push, right_m + right_push, 200);
        stored_J = std::max(stored_J, -given_J);
        go(left_m, right_m + right_push, 200);
        go(left_m + left_push, right_m, 200);
        go(left_m + up, right_m + up, 200);
        CHECK(given_J <= 0);
    }
    CHECK(stored_J > 1e-5);
    for (int t : {0, 1}) CHECK(s.safety(t).observed_J() <= s.safety(t).bound_J());
}

TEST_CASE("two tools at or near one place raise the highest frequency and come to rest and separate", "[simulation][solid][two]") {
    const EnergyModelSpectrum alone = energy_model_spectrum(block(), pressed_by(1).meshes[0]->springs), both = energy_model_spectrum(block(), pressed_by(1).meshes[0]->springs, 2);
    CHECK(both.largest > 1.001 * alone.largest);
    CHECK(both.largest < 2 * alone.largest);
    CHECK(pressed_by(2).meshes[0]->largest_eigenvalue_1_s2 == both.largest);
    for (const double apart_m : {0.0, 0.004, 0.012}) {
        INFO(apart_m);
        Simulation s(pressed_by(2));
        Hands hands{s};
        const Eigen::Vector3d right = left_m + Eigen::Vector3d(apart_m, 0, 0), in = Eigen::Vector3d(0, 0, -0.003);
        hands.at_m[1] = right + up;
        hands.to(left_m, right, 100);
        hands.to(left_m + in, right, 100, 1000);
        const double one_N = hands.force_N[0].norm();
        hands.to(left_m + in, right + in, 100, 3000);
        for (int k = 0; k < 500; ++k) {  // no oscillation is left
            const Eigen::Vector3d last_N[2] = {hands.force_N[0], hands.force_N[1]};
            hands.tick();
            for (int t : {0, 1}) REQUIRE((hands.force_N[t] - last_N[t]).norm() < 1e-4 * last_N[t].norm());
        }
        for (int t : {0, 1}) CHECK(hands.force_N[t].z() > 0.02);
        // the second tool touched an indented surface
        if (apart_m == 0) CHECK(hands.force_N[0].z() == Approx(hands.force_N[1].z()).epsilon(1e-4));
        CHECK(hands.force_N[0].norm() < one_N);
        hands.to(left_m + up, right + in, 100, 3000);
        CHECK(hands.force_N[0].isZero(0));
        CHECK(hands.force_N[1].norm() > 0.9 * one_N);
    }
}

TEST_CASE("two tools have their own energy credit and clutch and faults and a reset affects both", "[simulation][solid][two]") {
    Simulation s(pressed_by(2));
    Hands hands{s};
    hands.to(left_m, right_m, 100);
    const Eigen::Vector3d in(0, 0, -0.004);
    // The second tool comes and goes while the first presses. Its energy credit of one contact is not available to the
    // next.
    hands.to(left_m + in, right_m + up, 300, 500);
    for (int round = 0; round < 3; ++round) {
        hands.to(left_m + in, right_m + in, 200, 100);
        CHECK(s.safety(1).observed_J() < 0);
        hands.to(left_m + in, right_m + up, 20, 1500);
        CHECK(s.safety(1).observed_J() == 0);
        CHECK(s.safety(0).observed_J() < 0);
    }
    // Clutch of the second tool.
    hands.to(left_m + in, right_m + in, 200, 200);
    s.clutch(true, 1);
    const Point tool_m = s.record(1).master_m;
    hands.to(left_m + in, right_m + in + Eigen::Vector3d(0.005, 0, 0.002), 50);
    CHECK((s.record(1).master_m - tool_m).norm() < 1e-12);
    CHECK(hands.force_N[1].isZero(0));
    CHECK(hands.force_N[0].norm() > 0.05);
    s.clutch(false, 1);
    hands.to(hands.at_m[0], hands.at_m[1], 1, 200);
    CHECK(hands.force_N[1].norm() > 0.05);
    // A fault of the first tool.
    const Eigen::Vector3d was_m = hands.at_m[0];
    hands.at_m[0].setConstant(std::nan(""));
    hands.tick();
    CHECK(hands.force_N[0].isZero(0));
    CHECK(hands.force_N[1].norm() > 0.05);
    hands.at_m[0] = was_m;
    hands.to(was_m, hands.at_m[1], 1, 49);
    CHECK(s.unarmed(0) == 50);
    CHECK(s.unarmed(1) == 0);
    // A reset by the sample of one tool.
    DeviceSample samples[2] = {sample_at(hands.at_m[0]), sample_at(s.options(1).map.to_device(s.record(1).master_m))};
    samples[1].position_m = hands.at_m[1];
    samples[1].reset = true;
    s.tick(samples, hands.force_N);
    for (int t : {0, 1}) {
        CHECK(s.record(t).reset);
        CHECK(hands.force_N[t].isZero(0));
    }
    CHECK(s.state(0).displacement.cwiseAbs().maxCoeff() < 1e-6);
    // With one sample only the first tool acts. In a pause neither has a force.
    hands.to(left_m + up, hands.at_m[1] + Eigen::Vector3d(0, 0, 0.01), 100);
    hands.to(left_m + in, hands.at_m[1] + in - Eigen::Vector3d(0, 0, 0.01), 300);
    REQUIRE(hands.force_N[1].norm() > 0.02);
    const SafetyCounters before = s.safety(1).counters();
    CHECK(s.tick(sample_at(hands.at_m[0])).norm() > 0.05);
    CHECK(s.record(1).status == TickStatus::refused);
    CHECK(s.record(1).device_N.isZero(0));
    CHECK(s.safety(1).counters().bad_input == before.bad_input + 1);
    CHECK(s.safety(1).counters().jump == before.jump);
    const Eigen::Vector3d pressed_m = hands.at_m[1];
    hands.to(hands.at_m[0], pressed_m + up + Eigen::Vector3d(0, 0, 0.01), 200);
    hands.to(hands.at_m[0], pressed_m, 300);
    REQUIRE(hands.force_N[1].norm() > 0.02);
    CHECK(s.skip_tick(sample_at(hands.at_m[0]), 1e-3).isZero(0));
    CHECK(s.safety(1).force_N().isZero(0));
    hands.tick();
    CHECK(s.record(1).status == TickStatus::not_armed);
}

TEST_CASE("two tools on tissue that relaxes have their own Maxwell branches in their contacts", "[simulation][solid][two][relaxation]") {
    const TissueModel tissue = relaxing(block());
    const HapticModel one_model(tissue, of_tools(1)), two_model(tissue, of_tools(2));
    Simulation one(one_model), s(two_model);
    Hands hands{s};
    const Eigen::Vector3d in(0, 0, -0.004);
    const auto both_ways = [&](const Eigen::Vector3d& left, int ticks, int stay = 0) {
        const Eigen::Vector3d from = hands.at_m[0];
        for (int k = 1; k <= ticks + stay; ++k) {
            hands.at_m[0] = from + std::min(1.0, static_cast<double>(k) / ticks) * (left - from);
            hands.tick();
            const Eigen::Vector3d alone_N = one.tick(sample_at(hands.at_m[0]));
            REQUIRE((hands.force_N[0] - alone_N).norm() <= 0.01 * alone_N.norm() + 1e-6);
        }
    };
    both_ways(left_m, 100);
    both_ways(left_m + in, 100);
    const double first_N = hands.force_N[0].norm();
    both_ways(left_m + in, 1, 2000);
    CHECK(hands.force_N[0].norm() < 0.7 * first_N);
    // The second tool comes late, and its contact has not relaxed yet.
    hands.to(hands.at_m[0], right_m, 100);
    hands.to(hands.at_m[0], right_m + in, 100);
    CHECK(hands.force_N[1].norm() > 1.3 * hands.force_N[0].norm());
}

TEST_CASE("a session of two tools is saved and copied and followed with both and its ticks allocate nothing", "[simulation][solid][two][state]") {
    HapticOptions slippery = of_tools(2);
    slippery.friction.stick = 0.3;
    const HapticModel model(block(), slippery);
    Simulation s(model);
    HapticOptions second = s.options(1);
    second.map.offset_m = Eigen::Vector3d(0.01, 0, 0);
    second.friction.stick = 0.1;
    s.change(second, 1);
    Hands hands{s};
    const auto given = [&](const Eigen::Vector3d& p) { return Eigen::Vector3d(p - second.map.offset_m); };
    hands.at_m[1] = given(hands.at_m[1]);
    hands.to(left_m, given(right_m), 100);
    hands.to(left_m + left_push, given(right_m + right_push), 300, 200);
    REQUIRE(s.record(1).mesh == 0);
    CHECK((s.record(1).master_m - (right_m + right_push)).norm() < 1e-12);
    Simulation copy(s);
    Hands other{copy, {hands.at_m[0], hands.at_m[1]}};
    long allocations = 0;
    for (int k = 0; k < 300; ++k) {
        hands.at_m[0].x() += 2e-5 * std::sin(0.02 * k);
        hands.at_m[1].y() += 3e-5 * std::sin(0.03 * k);
        const DeviceSample samples[2] = {sample_at(hands.at_m[0]), sample_at(hands.at_m[1])};
        {
            const Allocations none;
            s.tick(samples, hands.force_N);
            allocations += Allocations::count();
        }
        other.at_m[0] = hands.at_m[0], other.at_m[1] = hands.at_m[1];
        other.tick();
        REQUIRE(other.force_N[0] == hands.force_N[0]);
        REQUIRE(other.force_N[1] == hands.force_N[1]);
    }
    CHECK(allocations == 0);
    std::vector<std::byte> bytes(s.state_size()), again(bytes.size());
    s.save(bytes.data());
    copy.save(again.data());
    CHECK(bytes == again);

    // A session of another model takes over both hands.
    TissueModel stiffer = block();
    stiffer.energy_model->constants *= 1.2;
    const HapticModel next_model(stiffer, slippery);
    Simulation next(next_model);
    next.follow(s);
    next.take_over(s);
    const Eigen::Vector3d before_N[2] = {hands.force_N[0], hands.force_N[1]};
    Hands after{next, {hands.at_m[0], hands.at_m[1]}};
    after.tick();
    for (int t : {0, 1}) {
        CHECK(next.record(t).status == TickStatus::done);
        CHECK((after.force_N[t] - before_N[t]).norm() < 1e-9);
        CHECK(next.options(t).friction.stick == s.options(t).friction.stick);
    }
    after.to(after.at_m[0], after.at_m[1], 1, 3000);
    CHECK(after.force_N[0].norm() > 1.05 * before_N[0].norm());

    // A tool without force in the leading session is not moved by follow().
    Hands stopped{next, {after.at_m[0], after.at_m[1]}};
    stopped.at_m[1].setConstant(std::nan(""));
    stopped.tick();
    REQUIRE(next.record(1).status == TickStatus::refused);
    Simulation later(next_model);
    later.follow(next);
    CHECK(later.record(0).status == TickStatus::done);
    CHECK(later.record(1).status == TickStatus::refused);

    Simulation one(pressed_by(1));
    CHECK_THAT(refusal<MismatchError>([&] { one.follow(s); }), Contains("a session of 1 tools cannot take over from one of 2 tools"));
    CHECK_THAT(refusal<MismatchError>([&] { one.restore(bytes.data(), bytes.size()); }), Contains("a state of"));
}

TEST_CASE("limits of each of two devices change until the first tick only and are saved and taken over", "[simulation][solid][two][state]") {
    Simulation s(pressed_by(2));
    HapticOptions own = s.options(1);
    own.device.force_max_N = 8;
    own.safety.force_max_N = 12;
    own.safety.slew_N_s = 70;
    own.safety.speed_max_m_s = 1.5;
    own.safety.stale_s = 0.02;
    own.safety.passivity = false;
    s.change(own, 1);
    const auto has = [&](const Simulation& session) {
        const SafetyOptions &o = session.options(1).safety, &really = session.safety(1).options();
        return o.force_max_N == 8 && o.slew_N_s == 70 && o.speed_max_m_s == 1.5 && o.stale_s == 0.02 && !o.passivity && really.force_max_N == 8 && really.slew_N_s == 70 && really.stale_s == 0.02 && really.speed_max_m_s == 1.5 && !really.passivity && session.options(1).device.force_max_N == 8;
    };
    CHECK(has(s));
    CHECK(s.options(0).safety.force_max_N == 3.3);
    Hands hands{s};
    hands.to(left_m + left_push, right_m + right_push, 200, 100);
    HapticOptions late = s.options(1);
    late.safety.force_max_N = 1;
    late.device.force_max_N = 1;
    s.change(late, 1);
    CHECK(has(s));
    const Simulation copy(s);
    CHECK(has(copy));
    std::vector<std::byte> bytes(s.state_size());
    s.save(bytes.data());
    Simulation fresh(pressed_by(2)), usual(pressed_by(2));
    fresh.restore(bytes.data(), bytes.size());
    CHECK(has(fresh));
    Hands later{usual};
    later.to(left_m, right_m, 10);
    usual.restore(bytes.data(), bytes.size());  // a session that has ticked keeps its own limits
    CHECK(usual.options(1).safety.force_max_N == 3.3);
    CHECK(usual.options(1).device.force_max_N == pressed_by(2).options.device.force_max_N);
    CHECK(usual.safety(1).options().slew_N_s == 5000);
    CHECK(usual.safety(1).force_N() == s.safety(1).force_N());
    Simulation next(pressed_by(2));
    next.follow(s);
    next.take_over(s);
    CHECK(has(next));
}

TEST_CASE("a restored state saves equal bytes even where more energy was given than the bound allows", "[simulation][solid][state]") {
    HapticOptions unbounded = of_tools(1);
    unbounded.safety.passivity = false;
    const HapticModel model(block(), unbounded);
    Simulation s(model);
    for (int k = 0; k < 300; ++k) s.tick(sample_at(Eigen::Vector3d(left_m + up + std::min(1.0, k / 200.0) * (Eigen::Vector3d(0, 0, -0.004) - up))));
    const Eigen::Vector3d pressed_m = left_m + Eigen::Vector3d(0, 0, -0.004);
    const double late_s = 1.2 * s.options().safety.hold_s;
    for (int k = 0; k < 400; ++k) s.tick(sample_at(pressed_m), late_s);
    REQUIRE(s.safety().observed_J() > s.safety().lateness() * s.safety().bound_J());
    std::vector<std::byte> bytes(s.state_size()), again(bytes.size());
    s.save(bytes.data());
    s.restore(bytes.data(), bytes.size());
    s.save(again.data());
    CHECK(bytes == again);
}

TEST_CASE("each of two tools of different shape and size has the force of its own contact", "[simulation][solid][two]") {
    const TissueModel tissue = several_discs();
    const auto model_of = [&](const char* tool, int tools) {
        HapticOptions options = of_tools(tools);
        options.tool = tool_choices(tool);
        options.safety.force_max_N = options.device.force_max_N = 100;
        return std::make_unique<HapticModel>(tissue, options);
    };
    const auto both = model_of("disc:5mm,ball:8mm", 2), swapped = model_of("ball:8mm,disc:5mm", 2);
    CHECK(both->tools == tool_choices("disc:5mm,ball:8mm"));
    CHECK(both->fingerprint != swapped->fingerprint);
    CHECK(both->meshes[0]->substeps == swapped->meshes[0]->substeps);
    const Eigen::Vector3d at_m[2] = {{0.015, 0.021, 0.02}, {0.035, 0.042, 0.02}}, above(0, 0, 0.002), push(0.0003, 0, -0.002);

    // One of them alone has the force of a session of that tool.
    for (int t : {0, 1}) {
        const auto own = model_of(t == 0 ? "disc:5mm" : "ball:8mm", 1), wrong = model_of(t == 0 ? "ball:8mm" : "disc:5mm", 1);
        Simulation two(*both), one(*own), other(*wrong);
        Hands hands{two};
        const auto at = [&](double share) { return Eigen::Vector3d(at_m[t] + (1 - share) * above + share * push); };
        hands.at_m[1 - t] = at_m[1 - t] + 5 * above;
        Eigen::Vector3d alone_N, wrong_N;
        for (int k = 0; k < 1500; ++k) {
            hands.at_m[t] = at(std::min(1.0, k / 300.0));
            hands.tick();
            alone_N = one.tick(sample_at(hands.at_m[t]));
            wrong_N = other.tick(sample_at(hands.at_m[t]));
        }
        REQUIRE(alone_N.norm() > 0.02);
        CHECK(hands.force_N[1 - t].isZero(0));
        CHECK((hands.force_N[t] - alone_N).norm() < 1e-3 * alone_N.norm());
        CHECK((wrong_N - alone_N).norm() > 0.05 * alone_N.norm());
    }

    // Both at once: the order of the tools has no effect, and each feels the other.
    Simulation first(*both), second(*swapped);
    Hands hands{first}, crossed{second};
    hands.at_m[0] = crossed.at_m[1] = at_m[0] + above;
    hands.at_m[1] = crossed.at_m[0] = at_m[1] + above;
    hands.to(at_m[0] + push, at_m[1] + push, 300, 1200);
    crossed.to(at_m[1] + push, at_m[0] + push, 300, 1200);
    for (int t : {0, 1}) {
        REQUIRE(hands.force_N[t].norm() > 0.02);
        CHECK((hands.force_N[t] - crossed.force_N[1 - t]).norm() < 1e-6 * hands.force_N[t].norm());
    }
    CHECK(first.tool(0).growth().radius_m == 0);
    CHECK(first.tool(1).growth().radius_m > 0.001);  // the ball's contact

    // A state is that of these tools in this order.
    std::vector<std::byte> bytes(first.state_size());
    first.save(bytes.data());
    Simulation again(*both), wrong(*swapped);
    again.restore(bytes.data(), bytes.size());
    Hands later{again};
    later.at_m[0] = hands.at_m[0];
    later.at_m[1] = hands.at_m[1];
    for (int k = 0; k < 20; ++k) {
        hands.tick();
        later.tick();
        for (int t : {0, 1}) CHECK(hands.force_N[t] == later.force_N[t]);
    }
    CHECK_THROWS_AS(wrong.restore(bytes.data(), bytes.size()), MismatchError);
    // The contacts of another session of unlike tools are taken over.
    Simulation next(*both);
    next.follow(first);
    next.take_over(first);
    Hands taken{next};
    taken.at_m[0] = hands.at_m[0];
    taken.at_m[1] = hands.at_m[1];
    for (int k = 0; k < 1500; ++k) taken.tick();
    for (int t : {0, 1}) CHECK((taken.force_N[t] - hands.force_N[t]).norm() < 0.02 * hands.force_N[t].norm());
}

TEST_CASE("two tools require an energy model and no second mesh", "[simulation][two]") {
    HapticOptions options = of_tools(2);
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(haptic_example(), options); }), Contains("two tools need an energy model, and this model has spring sets"));
    options.heuristic_mesh = true;
    CHECK_THAT(refusal<MismatchError>([&] { HapticModel(block(), options); }), Contains("two tools are not possible with the heuristic mesh"));
    options.tools = 3;
    CHECK_THAT(refusal<MismatchError>([&] { check_options(options); }), Contains("tools must lie in [1, 2]"));
    CHECK_THAT(refusal<MismatchError>([&] { set_option(options, "tools", "1.5"); }), Contains("tools must be a whole number, not '1.5'"));
}
