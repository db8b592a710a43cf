#include "eval/held_out.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// FE path of a vertical indentation of the top with records at these magnitudes and stiffness `stronger` x 100 N/m.
LoadPath pushed(const std::string& name, const std::string& role, double depth_m, const std::vector<double>& magnitudes_m,
                double stronger = 1) {
    LoadPath path;
    path.name = name;
    path.role = role;
    path.contact_m = Eigen::Vector2d(0.05, 0.1);
    path.direction = Eigen::Vector2d(0, -1);
    path.depth_m = depth_m;
    path.records.push_back(measured_record(0, Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0)));
    for (double m : magnitudes_m) path.records.push_back(measured_record(m, Eigen::Vector2d(0, -stronger * 100 * m), Eigen::Vector2d(0, 0)));
    return path;
}

Cases cases_of(std::vector<LoadPath> paths) {
    Cases cases;
    cases.magnitudes_m = {0.005, 0.010};
    cases.paths = std::move(paths);
    return cases;
}

}  // namespace

TEST_CASE("discretisation error is the force difference over the force on the finer mesh per load case") {
    const DiscretisationCheck check = check_discretisation(cases_of({pushed("left", "train", 0.010, {0.0025, 0.005, 0.0075, 0.010}, 1.02),
                                                   pushed("check-left", "check", 0.010, {0.0025, 0.005, 0.0075, 0.010})}));
    CHECK(check.difference.n == 2);
    CHECK(check.difference.max == Approx(0.02).epsilon(tolerance::solve));
    CHECK(check.lost.empty());
    CHECK(check.unmatched.empty());
}

TEST_CASE("a drawn contact is compared at its depth despite rounding of the FE steps") {
    for (double depth : {0.0071, 0.00213, 0.0098765}) {
        const double counted = std::nextafter(depth, 1);
        for (const auto& [coarse_m, fine_m] : {std::pair(depth, depth), std::pair(counted, depth), std::pair(depth, counted)}) {
            const DiscretisationCheck check = check_discretisation(cases_of({pushed("held-out-0001", "held_out", depth, {depth / 2, coarse_m}, 1.01),
                                                           pushed("check-0001", "check", depth, {depth / 2, fine_m})}));
            CHECK(check.difference.n == 1);
            CHECK(check.difference.max == Approx(0.01).epsilon(tolerance::solve));
        }
    }
}

TEST_CASE("a mesh check without a path of equal contact and direction and depth is listed as unmatched") {
    const LoadPath fine = pushed("check-0007", "check", 0.008, {0.004, 0.008});
    std::vector<LoadPath> others(3, pushed("held-out-0007", "held_out", 0.008, {0.004, 0.008}));
    others[0].contact_m.x() += 1e-4;
    others[1].direction = Eigen::Vector2d(0.01, -1).normalized();
    others[2].depth_m = 0.0081;
    for (const LoadPath& other : others) {
        const DiscretisationCheck check = check_discretisation(cases_of({other, fine}));
        CHECK(check.difference.n == 0);
        CHECK(check.difference.of() == 1);
        REQUIRE(check.unmatched.size() == 1);
        CHECK_THAT(check.unmatched[0], Contains("check-0007: ") && Contains("no load path"));
        CHECK_FALSE(check.empty());
    }
}

TEST_CASE("a mesh check is lost if the finer mesh ends early and unmatched if the other does") {
    LoadPath coarse = pushed("left", "train", 0.010, {0.005}), fine = pushed("check-left", "check", 0.010, {0.005, 0.010});
    coarse.lost = "folds at 7 mm";
    DiscretisationCheck check = check_discretisation(cases_of({coarse, fine}));
    CHECK(check.difference.n == 1);
    CHECK(check.difference.no_reference == 1);
    CHECK(check.lost.empty());
    REQUIRE(check.unmatched.size() == 1);
    CHECK_THAT(check.unmatched[0], Contains("check-left: left has no record at 10 mm") && Contains("folds at 7 mm"));

    coarse = pushed("left", "train", 0.010, {0.005, 0.010});
    fine = pushed("check-left", "check", 0.010, {0.005});
    fine.lost = "folds at 8 mm";
    check = check_discretisation(cases_of({coarse, fine}));
    CHECK(check.difference.n == 1);
    CHECK(check.difference.no_reference == 1);
    CHECK(check.lost == std::vector<std::string>{"check-left: folds at 8 mm"});
    CHECK(check.unmatched.empty());

    fine.lost.clear();  // no cause is given
    check = check_discretisation(cases_of({coarse, fine}));
    REQUIRE(check.unmatched.size() == 1);
    CHECK_THAT(check.unmatched[0], Contains("check-left: it has no record at 10 mm"));
}

TEST_CASE("without mesh checks there is no discretisation error") {
    CHECK(check_discretisation(cases_of({pushed("left", "train", 0.010, {0.005, 0.010})})).empty());
}
