#include "eval/session_indentation.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "../haptic/haptic_example.h"
#include "mesh/outline.h"
#include "springs/equilibrium.h"
#include "springs/indentation_solver.h"

using namespace tissue;

TEST_CASE("smoothing gain 0.05 reduces the jumps of energy and force at a switch of spring sets", "[truth]") {
    const TissueModel tissue = haptic_example();
    const SwitchJump sudden = switch_jump(tissue, {}, 2, 3, 1.0), smooth = switch_jump(tissue, {}, 2, 3, 0.05);
    CHECK(sudden.energy_jump_J == Approx(sudden.energy_bound_J).epsilon(1e-9));
    CHECK(smooth.energy_bound_J == Approx(0.05 * sudden.energy_bound_J).epsilon(1e-9));
    CHECK(smooth.energy_jump_J <= 1.2 * smooth.energy_bound_J);  // the mesh moves during the switch
    CHECK(smooth.force_jump_N < 0.25 * sudden.force_jump_N);
}

TEST_CASE("the dynamic force of spring sets converges to the static one where the mesh comes to rest", "[truth][long]") {
    for (const ExampleModel& e : {ExampleModel{"grid4", "isotropic", 10, 0.2}, ExampleModel{"grid8", "axial", 10, 0.2}, ExampleModel{"grid8", "geometric", 10, 0.2}}) {
        const TissueModel tissue = haptic_example(e);
        const HapticModel model(tissue, {});
        int answered = 0, asked = 0;
        for (int c = 0; c < tissue.case_count(); c += e.law == "isotropic" ? 2 : 4) {
            const IndentationResult r = indent(model, tissue, {tissue.case_names[static_cast<std::size_t>(c)], tissue.contact_m.row(c), tissue.direction.row(c), tissue.magnitude_m[c], {}});
            if (!r.rested) WARN(e.law << " " << r.name << " does not rest");
            INFO(e.law << " " << r.name << ": " << r.reason << " after " << r.seconds << " s");
            ++asked;
            if (!r.reason.empty() || !r.rested) continue;  // no equilibrium there, or two sets alternate without end
            ++answered;
            CHECK_FALSE((r.fe_asked || r.fe_error || r.static_fe_error));
            CHECK(r.static_error < 0.01);
            CHECK((r.displacement_m - tissue.magnitude_m[c] * tissue.direction.row(c).transpose()).norm() < 2e-3 * tissue.magnitude_m[c]);
        }
        CHECK(answered >= (e.law == "isotropic" ? asked : asked / 2));
    }
}

TEST_CASE("a dynamic indentation at rest at the contact and depth of the reference has small errors", "[truth]") {
    const TissueModel tissue = haptic_example({"grid8", "axial", 10, 0});
    const HapticModel model(tissue, {});
    const auto law = make_spring_law(tissue.law);
    // reference: the static equilibrium of this model, so that only dynamic errors remain
    IndentationReference reference{"top", Eigen::Vector2d(0.047, 0.1), Eigen::Vector2d(0.3, -1).normalized(), 0.012, {}};
    const SurfacePoint point = locate_on_surface(tissue.mesh, reference.contact_m);
    const std::vector<int> loop = tissue.mesh.loop();
    const int segment = static_cast<int>(std::find(loop.begin(), loop.end(), point.node[0]) - loop.begin());
    const int set = model.selector->select(segment, point.weight[1], reference.magnitude_m * reference.direction);
    const auto rest = solve_equilibrium(tissue.mesh, *law, tissue.trained[0].theta.row(set).transpose(), point, reference.magnitude_m * reference.direction);
    REQUIRE(rest);
    reference.force_N = rest.contact_force;
    const IndentationResult r = indent(model, tissue, reference);
    INFO(r.rested << " " << r.reason << " off " << r.off_contact_m << " static " << r.static_error << " " << r.seconds);
    REQUIRE((r.rested && r.fe_error && r.static_fe_error));
    CHECK(*r.fe_error < 2e-3);
    CHECK(*r.static_fe_error < 2e-3);
    CHECK(r.fe_asked);
    CHECK(r.off_contact_m < 1e-6);
}

TEST_CASE("a dynamic indentation of an energy model rests within five seconds at its static equilibrium", "[truth][law]") {
    const TissueModel tissue = energy_model_example();
    HapticOptions options;
    options.safety.force_max_N = 10;  // the largest force is 6 N
    const HapticModel model(tissue, options);
    const IndentationSolver solver(tissue);
    const Outline outline(tissue.mesh);
    struct Push { double arc, angle, depth; };
    for (const auto& [arc, angle, depth] : {Push{0.03, 0.4, 0.010}, Push{0.075, 0, 0.008}, Push{0.102, -0.3, 0.006}, Push{0.147, 0.5, 0.010}, Push{0.28, -0.5, 0.012}}) {
        IndentationReference reference{"place", outline.position(arc), outline.direction(arc, angle), depth, {}};
        const Equilibrium exact = solver.at(outline.position(arc), depth * reference.direction);
        REQUIRE(exact);
        reference.force_N = exact.contact_force;  // reference: this energy model
        const IndentationResult r = indent(model, tissue, reference);
        INFO("arc " << arc << ": " << r.reason << " after " << r.seconds << " s, off " << r.off_contact_m << ", static " << r.static_error);
        REQUIRE((r.rested && r.fe_error && r.static_fe_error));
        CHECK(r.seconds <= 5);
        CHECK(r.static_error < 1e-4);
        CHECK(*r.fe_error < 2e-3);
        CHECK(*r.static_fe_error < 1e-9);
        CHECK((r.displacement_m - depth * reference.direction).norm() < 1e-6);
    }
}
