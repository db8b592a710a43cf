#include "mesh/facet_table.h"

#include <catch2/catch.hpp>

using namespace tissue;

TEST_CASE("a table over facets is linear in each part, and the same from both sides of an edge between parts", "[solid]") {
    for (int parts : {1, 2, 3, 6}) {
        const NodeField corners = FacetTable::corners(parts);
        REQUIRE(corners.rows() == FacetTable::corner_count(parts));
        CHECK(FacetTable::parts_of(corners.rows()) == parts);
        const Eigen::Vector3d slope(0.3, -1.1, 2.7);
        FacetTable linear{NodeField(2, corners.rows())}, single{NodeField::Zero(1, corners.rows())};
        linear.value.row(0).setZero();
        linear.value.row(1) = (corners * slope).transpose();
        for (Eigen::Index v = 0; v < corners.rows(); ++v) CHECK(linear.at(1, corners.row(v).transpose()) == Approx(linear.value(1, v)).margin(1e-12));
        for (double a = 0; a <= 1; a += 0.05)
            for (double b = 0; a + b <= 1; b += 0.05) {
                const Eigen::Vector3d weight(a, b, 1 - a - b);
                CHECK(linear.at(1, weight) == Approx(weight.dot(slope)).margin(1e-12));
                CHECK(linear.at(0, weight) == Approx(0).margin(1e-12));
            }
        single.value(0, corners.rows() / 2) = 1;  // one corner alone: a pyramid
        for (double a = 0.01; a < 0.98; a += 0.013) {
            const Eigen::Vector3d here(a, 0.4 * (1 - a), 0.6 * (1 - a)), there = here + 1e-7 * Eigen::Vector3d(1, -2, 1);
            CHECK(std::abs(single.at(0, here) - single.at(0, there)) < 1e-5);
        }
    }
    CHECK(FacetTable::parts_of(4) == 0);
    CHECK(FacetTable().at(3, Eigen::Vector3d(1, 0, 0)) == 0);
}
