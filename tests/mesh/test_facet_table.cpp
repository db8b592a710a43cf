#include "mesh/facet_table.h"

#include <catch2/catch.hpp>

using namespace tissue;

namespace {

/// Number of the corner with weights (i, j, parts - i - j) / parts.
Eigen::Index corner_at(const NodeField& corners, int i, int j, int parts) {
    for (Eigen::Index v = 0; v < corners.rows(); ++v)
        if ((parts * corners.row(v) - Eigen::RowVector3d(i, j, parts - i - j)).norm() < 1e-9) return v;
    FAIL("no corner there");
    return 0;
}

}  // namespace

TEST_CASE("a facet table is linear in each part of a facet", "[solid]") {
    for (int parts : {1, 2, 3, 6}) {
        const NodeField corners = FacetTable::corners(parts);
        REQUIRE(corners.rows() == FacetTable::corner_count(parts));
        CHECK(FacetTable::parts_of(corners.rows()) == parts);
        const FacetTable table{NodeField::Random(2, corners.rows())};
        // at the mean of some corners of a part, repeats allowed, the value is the mean of theirs
        const auto check = [&](std::initializer_list<std::pair<int, int>> of) {
            Eigen::Vector3d weight = Eigen::Vector3d::Zero();
            double mean = 0;
            for (const auto& [i, j] : of) {
                const Eigen::Index v = corner_at(corners, i, j, parts);
                weight += corners.row(v).transpose() / static_cast<double>(of.size());
                mean += table.value(1, v) / static_cast<double>(of.size());
            }
            CHECK(table.at(1, weight) == Approx(mean).margin(1e-12));
        };
        for (int i = 0; i < parts; ++i)
            for (int j = 0; i + j < parts; ++j) {
                check({{i, j}});
                check({{i, j}, {i + 1, j}});
                check({{i, j}, {i, j + 1}});
                check({{i + 1, j}, {i, j + 1}});
                check({{i, j}, {i + 1, j}, {i, j + 1}});
                check({{i, j}, {i + 1, j}, {i + 1, j}, {i, j + 1}});
                if (i + j < parts - 1) check({{i + 1, j + 1}, {i + 1, j}, {i + 1, j}, {i, j + 1}});
            }
        check({{parts, 0}});
        check({{0, parts}});
        // weights that sum to more than 1 by rounding
        CHECK(table.at(1, Eigen::Vector3d(1, 1e-16, 0)) == Approx(table.value(1, corner_at(corners, parts, 0, parts))));
    }
    CHECK(FacetTable::parts_of(4) == 0);
    CHECK(FacetTable().at(3, Eigen::Vector3d(1, 0, 0)) == 0);
}
