// Contact parameters of a disc before training. test_solid_energy_model.cpp checks them in series with a lattice.
#include "springs/disc_rows.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../tolerances.h"
#include "springs/polar_points.h"

using namespace tissue;
using Catch::Detail::Approx;

namespace {

constexpr double E = 4500, h = 0.010;

/// Contact parameters in units of E R, 1 / (E R^3) and E.
ContactParameters::Start rows(double radius_in_edges) {
    const double R = radius_in_edges * h, ER3 = E * R * R * R;
    ContactParameters::Start unit;
    unit << E * R, E * R, E * R, E * R, 1 / ER3, 1 / ER3, E;
    return start_of_disc(E, R, h).array().exp() / unit.array();
}

}  // namespace

TEST_CASE("contact parameters of a small disc alone have the half space's stiffness and force shares") {
    // sum share phi^2 over the points under the disc and beyond it: ratio of the imprint rows' stiffness against d to
    // their parameter (springs/polar_points.h)
    constexpr double imprint_normal = 0.6022, imprint_tangent = 0.6028;
    const ContactParameters::Start at = rows(1e-6);
    CHECK(at[0] == Approx(0.55 * 64 / 45).epsilon(1e-4));
    CHECK(at[1] == Approx(0.36 * 128 / 135).epsilon(1e-4));
    CHECK(at[0] + imprint_normal * at[2] == Approx(64.0 / 45).epsilon(1e-3));
    CHECK(at[1] + imprint_tangent * at[3] == Approx(128.0 / 135).epsilon(1e-3));
}

TEST_CASE("contact parameters at R = 0.7 h have known values and scale with modulus and size") {
    const ContactParameters::Start at = rows(0.7);
    const double wanted[] = {1.634, 0.648, 3.13, 2.45, 0.588, 0.0735, 0.782};
    for (int m = 0; m < ContactParameters::disc_rows; ++m) CHECK(at[m] == Approx(wanted[m]).epsilon(5e-3));
    const ContactParameters::Start stiffer = start_of_disc(2 * E, 0.7 * h, h) - start_of_disc(E, 0.7 * h, h), larger = start_of_disc(E, 1.4 * h, 2 * h) - start_of_disc(E, 0.7 * h, h);
    const double by_modulus[] = {1, 1, 1, 1, -1, -1, 1}, by_size[] = {1, 1, 1, 1, -3, -3, 0};
    for (int m = 0; m < ContactParameters::disc_rows; ++m) {
        CHECK(stiffer[m] == Approx(by_modulus[m] * std::log(2)).margin(tolerance::rounding));
        CHECK(larger[m] == Approx(by_size[m] * std::log(2)).margin(tolerance::rounding));
    }
    for (int m = 0; m < ContactParameters::disc_rows; ++m) CHECK(rows(4)[m] == Approx(rows(2.5)[m]).epsilon(tolerance::rounding));
    for (const double none : {0.0, -h, std::nan("")}) {
        CHECK(start_of_disc(E, none, h).hasNaN());
        CHECK(start_of_disc(E, h, none).hasNaN());
    }
    CHECK((rows(2.5).array().head(4) > rows(1.5).array().head(4)).all());
    CHECK((rows(1.5).array().head(4) > rows(1).array().head(4)).all());
    CHECK((rows(1).array().head(4) > rows(0.1).array().head(4)).all());
}

TEST_CASE("contact parameters are continuous at the radius where the mean starts to grow with the disc") {
    constexpr double knot = PolarPoints::mean_edges / PolarPoints::mean_radii;
    CHECK((rows(knot * (1 + 1e-9)) - rows(knot * (1 - 1e-9))).norm() < 1e-7);
}
