#include "eval/closed_loop.h"

#include <catch2/catch.hpp>

#include "../example.h"
#include "springs/heuristic.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const SpringMesh& block() {
    static const SpringMesh mesh = make_lattice("grid8", 5, 5, 0.1, 0.1);
    return mesh;
}

/// What springs `theta` say at some contacts, between nodes too.
std::vector<ContactTruth> truths(const SpringLaw& law, const Eigen::VectorXd& theta) {
    std::vector<ContactTruth> list;
    for (const auto& [x, y, dx, dy] : std::vector<std::array<double, 4>>{
             {0, 0.04, 0.01, 0}, {0.1, 0.071, -0.005, -0.004}, {0.033, 0.1, 0.001, -0.01}}) {
        const SurfacePoint contact = locate_on_surface(block(), {x, y});
        const Eigen::Vector2d push(dx, dy);
        const auto state = solve_equilibrium(block(), law, theta, contact, push);
        REQUIRE(state);
        list.push_back({contact, push, state.contact_force, state.displacement});
    }
    return list;
}

ContactError error_of_springs(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                              const ContactTruth& truth) {
    return error_of(answer_of(mesh, law, theta, truth), truth, mesh);
}

/// The first truth of springs, and the answer that agrees with it.
ContactTruth seen() { return truths(*make_spring_law("axial"), example_theta(block()))[0]; }
ContactAnswer agreeing(const ContactTruth& truth) { return {truth.force_N, truth.displacement_m}; }

}  // namespace

TEST_CASE("springs that are the truth have no closed-loop error; half as stiff ones one half of force and none of shape") {
    for (const std::string& name : spring_laws().names()) {
        const auto law = make_spring_law(name);
        const Eigen::VectorXd theta = example_theta(block());
        for (const ContactTruth& truth : truths(*law, theta)) {
            const ContactError own = error_of_springs(block(), *law, theta, truth),
                               half = error_of_springs(block(), *law, theta / 2, truth);
            CHECK(own.force.value() <= tolerance::newton);
            CHECK(half.force.value() == Approx(0.5).epsilon(tolerance::newton));
            for (const ContactError& e : {own, half}) {
                CHECK(e.shape.value() <= tolerance::newton);
                CHECK(e.shape_max_over_depth.value() <= tolerance::newton);
                CHECK(e.reason.empty());
            }
        }
    }
}

TEST_CASE("the closed-loop error counts the force across the push as well") {
    const auto law = make_spring_law("axial");
    const Eigen::VectorXd theta = example_theta(block());
    ContactTruth truth = truths(*law, theta)[1];
    const Eigen::Vector2d force = truth.force_N;
    truth.force_N = Eigen::Vector2d(-force.y(), force.x());  // as strong, a quarter turn away
    const ContactError error = error_of_springs(block(), *law, theta, truth);
    CHECK(error.force.value() == Approx(std::sqrt(2)).epsilon(tolerance::solve));
    CHECK(error.shape.value() <= tolerance::newton);  // the eye sees nothing of it
}

TEST_CASE("half the displacement is a shape error of one half, and none at all one of one") {
    const ContactTruth truth = seen();
    ContactAnswer answer = agreeing(truth);
    CHECK(error_of(answer, truth, block()).shape.value() == 0);
    answer.displacement_m /= 2;
    CHECK(error_of(answer, truth, block()).shape.value() == Approx(0.5).epsilon(tolerance::rounding));
    answer.displacement_m.setZero();
    const ContactError none = error_of(answer, truth, block());
    CHECK(none.shape.value() == Approx(1).epsilon(tolerance::rounding));
    CHECK(none.shape_max_over_depth.value() ==
          Approx(truth.displacement_m.rowwise().norm().maxCoeff() / truth.push_m.norm()).epsilon(tolerance::rounding));
}

TEST_CASE("an offset of all free nodes is its length over their rms displacement, and over the depth") {
    const ContactTruth truth = seen();
    ContactAnswer answer = agreeing(truth);
    const Eigen::RowVector2d offset(0.0003, -0.0004);
    answer.displacement_m.rowwise() += offset;
    double squares = 0;
    int free = 0;
    for (int i = 0; i < block().node_count(); ++i)
        if (block().nodes(i, 1) > 0) ++free, squares += truth.displacement_m.row(i).squaredNorm();
    const ContactError error = error_of(answer, truth, block());
    CHECK(error.shape.value() == Approx(0.0005 / std::sqrt(squares / free)).epsilon(tolerance::rounding));
    CHECK(error.shape_max_over_depth.value() == Approx(0.0005 / 0.01).epsilon(tolerance::rounding));
}

TEST_CASE("one node astray is the largest node error, its part of the mesh in the rms") {
    const ContactTruth truth = seen();
    ContactAnswer answer = agreeing(truth);
    answer.displacement_m(block().node_count() - 1, 0) += 0.002;
    const ContactError error = error_of(answer, truth, block());
    CHECK(error.shape_max_over_depth.value() == Approx(0.2).epsilon(tolerance::rounding));
    CHECK(error.shape.value() == Approx(0.002 / truth.displacement_m.norm()).epsilon(tolerance::rounding));
}

TEST_CASE("free nodes alone count for shape: what stands at held ones is nobody's answer") {
    ContactTruth truth = seen();
    ContactAnswer answer = agreeing(truth);
    answer.displacement_m /= 2;
    for (int node : block().fixed) {
        truth.displacement_m.row(node) << 0.1, 0.1;
        answer.displacement_m.row(node) << -7, 7;
    }
    const ContactError error = error_of(answer, truth, block());
    CHECK(error.shape.value() == Approx(0.5).epsilon(tolerance::rounding));
    CHECK(error.shape_max_over_depth.value() < 1);
}

TEST_CASE("where answer or truth has no displacement there is a force error and no shape error") {
    ContactTruth truth = seen();
    ContactAnswer answer = agreeing(truth);
    answer.displacement_m.resize(0, 2);  // a table of forces
    const ContactError table = error_of(answer, truth, block());
    CHECK(table.force.value() == 0);
    CHECK_FALSE(table.shape);
    CHECK_FALSE(table.shape_max_over_depth);
    answer = agreeing(truth);
    truth.displacement_m.resize(0, 2);  // measured: nobody saw inside
    CHECK(error_of(answer, truth, block()).force.value() == 0);
    CHECK_FALSE(error_of(answer, truth, block()).shape);
}

TEST_CASE("an answer that is not finite is none: its errors are infinite, not left out") {
    const ContactTruth truth = seen();
    for (const bool of_force : {true, false}) {
        ContactAnswer answer = agreeing(truth);
        (of_force ? (*answer.force_N)[0] : answer.displacement_m(7, 1)) = std::nan("");
        const ContactError e = error_of(answer, truth, block());
        for (const std::optional<double>& error : {e.force, e.shape, e.shape_max_over_depth}) CHECK(std::isinf(error.value()));
        CHECK_THAT(e.reason, Contains("not finite"));
        const ContactStatistics s = contact_statistics({e});
        CHECK(s.force.missing == 1);
        CHECK(s.shape.missing == 1);
    }
}

TEST_CASE("the same nodes in another topology are compared one by one") {
    const SpringMesh axes = make_lattice("grid4", 5, 5, 0.1, 0.1);
    const auto law = make_spring_law("isotropic");
    for (const ContactTruth& truth : truths(*make_spring_law("axial"), example_theta(block()))) {
        const ContactError error = error_of_springs(axes, *law, uniform_stiffness(axes, 1), truth);
        CHECK(error.shape.value() > 0.01);
        CHECK(error.shape.value() < 2);
    }
}

TEST_CASE("statistics of many contacts are of all that were drawn: those missing are infinite, and the reasons stand beside") {
    constexpr double none = std::numeric_limits<double>::infinity();
    const std::vector<ContactError> errors = {{0.1, 0.3, 0.5, ""}, {none, none, none, "it folds"}, {0.2, {}, {}, ""}, {0.3, 0.4, 0.6, ""},
                                              {none, none, none, "it folds"}, {{}, {}, {}, "nothing is relative to no force"}};
    const ContactStatistics s = contact_statistics(errors, 4);
    CHECK(s.force.n == 3);
    CHECK(s.force.of() == 10);
    CHECK(s.force.missing == 2);
    CHECK(s.force.no_reference == 5);
    CHECK(s.force.median == 0.3);
    CHECK(std::isinf(s.force.max));
    CHECK(s.shape.n == 2);
    CHECK(s.shape.of() == 10);
    CHECK(std::isinf(s.shape.median));
    CHECK(std::isinf(s.shape_max_over_depth.max));
    CHECK(s.reasons == "it folds (2); nothing is relative to no force (1)");
}

TEST_CASE("the best uniform stiffness of a uniform tissue is its own") {
    for (const std::string& name : spring_laws().names()) {
        const auto law = make_spring_law(name);
        const double k = 0.8;
        const auto found = best_uniform_stiffness(block(), *law, truths(*law, uniform_stiffness(block(), k)), 0.05, 40);
        REQUIRE(found);
        CHECK(*found == Approx(k).epsilon(tolerance::uniform_grid));
    }
}

TEST_CASE("the best uniform stiffness is not chosen on those contacts alone that have an answer") {
    const auto law = make_spring_law("axial");
    const std::vector<ContactTruth> known = truths(*law, uniform_stiffness(block(), 0.8));
    const ContactTruth on_fixed{locate_on_surface(block(), {0.03, 0.0}), Eigen::Vector2d(0, 0.01), Eigen::Vector2d(0, 1)};
    std::vector<ContactTruth> some = {known[0], known[1], known[2], on_fixed, on_fixed};
    CHECK(best_uniform_stiffness(block(), *law, some, 0.05, 40));  // the median is an answer's
    some.push_back(on_fixed);
    CHECK_FALSE(best_uniform_stiffness(block(), *law, some, 0.05, 40));
}

TEST_CASE("the best uniform stiffness stays in its range") {
    const auto law = make_spring_law("axial");
    const auto truth = truths(*law, uniform_stiffness(block(), 3.0));
    CHECK(best_uniform_stiffness(block(), *law, truth, 0.05, 1.0).value() == Approx(1.0).epsilon(tolerance::uniform_grid));
    CHECK(best_uniform_stiffness(block(), *law, truth, 5.0, 9.0).value() == Approx(5.0).epsilon(tolerance::uniform_grid));
    CHECK(best_uniform_stiffness(block(), *law, truth, 5.0, 9.0).value() >= 5.0);
}

TEST_CASE("a mesh with zero-energy modes has neither a closed-loop error nor a best uniform stiffness") {
    const SpringMesh grid4 = make_lattice("grid4", 5, 5, 0.1, 0.1);
    const auto law = make_spring_law("axial");
    const ContactTruth truth{locate_on_surface(grid4, {0, 0.04}), Eigen::Vector2d(0.01, 0), Eigen::Vector2d(1, 0)};
    const ContactError error = error_of_springs(grid4, *law, heuristic_stiffness(grid4, 1), truth);
    CHECK(std::isinf(error.force.value()));  // a missing answer
    CHECK_FALSE(error.shape);                // nobody has seen the truth's
    CHECK_THAT(error.reason, Contains("zero-energy modes"));
    CHECK_FALSE(best_uniform_stiffness(grid4, *law, {truth}, 0.05, 40));
}
