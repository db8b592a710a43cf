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

/// References computed with springs `theta` at some contacts, also between nodes.
std::vector<ContactReference> references(const SpringLaw& law, const Eigen::VectorXd& theta) {
    std::vector<ContactReference> list;
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
                              const ContactReference& reference) {
    return error_of(answer_of(mesh, law, theta, reference), reference, mesh);
}

/// The first of these references, and an answer equal to a reference.
ContactReference seen() { return references(*make_spring_law("axial"), example_theta(block()))[0]; }
ContactAnswer agreeing(const ContactReference& reference) { return {reference.force_N, reference.displacement_m}; }

}  // namespace

TEST_CASE("springs of the reference have no indentation errors; half the stiffness gives half the force") {
    for (const std::string& name : spring_laws().names()) {
        const auto law = make_spring_law(name);
        const Eigen::VectorXd theta = example_theta(block());
        for (const ContactReference& reference : references(*law, theta)) {
            const ContactError own = error_of_springs(block(), *law, theta, reference),
                               half = error_of_springs(block(), *law, theta / 2, reference);
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

TEST_CASE("the indentation error of force includes components across the tool displacement") {
    const auto law = make_spring_law("axial");
    const Eigen::VectorXd theta = example_theta(block());
    ContactReference reference = references(*law, theta)[1];
    const Eigen::Vector2d force = reference.force_N;
    reference.force_N = Eigen::Vector2d(-force.y(), force.x());  // of the same size, rotated by 90 degrees
    const ContactError error = error_of_springs(block(), *law, theta, reference);
    CHECK(error.force.value() == Approx(std::sqrt(2)).epsilon(tolerance::solve));
    CHECK(error.shape.value() <= tolerance::newton);  // displacements are not affected
}

TEST_CASE("half the displacements have a displacement error of 1/2 and zero displacements an error of 1") {
    const ContactReference reference = seen();
    ContactAnswer answer = agreeing(reference);
    CHECK(error_of(answer, reference, block()).shape.value() == 0);
    answer.displacement_m /= 2;
    CHECK(error_of(answer, reference, block()).shape.value() == Approx(0.5).epsilon(tolerance::rounding));
    answer.displacement_m.setZero();
    const ContactError none = error_of(answer, reference, block());
    CHECK(none.shape.value() == Approx(1).epsilon(tolerance::rounding));
    CHECK(none.shape_max_over_depth.value() ==
          Approx(reference.displacement_m.rowwise().norm().maxCoeff() / reference.push_m.norm()).epsilon(tolerance::rounding));
}

TEST_CASE("a uniform offset is an error of its length over rms displacement and over tool displacement") {
    const ContactReference reference = seen();
    ContactAnswer answer = agreeing(reference);
    const Eigen::RowVector2d offset(0.0003, -0.0004);
    answer.displacement_m.rowwise() += offset;
    double squares = 0;
    int free = 0;
    for (int i = 0; i < block().node_count(); ++i)
        if (block().nodes(i, 1) > 0) ++free, squares += reference.displacement_m.row(i).squaredNorm();
    const ContactError error = error_of(answer, reference, block());
    CHECK(error.shape.value() == Approx(0.0005 / std::sqrt(squares / free)).epsilon(tolerance::rounding));
    CHECK(error.shape_max_over_depth.value() == Approx(0.0005 / 0.01).epsilon(tolerance::rounding));
}

TEST_CASE("an error at one node is the largest node error and its part of the rms") {
    const ContactReference reference = seen();
    ContactAnswer answer = agreeing(reference);
    answer.displacement_m(block().node_count() - 1, 0) += 0.002;
    const ContactError error = error_of(answer, reference, block());
    CHECK(error.shape_max_over_depth.value() == Approx(0.2).epsilon(tolerance::rounding));
    CHECK(error.shape.value() == Approx(0.002 / reference.displacement_m.norm()).epsilon(tolerance::rounding));
}

TEST_CASE("fixed nodes do not count in the displacement error") {
    ContactReference reference = seen();
    ContactAnswer answer = agreeing(reference);
    answer.displacement_m /= 2;
    for (int node : block().fixed) {
        reference.displacement_m.row(node) << 0.1, 0.1;
        answer.displacement_m.row(node) << -7, 7;
    }
    const ContactError error = error_of(answer, reference, block());
    CHECK(error.shape.value() == Approx(0.5).epsilon(tolerance::rounding));
    CHECK(error.shape_max_over_depth.value() < 1);
}

TEST_CASE("without displacements of answer or reference only the force error exists") {
    ContactReference reference = seen();
    ContactAnswer answer = agreeing(reference);
    answer.displacement_m.resize(0, 2);  // a table of forces
    const ContactError table = error_of(answer, reference, block());
    CHECK(table.force.value() == 0);
    CHECK_FALSE(table.shape);
    CHECK_FALSE(table.shape_max_over_depth);
    answer = agreeing(reference);
    reference.displacement_m.resize(0, 2);  // measured: no displacement field
    CHECK(error_of(answer, reference, block()).force.value() == 0);
    CHECK_FALSE(error_of(answer, reference, block()).shape);
}

TEST_CASE("a non-finite answer counts as missing with infinite errors") {
    const ContactReference reference = seen();
    for (const bool of_force : {true, false}) {
        ContactAnswer answer = agreeing(reference);
        (of_force ? (*answer.force_N)[0] : answer.displacement_m(7, 1)) = std::nan("");
        const ContactError e = error_of(answer, reference, block());
        for (const std::optional<double>& error : {e.force, e.shape, e.shape_max_over_depth}) CHECK(std::isinf(error.value()));
        CHECK_THAT(e.reason, Contains("not finite"));
        const ContactStatistics s = contact_statistics({e});
        CHECK(s.force.missing == 1);
        CHECK(s.shape.missing == 1);
    }
}

TEST_CASE("displacements of another topology are compared at the same nodes") {
    const SpringMesh axes = make_lattice("grid4", 5, 5, 0.1, 0.1);
    const auto law = make_spring_law("isotropic");
    for (const ContactReference& reference : references(*make_spring_law("axial"), example_theta(block()))) {
        const ContactError error = error_of_springs(axes, *law, uniform_stiffness(axes, 1), reference);
        CHECK(error.shape.value() > 0.01);
        CHECK(error.shape.value() < 2);
    }
}

TEST_CASE("contact statistics count all drawn contacts with missing answers as infinite and list reasons") {
    constexpr double none = std::numeric_limits<double>::infinity();
    const std::vector<ContactError> errors = {{0.1, 0.3, 0.5, ""}, {none, none, none, "it folds"}, {0.2, {}, {}, ""}, {0.3, 0.4, 0.6, ""},
                                              {none, none, none, "it folds"}, {{}, {}, {}, "the reference force is zero"}};
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
    CHECK(s.reasons == "it folds (2); the reference force is zero (1)");
}

TEST_CASE("the best uniform stiffness of a uniform tissue is its own stiffness") {
    for (const std::string& name : spring_laws().names()) {
        const auto law = make_spring_law(name);
        const double k = 0.8;
        const auto found = best_uniform_stiffness(block(), *law, references(*law, uniform_stiffness(block(), k)), 0.05, 40);
        REQUIRE(found);
        CHECK(*found == Approx(k).epsilon(tolerance::uniform_grid));
    }
}

TEST_CASE("no best uniform stiffness exists if half of the contacts have no answer") {
    const auto law = make_spring_law("axial");
    const std::vector<ContactReference> known = references(*law, uniform_stiffness(block(), 0.8));
    const ContactReference on_fixed{locate_on_surface(block(), {0.03, 0.0}), Eigen::Vector2d(0, 0.01), Eigen::Vector2d(0, 1)};
    std::vector<ContactReference> some = {known[0], known[1], known[2], on_fixed, on_fixed};
    CHECK(best_uniform_stiffness(block(), *law, some, 0.05, 40));  // the median error is finite
    some.push_back(on_fixed);
    CHECK_FALSE(best_uniform_stiffness(block(), *law, some, 0.05, 40));
}

TEST_CASE("the best uniform stiffness stays in its range") {
    const auto law = make_spring_law("axial");
    const auto truth = references(*law, uniform_stiffness(block(), 3.0));
    CHECK(best_uniform_stiffness(block(), *law, truth, 0.05, 1.0).value() == Approx(1.0).epsilon(tolerance::uniform_grid));
    CHECK(best_uniform_stiffness(block(), *law, truth, 5.0, 9.0).value() == Approx(5.0).epsilon(tolerance::uniform_grid));
    CHECK(best_uniform_stiffness(block(), *law, truth, 5.0, 9.0).value() >= 5.0);
}

TEST_CASE("a mesh with zero-energy modes has no answer and no best uniform stiffness") {
    const SpringMesh grid4 = make_lattice("grid4", 5, 5, 0.1, 0.1);
    const auto law = make_spring_law("axial");
    const ContactReference reference{locate_on_surface(grid4, {0, 0.04}), Eigen::Vector2d(0.01, 0), Eigen::Vector2d(1, 0)};
    const ContactError error = error_of_springs(grid4, *law, heuristic_stiffness(grid4, 1), reference);
    CHECK(std::isinf(error.force.value()));  // a missing answer
    CHECK_FALSE(error.shape);                // the reference has no displacement field
    CHECK_THAT(error.reason, Contains("zero-energy modes"));
    CHECK_FALSE(best_uniform_stiffness(grid4, *law, {reference}, 0.05, 40));
}
