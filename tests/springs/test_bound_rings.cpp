// Rings of a contact, each bound where the contact reaches it.
#include "springs/bound_rings.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace tissue;

namespace {

constexpr double largest_m = 0.010;
const Eigen::Vector3d along(0.6, 0.8, 0);

/// Changes the contact's radius in 1000 steps. The tool's displacement is linear in the squared radius, as for a ball
/// on a straight path.
void lead(BoundRings& rings, double from_m, double to_m, const Eigen::Vector3d& place_m, double by_square_1_m) {
    for (int k = 1; k <= 1000; ++k) {
        const double a = from_m + (to_m - from_m) * k / 1000;
        rings.follow(a, place_m + by_square_1_m * (a * a - from_m * from_m) * along);
    }
}

}  // namespace

TEST_CASE("a contact that grows on a straight path is stretched by 2/3 of it; the stretch vanishes on return", "[contact]") {
    BoundRings rings(largest_m, 1e-4, Eigen::Vector3d::Zero());
    CHECK(rings.mean_m().isZero());
    const double a = 0.0083;
    lead(rings, 1e-4, a, Eigen::Vector3d::Zero(), 50);
    const Eigen::Vector3d tool = 50 * (a * a - 1e-8) * along;
    CHECK((tool - rings.mean_m() - 2.0 / 3 * tool).norm() < 2e-3 * tool.norm());
    // on the way back: as at the same radius before
    lead(rings, a, 0.005, tool, 50);
    const Eigen::Vector3d back = 50 * (0.005 * 0.005 - 1e-8) * along;
    CHECK((back - rings.mean_m() - 2.0 / 3 * back).norm() < 5e-3 * back.norm());
    lead(rings, 0.005, 1e-4, back, 50);
    CHECK(rings.mean_m().norm() < 1e-3 * tool.norm());
}

TEST_CASE("a contact of constant radius is stretched by the whole path; growth afterwards keeps its force", "[contact]") {
    BoundRings rings(largest_m, 0.004, Eigen::Vector3d::Zero());
    for (int k = 0; k < 100; ++k) rings.follow(0.004, 0.002 * k / 99 * along);
    CHECK(rings.mean_m().isZero());
    for (int k = 1; k <= 100; ++k) rings.follow(0.004 + 0.004 * k / 100, 0.002 * along);
    // half of its rings are not stretched, so the force is unchanged
    CHECK((0.002 * along - rings.mean_m()).norm() * 0.008 == Approx(0.002 * 0.004).epsilon(2e-2));
    // shrinking releases these rings, and the stretch is the earlier one again
    rings.follow(0.004, 0.002 * along);
    CHECK((0.002 * along - rings.mean_m()).norm() == Approx(0.002).epsilon(2e-2));
}

TEST_CASE("a contact that is stretched by more than its radius slips by the excess", "[contact]") {
    BoundRings rings(largest_m, 0.003, Eigen::Vector3d::Zero());
    rings.follow(0.003, 0.005 * along);
    CHECK((0.005 * along - rings.mean_m()).norm() == Approx(0.003));
    rings.follow(0.001, 0.005 * along);
    CHECK((0.005 * along - rings.mean_m()).norm() == Approx(0.001));
    rings.follow(0.0, 0.005 * along);
    CHECK((0.005 * along - rings.mean_m()).norm() < 1e-12);
    // to a radius above largest_m: the last ring extends to it
    for (int k = 1; k <= 100; ++k) rings.follow(0.0002 * k, (0.005 + 0.0001 * k) * along);
    const double stretch_m = (0.015 * along - rings.mean_m()).norm();
    CHECK(stretch_m > 0.003);
    CHECK(stretch_m < 0.008);
}
