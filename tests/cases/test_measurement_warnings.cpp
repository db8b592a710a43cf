#include "cases/measurement_warnings.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <ctime>
#include <random>

#include "../measured_example.h"
#include "mesh/outline.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// Ten indentations one centimetre apart, repeated `repeats` times, with the stiffness 0.5 E2 of the study's own
/// tissue.
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

TEST_CASE("measurements with the stiffness of the study's tissue cause no warning", "[measured]") {
    MeasuredTable table = sessions(3);
    // noise without drift
    for (std::size_t i = 0; i < table.rows.size(); ++i) table.rows[i].force_N *= 1 + 0.03 * std::sin(12.9898 * static_cast<double>(i));
    CHECK(measurement_warnings(measured_study(), table).empty());
}

TEST_CASE("measured forces a thousand times too large or too small cause a warning about units", "[measured]") {
    for (const double factor : {1e3, 1e-3}) {
        MeasuredTable table = sessions(1);
        for (MeasuredRow& row : table.rows) row.force_N *= factor;
        const auto doubts = measurement_warnings(measured_study(), table);
        REQUIRE(doubts.size() == 1);
        CHECK_THAT(doubts[0], Contains("is a unit in the header wrong"));
    }
}

TEST_CASE("measured histories with forces a thousand times too small cause a warning about units", "[measured]") {
    History history;
    history.time_s = Eigen::Vector3d(0, 0.1, 0.2);
    history.push_m = NodeField::Zero(3, 2), history.force_N = history.push_m;
    history.push_m(1, 1) = history.push_m(2, 1) = -0.005;
    history.force_N = 0.5 * measured_study().modulus_N_m() * history.push_m;
    CHECK(measurement_warnings(measured_study(), {history}).empty());
    history.force_N *= 1e-3;
    REQUIRE(measurement_warnings(measured_study(), {history}).size() == 1);
    CHECK_THAT(measurement_warnings(measured_study(), {history})[0], Contains("is a unit in the header wrong"));
    CHECK(measurement_warnings(measured_study(), std::vector<History>()).empty());
}

TEST_CASE("rows that contradict each other are listed by line and only the first three of many", "[measured]") {
    MeasuredTable table = sessions(2);
    for (MeasuredRow& row : table.rows) row.push.clear();
    table.rows[12].force_N *= 2;
    const auto doubts = measurement_warnings(measured_study(), table);
    REQUIRE(doubts.size() == 1);
    CHECK_THAT(doubts[0], Contains("lines 4 and 14") && Contains("50 %"));
    for (std::size_t i = 10; i < 20; ++i) table.rows[i].force_N = 1.5 * table.rows[i - 10].force_N;
    const auto many = measurement_warnings(measured_study(), table);
    REQUIRE(many.size() == 4);
    CHECK_THAT(many[3], Contains("7 more"));
}

TEST_CASE("contradictions equal those of an exhaustive comparison of all pairs of rows", "[measured]") {
    const Study study = measured_study();
    std::mt19937 random(2026);
    const auto drawn = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    int contradicted = 0;
    for (int draw = 0; draw < 300; ++draw) {
        MeasuredTable table{"data.csv", "", {}};
        const int rows = 2 + drawn(60);
        for (int i = 0; i < rows; ++i) {
            // near the limits of "same contact" and "same displacement"
            const Eigen::Vector2d contact(0.0001 * drawn(4), 0.05 + 0.0001 * drawn(4)), push(0.005 + 0.0001 * drawn(4), 0.0001 * drawn(4));
            table.rows.push_back({i + 2, contact, push, study.modulus_N_m() * (1 + 0.125 * drawn(4)) * push, "", ""});
        }
        std::vector<MeasuredRow> sorted = table.rows;
        std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.contact_m.x() < b.contact_m.x(); });
        std::vector<std::string> expected;
        int more = -3;
        for (std::size_t i = 0; i < sorted.size(); ++i) {
            double most = 0.3;
            const MeasuredRow *a = &sorted[i], *worst = nullptr;
            for (std::size_t k = i + 1; k < sorted.size(); ++k) {
                const MeasuredRow* b = &sorted[k];
                if ((a->contact_m - b->contact_m).norm() > 0.0002 || (a->displacement_m - b->displacement_m).norm() > 0.05 * std::min(a->displacement_m.norm(), b->displacement_m.norm())) continue;
                const double off = (a->force_N - b->force_N).norm() / std::max(a->force_N.norm(), b->force_N.norm());
                if (off > most) worst = b, most = off;
            }
            if (worst && ++more <= 0) expected.push_back(fmt::format("lines {} and {}: forces of the same displacement at the same contact differ by {:.0f} %", std::min(a->line, worst->line), std::max(a->line, worst->line), 100 * most));
        }
        if (more > 0) expected.push_back(fmt::format("{} more pairs of lines differ likewise", more));
        contradicted += more > 0;
        REQUIRE(measurement_warnings(study, table) == expected);
    }
    CHECK(contradicted > 50);
}

TEST_CASE("60000 measured rows are checked in less than 4 s of processor time", "[measured]") {
    const std::string kind = GENERATE("one side", "one contact", "one contact, ever deeper");
    INFO(kind);
    const Study study = measured_study();
    MeasuredTable table{"data.csv", "", {}};
    constexpr int count = 60000;
    for (int i = 0; i < count; ++i) {
        const double y = kind == "one side" ? 0.01 + 0.08 * i / count : 0.05, deep = kind == "one contact, ever deeper" ? 0.001 + 0.009 * i / count : 0.005;
        const Eigen::Vector2d push(deep, 0);
        table.rows.push_back({i + 2, {0, y}, push, study.modulus_N_m() * (1 + 0.05 * std::sin(12.9898 * i)) * push, "", ""});
    }
    const std::clock_t began = std::clock();
    CHECK(measurement_warnings(study, table).empty());
    // of this process; comparing all pairs takes some 8 s, and far more under a sanitizer
    CHECK(static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC < 4);
}

TEST_CASE("drift of a force sensor in repeated indentations causes a warning", "[measured]") {
    for (const double drift : {0.1, -0.1}) {
        MeasuredTable table = sessions(4);
        for (std::size_t i = 0; i < table.rows.size(); ++i)
            table.rows[i].force_N *= 1 + drift * static_cast<double>(i) / static_cast<double>(table.rows.size() - 1) + 0.005 * std::sin(12.9898 * static_cast<double>(i));
        const auto doubts = measurement_warnings(measured_study(), table);
        REQUIRE(doubts.size() == 1);
        // relative to the mean factor 1 + drift / 2
        CHECK_THAT(doubts[0], Contains("drift") && (drift > 0 ? Contains("rise by 9 %") || Contains("rise by 10 %") : Contains("fall by 10 %") || Contains("fall by 11 %")));
    }
}
