#include "cases/measured_doubts.h"

#include <catch2/catch.hpp>

#include "../measured_example.h"
#include "mesh/outline.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// Ten pushes a centimetre apart, the set of them made again and again, and stiffness as of the study's own tissue.
MeasuredTable sessions(int repeats) {
    const Outline outline(measured_mesh());
    MeasuredTable table{"data.csv", "", {}};
    for (int again = 0; again < repeats; ++again)
        for (int k = 0; k < 10; ++k) {
            const double arc = 0.05 + 0.01 * k;
            const Eigen::Vector2d push = 0.005 * outline.inward_normal(arc);
            table.rows.push_back({static_cast<int>(table.rows.size()) + 2, outline.position(arc), push, 0.5 * measured_study().modulus_N_m() * push, "p" + std::to_string(k), ""});
        }
    return table;
}

}  // namespace

TEST_CASE("measurements of the study's own tissue are not doubted", "[measured]") {
    MeasuredTable table = sessions(3);
    for (std::size_t i = 0; i < table.rows.size(); ++i) table.rows[i].force_N *= 1 + 0.03 * std::sin(12.9898 * static_cast<double>(i));  // noise that goes nowhere
    CHECK(measured_doubts(measured_study(), table).empty());
}

TEST_CASE("a factor of a thousand in force or displacement is doubted, whichever way", "[measured]") {
    for (const double factor : {1e3, 1e-3}) {
        MeasuredTable table = sessions(1);
        for (MeasuredRow& row : table.rows) row.force_N *= factor;
        const auto doubts = measured_doubts(measured_study(), table);
        REQUIRE(doubts.size() == 1);
        CHECK_THAT(doubts[0], Contains("is a unit in the header wrong"));
    }
}

TEST_CASE("rows that contradict each other are named, the first three of many", "[measured]") {
    MeasuredTable table = sessions(2);
    for (MeasuredRow& row : table.rows) row.push.clear();
    table.rows[12].force_N *= 2;
    const auto doubts = measured_doubts(measured_study(), table);
    REQUIRE(doubts.size() == 1);
    CHECK_THAT(doubts[0], Contains("lines 4 and 14") && Contains("50 %"));
    for (std::size_t i = 10; i < 20; ++i) table.rows[i].force_N = 1.5 * table.rows[i - 10].force_N;
    const auto many = measured_doubts(measured_study(), table);
    REQUIRE(many.size() == 4);
    CHECK_THAT(many[3], Contains("7 more"));
}

TEST_CASE("a sensor that drifts shows in repeats of one push", "[measured]") {
    for (const double drift : {0.1, -0.1}) {
        MeasuredTable table = sessions(4);
        for (std::size_t i = 0; i < table.rows.size(); ++i)
            table.rows[i].force_N *= 1 + drift * static_cast<double>(i) / static_cast<double>(table.rows.size() - 1) + 0.005 * std::sin(12.9898 * static_cast<double>(i));
        const auto doubts = measured_doubts(measured_study(), table);
        REQUIRE(doubts.size() == 1);
        CHECK_THAT(doubts[0], Contains("drift") && (drift > 0 ? Contains("grow by 9 %") || Contains("grow by 10 %") : Contains("fall by 10 %") || Contains("fall by 11 %")));  // of the mean, 1 + drift / 2
    }
}
