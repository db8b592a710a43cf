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
        list.push_back({contact, push, state.contact_force});
    }
    return list;
}

}  // namespace

TEST_CASE("springs that are the truth have no closed-loop error; half as stiff ones one half") {
    EquilibriumStatus status{};
    for (const std::string& name : spring_laws().names()) {
        const auto law = make_spring_law(name);
        const Eigen::VectorXd theta = example_theta(block());
        for (const ContactTruth& truth : truths(*law, theta)) {
            CHECK(closed_loop_error(block(), *law, theta, truth, status).value() <= tolerance::newton);
            CHECK(closed_loop_error(block(), *law, theta / 2, truth, status).value() ==
                  Approx(0.5).epsilon(tolerance::newton));
        }
    }
}

TEST_CASE("the closed-loop error counts the force across the push as well") {
    const auto law = make_spring_law("axial");
    const Eigen::VectorXd theta = example_theta(block());
    ContactTruth truth = truths(*law, theta)[1];
    const Eigen::Vector2d force = truth.force_N;
    truth.force_N = Eigen::Vector2d(-force.y(), force.x());  // as strong, a quarter turn away
    EquilibriumStatus status{};
    CHECK(closed_loop_error(block(), *law, theta, truth, status).value() ==
          Approx(std::sqrt(2)).epsilon(tolerance::solve));
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
    EquilibriumStatus status{};
    CHECK_FALSE(closed_loop_error(grid4, *law, heuristic_stiffness(grid4, 1), truth, status));
    CHECK_THAT(reason_of(status), Contains("zero-energy modes"));
    CHECK_FALSE(best_uniform_stiffness(grid4, *law, {truth}, 0.05, 40));
}
