#include "mesh/facet_table.h"

#include <catch2/catch.hpp>

using namespace tissue;

namespace {

/// The number of the corner with these weights, in parts.
Eigen::Index corner_at(const NodeField& corners, int i, int j, int parts) {
    for (Eigen::Index v = 0; v < corners.rows(); ++v)
        if ((parts * corners.row(v) - Eigen::RowVector3d(i, j, parts - i - j)).norm() < 1e-9) return v;
    FAIL("no corner there");
    return 0;
}

}  // namespace

TEST_CASE("a table over facets is linear in each of a facet's parts", "[solid]") {
    for (int parts : {1, 2, 3, 6}) {
        const NodeField corners = FacetTable::corners(parts);
        REQUIRE(corners.rows() == FacetTable::corner_count(parts));
        CHECK(FacetTable::parts_of(corners.rows()) == parts);
        const FacetTable table{NodeField::Random(2, corners.rows())};
        const auto check = [&](std::initializer_list<std::pair<int, int>> of) {  // the mean of some corners of a part, one of them perhaps twice, at the mean of their places
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
        // where rounding makes the weights sum to more than 1
        CHECK(table.at(1, Eigen::Vector3d(1, 1e-16, 0)) == Approx(table.value(1, corner_at(corners, parts, 0, parts))));
    }
    CHECK(FacetTable::parts_of(4) == 0);
    CHECK(FacetTable().at(3, Eigen::Vector3d(1, 0, 0)) == 0);
}
