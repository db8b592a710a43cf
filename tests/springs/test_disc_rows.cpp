// Rows of a disc's contact before anything is learned; in series with a lattice: test_solid_law.cpp.
#include "springs/disc_rows.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../tolerances.h"
#include "springs/polar_points.h"

using namespace tissue;
using Catch::Detail::Approx;

namespace {

constexpr double E = 4500, h = 0.010;

/// In units of E R, 1 / (E R^3) and E.
PatchLaw::Start rows(double radius_in_edges) {
    const double R = radius_in_edges * h, ER3 = E * R * R * R;
    PatchLaw::Start unit;
    unit << E * R, E * R, E * R, E * R, 1 / ER3, 1 / ER3, E;
    return start_of_disc(E, R, h).array().exp() / unit.array();
}

}  // namespace

TEST_CASE("a small disc's rows alone are as stiff as tissue, and share the force as on any lattice") {
    // of the points under the disc and beyond it, sum share phi^2: what the imprint rows weigh against d (springs/polar_points.h)
    constexpr double imprint_normal = 0.6022, imprint_tangent = 0.6028;
    const PatchLaw::Start at = rows(1e-6);
    CHECK(at[0] == Approx(0.55 * 64 / 45).epsilon(1e-4));
    CHECK(at[1] == Approx(0.36 * 128 / 135).epsilon(1e-4));
    CHECK(at[0] + imprint_normal * at[2] == Approx(64.0 / 45).epsilon(1e-3));
    CHECK(at[1] + imprint_tangent * at[3] == Approx(128.0 / 135).epsilon(1e-3));
}

TEST_CASE("a disc's rows at the radius of most studies, and how they scale") {
    const PatchLaw::Start at = rows(0.7);
    const double wanted[] = {1.634, 0.648, 3.13, 2.45, 0.588, 0.0735, 0.782};
    for (int m = 0; m < PatchLaw::disc_rows; ++m) CHECK(at[m] == Approx(wanted[m]).epsilon(5e-3));
    const PatchLaw::Start stiffer = start_of_disc(2 * E, 0.7 * h, h) - start_of_disc(E, 0.7 * h, h), larger = start_of_disc(E, 1.4 * h, 2 * h) - start_of_disc(E, 0.7 * h, h);
    const double by_modulus[] = {1, 1, 1, 1, -1, -1, 1}, by_size[] = {1, 1, 1, 1, -3, -3, 0};
    for (int m = 0; m < PatchLaw::disc_rows; ++m) {
        CHECK(stiffer[m] == Approx(by_modulus[m] * std::log(2)).margin(tolerance::rounding));
        CHECK(larger[m] == Approx(by_size[m] * std::log(2)).margin(tolerance::rounding));
    }
    for (int m = 0; m < PatchLaw::disc_rows; ++m) CHECK(rows(4)[m] == Approx(rows(2.5)[m]).epsilon(tolerance::rounding));
    for (const double none : {0.0, -h, std::nan("")}) {
        CHECK(start_of_disc(E, none, h).hasNaN());
        CHECK(start_of_disc(E, h, none).hasNaN());
    }
    CHECK((rows(2.5).array().head(4) > rows(1.5).array().head(4)).all());
    CHECK((rows(1.5).array().head(4) > rows(1).array().head(4)).all());
    CHECK((rows(1).array().head(4) > rows(0.1).array().head(4)).all());
}

TEST_CASE("a disc's rows are continuous where the mean begins to grow with the disc") {
    constexpr double knot = PolarPoints::mean_edges / PolarPoints::mean_radii;
    CHECK((rows(knot * (1 + 1e-9)) - rows(knot * (1 - 1e-9))).norm() < 1e-7);
}
