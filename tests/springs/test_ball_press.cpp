// A rigid ball on a law in space that knows discs of several radii.
#include "springs/ball_press.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../example.h"
#include "../mesh/embedded_block.h"
#include "../refusal.h"
#include "../solid_law_example.h"
#include "error.h"
#include "springs/energy_law.h"
#include "springs/law_at_radius.h"
#include "springs/law_kernel.h"
#include "springs/law_press.h"
#include "springs/press.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const Eigen::Vector3d place(0.021, 0.033, 0.02), inward(0, 0, -1);
constexpr double ball_m = 0.010;

/// A law of a disc of 7 mm that knows discs from 4 to 10 mm.
TissueModel several() {
    TissueModel model = solid_law_example(embedded_block(Lattice{{5, 6, 2}, {0.05, 0.06, 0.02}}));
    LawModel& law = *model.energy_law;
    law.terms = {"spring.all", "contact.normal.size", "contact.hardening.size"};
    law.coefficients = Eigen::Vector3d(0, 0.3, 1.5);
    law.sizes.radii_m = with_means({0.004, 0.007, 0.010});
    for (double x : {-0.05, 0.03, 0.02, 0.01, 0.06}) law.sizes.correction.push_back({NodeField::Constant(model.mesh.facets.rows(), 10, x)});
    return model;
}

/// What is stored where a disc of that radius is pushed so [J]; below 4 mm as on a half space, its correction in proportion.
double energy_J(const TissueModel& model, double radius_m, const Point& push_m) {
    const double least_m = 0.004, times = std::min(1.0, radius_m / least_m);
    LawModel law = law_at_radius(*model.energy_law, std::max(radius_m, least_m));
    law.patch = resized(law.patch, {}, {}, std::log(times));
    law.disc_radius_m *= times;
    law.disc.correction.value *= times;
    const TissueEnergy tissue(model.mesh, law.incompressible);
    const auto kernel = make_contact_kernel(model.mesh, law);
    return PressSolver(tissue, *kernel).press(law.constants, ContactSpring(kernel->rows_at(place), law.patch), push_m).energy_J;
}

}  // namespace

TEST_CASE("a ball's contact stores on a half space what Sneddon's sphere does", "[solid]") {
    const TissueModel model = several();
    const BallPress ball(model.mesh, *model.energy_law, ball_m);
    for (double x : {0.05, 0.2, 0.4, 0.6, 0.7, 0.833}) {  // of contact radius over the ball's, of the sphere
        const double log = std::log((1 + x) / (1 - x)), depth_m = ball_m * x / 2 * log, force = (1 + x * x) / 2 * log - x;  // over E* R^2
        const auto stored = [&](double d_m) { return 8.0 / 15 * ball.contact_radius_m(place, d_m * inward) * d_m * d_m; };  // over E*: the tapered disc's
        const double h = 1e-6 * depth_m;
        CHECK((stored(depth_m + h) - stored(depth_m - h)) / (2 * h) / (ball_m * ball_m) == Approx(force).epsilon(1e-3));
    }
    CHECK(ball.contact_radius_m(place, -0.001 * inward) == 0);
    CHECK(ball.contact_radius_m(place, Eigen::Vector3d(0.001, 0, 0)) == 0);
}

TEST_CASE("a ball's force is what its energy grows by, straight in and tilted", "[solid]") {
    const TissueModel model = several();
    const BallPress ball(model.mesh, *model.energy_law, ball_m);
    for (const Eigen::Vector3d& direction : {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.36, 0.48, -0.8)})
        for (double depth_m : {0.0004, 0.0025, 0.004}) {
            const Equilibrium answer = ball.at(place, depth_m * direction);
            REQUIRE(answer);
            const auto stored = [&](double d_m) { return energy_J(model, ball.contact_radius_m(place, d_m * direction), d_m * direction); };
            const double h = 1e-3 * depth_m, grown = (stored(depth_m + h) - stored(depth_m - h)) / (2 * h);
            INFO(depth_m << " m along " << direction.transpose());
            CHECK(answer.contact_force.dot(direction) == Approx(grown).epsilon(1e-3));
        }
}

TEST_CASE("a ball's force begins at none, as its depth to the power of 1.5, and does not jump where its contact is as small as the smallest disc", "[solid]") {
    const TissueModel model = several();
    const BallPress ball(model.mesh, *model.energy_law, ball_m);
    const auto force = [&](double depth_m) { return ball.at(place, depth_m * inward).contact_force.dot(inward); };
    CHECK(std::log(force(2e-5) / force(1e-5)) / std::log(2.0) == Approx(1.5).margin(0.05));
    const double smallest_m = 0.004 * 0.004 / ball_m * (1 + 0.004 * 0.004 / ball_m / ball_m / 7);  // to first order
    const double before = force(0.99 * smallest_m), after = force(1.01 * smallest_m);
    CHECK(after / before == Approx(std::pow(1.01 / 0.99, 1.5)).epsilon(0.02));
    CHECK(force(-0.001) == 0);
    CHECK(force(0) == 0);
}

TEST_CASE("a ball is refused where the law knows no disc as large as its contact, and where there is no disc", "[solid]") {
    const TissueModel model = several();
    const BallPress ball(model.mesh, *model.energy_law, ball_m);
    CHECK_NOTHROW(ball.at(place, 0.0099 * inward));
    for (double depth_m : {0.0101, 0.05, 0.2}) CHECK_THAT(refusal<ContactTooLargeError>([&] { ball.at(place, depth_m * inward); }), Contains("a ball of 10 mm pushed") && Contains("more than half in"));
    const BallPress large(model.mesh, *model.energy_law, 0.02);
    CHECK_THAT(refusal<ContactTooLargeError>([&] { large.at(place, 0.006 * inward); }), Contains("a ball of 20 mm pushed 6 mm in") && Contains("discs of 10 mm at the most"));
    CHECK_THAT(refusal<MismatchError>([&] { BallPress(model.mesh, *model.energy_law, 0); }), Contains("needs a radius > 0"));
    CHECK_THAT(refusal<MismatchError>([&] { BallPress(model.mesh, *solid_law_example(model.mesh).energy_law, ball_m); }), Contains("not of 7 mm alone"));
    CHECK_THROWS_AS(BallPress(model.mesh, *model.energy_law, std::nan("")), MismatchError);
}
