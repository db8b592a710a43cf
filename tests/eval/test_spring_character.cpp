#include "eval/spring_character.h"

#include <catch2/catch.hpp>

#include "eval/force_error.h"
#include "../example.h"
#include "springs/heuristic.h"
#include "../tolerances.h"
#include "train/train_sets.h"

using namespace tissue;

namespace {

struct Example {
    Cases cases;
    TrainedModel model;
};

Example example(const std::string& topology) {
    Study study = example_study();
    study.springs.topology = topology;
    Example x;
    x.cases = example_cases(study, example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1)));
    x.model = train_sets(study, x.cases, 1);
    return x;
}

}  // namespace

TEST_CASE("the heuristic has distance 0 from itself and a uniform set has no steps") {
    const Example x = example("grid8");
    const SpringCharacter c = spring_character(x.model, x.cases, x.model.heuristic_a.transpose());
    CHECK(statistics_of(c.near).max == 0);
    CHECK(statistics_of(c.far).max == 0);
    CHECK(statistics_of(c.magnitude_step).max == 0);
    CHECK(c.near.size() == 4);
    CHECK(c.magnitude_step.size() == 2);
    CHECK(c.force_steps == 2);
    CHECK(c.force_falls == 0);
}

TEST_CASE("springs one E2 above the heuristic have distance 1 near and far from the contact") {
    const Example x = example("grid8");
    const NodeField theta = (x.model.heuristic_a.array() + x.model.modulus_N_m).matrix().transpose();
    const SpringCharacter c = spring_character(x.model, x.cases, theta);
    for (double d : c.near) CHECK(d == Approx(1).epsilon(tolerance::rounding));
    for (double d : c.far) CHECK(d == Approx(1).epsilon(tolerance::rounding));
}

TEST_CASE("a stiffer set at the larger magnitude is a step and a soft one lowers the force") {
    const Example x = example("grid8");
    NodeField theta = x.model.heuristic_a.transpose().replicate(4, 1);
    theta.row(1) *= 2;
    CHECK(statistics_of(spring_character(x.model, x.cases, theta).magnitude_step).max > 0.1);
    theta.row(1) *= 0.1;  // 8 mm at a fifth of the stiffness is less force than 4 mm
    CHECK(spring_character(x.model, x.cases, theta).force_falls == 1);
}

TEST_CASE("grid8 has no zero-energy modes on its supports and grid4 with axial springs has some") {
    const Example stable = example("grid8"), singular = example("grid4");
    const SpringCharacter c = spring_character(stable.model, stable.cases, stable.model.heuristic_a.transpose());
    CHECK(c.smallest_eigenvalue > 0);
    CHECK(c.singular_sets == 0);
    CHECK(spring_character(singular.model, singular.cases, singular.model.heuristic_a.transpose()).singular_sets == 1);
}

TEST_CASE("a larger ridge gives a larger loss and a smaller distance from the heuristic") {
    const Example x = example("grid8");
    const auto front = ridge_front(x.model, x.cases, 0.05 * x.model.modulus_N_m, 40 * x.model.modulus_N_m);
    REQUIRE(front.size() > 2);
    for (std::size_t i = 1; i < front.size(); ++i) {
        CHECK(front[i].ridge > front[i - 1].ridge);
        CHECK(front[i].rel_loss >= front[i - 1].rel_loss - tolerance::newton);
        CHECK(front[i].distance <= front[i - 1].distance + tolerance::newton);
    }
    CHECK(front.front().ridge == 0);
    CHECK(front.back().distance < 0.1 * front.front().distance);
}
