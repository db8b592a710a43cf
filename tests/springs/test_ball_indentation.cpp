// A rigid ball on an energy model in space for discs of several radii.
#include "springs/ball_indentation.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../example.h"
#include "../refusal.h"
#include "several_discs.h"
#include "error.h"
#include "springs/energy_model_terms.h"
#include "springs/energy_model_at_radius.h"
#include "springs/energy_model_kernel.h"
#include "springs/indentation_solver.h"
#include "springs/equilibrium_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const Eigen::Vector3d place(0.021, 0.033, 0.02), inward(0, 0, -1);
constexpr double ball_m = 0.010;

/// Energy [J] of the equilibrium under a ball's contact of radius radius_m at tool displacement push_m.
double energy_J(const TissueModel& model, double radius_m, const Point& push_m) {
    const EnergyModel energy_model = energy_model_of_ball(*model.energy_model, ball_m, radius_m);
    const TissueEnergy tissue(model.mesh, energy_model);
    const auto kernel = make_contact_kernel(model.mesh, energy_model);
    return EquilibriumSolver(tissue, *kernel).indent(energy_model.constants, ContactSpring(kernel->rows_at(place), energy_model.patch), push_m).energy_J;
}

}  // namespace

TEST_CASE("on a half space the energy of a ball's contact has the force of Sneddon's sphere as derivative", "[solid]") {
    const TissueModel model = several_discs();
    const BallIndentation ball(model.mesh, *model.energy_model, ball_m);
    for (double x : {0.05, 0.2, 0.4, 0.6, 0.7, 0.833}) {  // Sneddon's contact radius over the ball's radius
        const double log = std::log((1 + x) / (1 - x)), depth_m = ball_m * x / 2 * log, force = (1 + x * x) / 2 * log - x;  // over E* R^2
        // over E*; of the tapered disc
        const auto stored = [&](double d_m) { return 8.0 / 15 * ball.contact_radius_m(place, d_m * inward) * d_m * d_m; };
        const double h = 1e-6 * depth_m;
        CHECK((stored(depth_m + h) - stored(depth_m - h)) / (2 * h) / (ball_m * ball_m) == Approx(force).epsilon(1e-3));
    }
    CHECK(ball.contact_radius_m(place, -0.001 * inward) == 0);
    CHECK(ball.contact_radius_m(place, Eigen::Vector3d(0.001, 0, 0)) == 0);
}

TEST_CASE("a ball's normal force is the derivative of its energy; its tangential force is the bound contact's", "[solid]") {
    const TissueModel model = several_discs();
    const BallIndentation ball(model.mesh, *model.energy_model, ball_m);
    for (double depth_m : {0.0004, 0.0025, 0.004}) {
        const Equilibrium answer = ball.at(place, depth_m * inward);
        REQUIRE(answer);
        const auto stored = [&](double d_m) { return energy_J(model, ball.contact_radius_m(place, d_m * inward), d_m * inward); };
        const double h = 1e-3 * depth_m, grown = (stored(depth_m + h) - stored(depth_m - h)) / (2 * h);
        INFO(depth_m << " m");
        CHECK(answer.contact_force.dot(inward) == Approx(grown).epsilon(1e-3));

        // On a slightly tilted path two thirds of the tangential displacement stretch the final contact. The tangential
        // force is that part times the stiffness.
        const Eigen::Vector3d across(0.6, 0.8, 0);
        const double along_m = 0.01 * depth_m, radius_m = ball.contact_radius_m(place, depth_m * inward);
        const auto to_side = [&](double s_m) { return energy_J(model, radius_m, depth_m * inward + s_m * across); };
        const double stiffness = (to_side(h) - 2 * to_side(0) + to_side(-h)) / (h * h), skew = (to_side(h) - to_side(-h)) / (2 * h);
        const Equilibrium tilted = ball.at(place, depth_m * inward + along_m * across);
        REQUIRE(tilted);
        CHECK((tilted.contact_force.dot(across) - skew) / (stiffness * along_m) == Approx(2.0 / 3).epsilon(0.03));
    }
}

TEST_CASE("on stiff tissue a bound contact is about 15/8 as stiff along the surface as a disc's", "[solid]") {
    TissueModel model = several_discs();
    model.energy_model->constants *= 1e4;
    const EnergyModel disc = energy_model_of_contact(*model.energy_model, 0.007), ball = energy_model_of_ball(*model.energy_model, ball_m, 0.007);
    const auto stiffness = [&](const EnergyModel& energy_model, const Eigen::Vector3d& way) {
        return IndentationSolver(model.mesh, energy_model).at(place, 1e-6 * way).contact_force.norm() / 1e-6;
    };
    const double along = stiffness(ball, Eigen::Vector3d::UnitX()) / stiffness(disc, Eigen::Vector3d::UnitX());
    CHECK(along > 1.7);  // 1.71 for the imprint's rows, whose profile does not taper
    CHECK(along < 2.1);
    CHECK(stiffness(ball, inward) == Approx(stiffness(disc, inward)).epsilon(1e-6));
}

TEST_CASE("a ball's force starts as depth^1.5 and is continuous where its contact has the smallest disc's radius", "[solid]") {
    const TissueModel model = several_discs();
    const BallIndentation ball(model.mesh, *model.energy_model, ball_m);
    const auto force = [&](double depth_m) { return ball.at(place, depth_m * inward).contact_force.dot(inward); };
    CHECK(std::log(force(2e-5) / force(1e-5)) / std::log(2.0) == Approx(1.5).margin(0.05));
    const double smallest_m = 0.004 * 0.004 / ball_m * (1 + 0.004 * 0.004 / ball_m / ball_m / 7);  // to first order
    const double before = force(0.99 * smallest_m), after = force(1.01 * smallest_m);
    CHECK(after / before == Approx(std::pow(1.01 / 0.99, 1.5)).epsilon(0.02));
    CHECK(force(-0.001) == 0);
    CHECK(force(0) == 0);
}

TEST_CASE("a ball is refused if its contact exceeds the largest disc or it is half in or there is one disc", "[solid]") {
    const TissueModel model = several_discs();
    const BallIndentation ball(model.mesh, *model.energy_model, ball_m);
    CHECK_NOTHROW(ball.at(place, 0.0099 * inward));
    for (double depth_m : {0.0101, 0.05, 0.2}) CHECK_THAT(refusal<ContactTooLargeError>([&] { ball.at(place, depth_m * inward); }), Contains("a ball of 10 mm displaced") && Contains("more than half in"));
    const BallIndentation large(model.mesh, *model.energy_model, 0.02);
    CHECK_THAT(refusal<ContactTooLargeError>([&] { large.at(place, 0.006 * inward); }), Contains("a ball of 20 mm displaced by 6 mm") && Contains("largest disc of the training has 10 mm"));
    CHECK_THAT(refusal<MismatchError>([&] { BallIndentation(model.mesh, *model.energy_model, 0); }), Contains("must be > 0"));
    CHECK_THAT(refusal<MismatchError>([&] { BallIndentation(model.mesh, *solid_model_example(model.mesh).energy_model, ball_m); }), Contains("not only of 7 mm"));
    CHECK_THROWS_AS(BallIndentation(model.mesh, *model.energy_model, std::nan("")), MismatchError);
}
