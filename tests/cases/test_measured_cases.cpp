#include "cases/measured_cases.h"

#include <fmt/format.h>
#include <gsl/gsl_randist.h>

#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <set>

#include "../measured_example.h"
#include "../refusal.h"
#include "../tolerances.h"
#include "error.h"
#include "mesh/outline.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// One indentation of 5 mm along the normal at each arc length, with stiffness 2 N/m.
MeasuredTable presses(const std::vector<double>& arcs) {
    const Outline outline(measured_mesh());
    MeasuredTable table{"data.csv", "made up", {}};
    for (double arc : arcs) {
        const Eigen::Vector2d push = 0.005 * outline.inward_normal(arc);
        table.rows.push_back({static_cast<int>(table.rows.size()) + 2, outline.position(arc), push, 2 * push, "", ""});
    }
    return table;
}

std::vector<double> every_cm() {
    std::vector<double> arcs;
    for (int i = 2; i <= 28; ++i) arcs.push_back(0.01 * i);
    return arcs;
}

std::map<std::string, std::vector<double>> arcs_by_role(const Cases& cases) {
    const Outline outline(measured_mesh());
    std::map<std::string, std::vector<double>> arcs;
    for (const LoadPath& path : cases.paths) arcs[path.role].push_back(outline.arc_of(path.contact_m));
    return arcs;
}

std::string refused(const MeasuredTable& table) {
    return refusal<FileError>([&] { measured_cases(measured_study(), table); });
}

}  // namespace

TEST_CASE("measurements are split by contact and seed with test contacts 2 mm from training contacts", "[measured]") {
    // three indentations a millimetre apart at every place: one contact
    std::vector<double> arcs;
    for (double arc : every_cm())
        for (double aside : {-0.001, 0.0, 0.001}) arcs.push_back(arc + aside);
    const Cases cases = measured_cases(measured_study(), presses(arcs));
    auto roles = arcs_by_role(cases);
    CHECK(cases.measurement->contacts == 27);
    CHECK(roles["held_out"].size() == 3 * 5);    // a fifth of 27, three rows each
    CHECK(roles["validation"].size() == 3 * 3);  // a tenth
    for (const char* role : {"held_out", "validation"})
        for (double arc : roles[role])
            for (double trained : roles["train"]) CHECK(std::abs(arc - trained) >= 0.002);
    Study other = measured_study();
    other.data->seed += 1;
    CHECK(arcs_by_role(measured_cases(other, presses(arcs)))["held_out"] != roles["held_out"]);
    CHECK(arcs_by_role(measured_cases(measured_study(), presses(arcs)))["held_out"] == roles["held_out"]);
}

TEST_CASE("the outermost contacts and those at corners are training contacts", "[measured]") {
    Study study = measured_study();
    study.data->held_out_part = 0.5;
    study.data->validation_part = 0.5;
    std::vector<double> trained = arcs_by_role(measured_cases(study, presses(every_cm())))["train"];
    REQUIRE(trained.size() == 4);
    const double wanted[] = {0.02, 0.10, 0.20, 0.28};
    for (int i = 0; i < 4; ++i) CHECK(trained[static_cast<std::size_t>(i)] == Approx(wanted[i]));
}

TEST_CASE("measurements at one or two contacts are refused because none is left for the test set", "[measured]") {
    CHECK_THAT(refused(presses({0.15})), Contains("data.csv: has 1 rows at 1 contacts") && Contains("no contact for the test set"));
    CHECK_THAT(refused(presses({0.12, 0.18})), Contains("data.csv: has 2 rows at 2 contacts") && Contains("no contact for the test set"));
    // a contact may have several places to train on
    CHECK_THAT(refused(presses({0.120, 0.121, 0.122})), Contains("has 3 rows at 1 contacts, with 3 places to train on and no contact for the test set; at least 4 and 1 are needed"));
}

TEST_CASE("roles of a measurement table are kept and training within 2 mm of a test contact is refused", "[measured]") {
    MeasuredTable table = presses(every_cm());
    for (MeasuredRow& row : table.rows) row.role = "train";
    table.rows[5].role = "held_out";
    table.rows[9].role = "validation";
    const auto roles = arcs_by_role(measured_cases(measured_study(), table));
    CHECK(roles.at("held_out") == std::vector<double>{0.07});
    CHECK(roles.at("validation").size() == 1);
    MeasuredRow leak = table.rows[5];  // another indentation, 1.9 mm from the test contact
    leak.line = 99;
    leak.role = "train";
    leak.contact_m.y() += 0.0019;
    table.rows.push_back(leak);
    CHECK_THAT(refused(table), Contains("data.csv:99:") && Contains("'role'") && Contains("line 7") && Contains("must be apart"));
    table.rows.back().contact_m.y() += 0.0002;
    CHECK_NOTHROW(measured_cases(measured_study(), table));
}

TEST_CASE("noise is estimated from repeats and an outlier is listed and kept", "[measured]") {
    const std::unique_ptr<gsl_rng, void (*)(gsl_rng*)> rng(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free);
    const double force_noise = 0.03, displacement_noise = 0.00004;
    const MeasuredTable clean = presses(every_cm());
    MeasuredTable table{"data.csv", "", {}};
    for (int repeat = 0; repeat < 20; ++repeat)
        for (MeasuredRow row : clean.rows) {
            row.push = fmt::format("at {}", row.line);
            for (int d : {0, 1}) {
                row.displacement_m[d] += gsl_ran_gaussian(rng.get(), displacement_noise);
                row.force_N[d] += gsl_ran_gaussian(rng.get(), force_noise * 0.01);
            }
            row.line = static_cast<int>(table.rows.size()) + 2;
            table.rows.push_back(row);
        }
    const Cases cases = measured_cases(measured_study(), table);
    CHECK(cases.measurement->repeats == 19 * 27);
    CHECK(cases.measurement->noise_source == "repeats");
    // 2 x 513 squares: their mean has a relative standard error of 1 / sqrt(513), its root half of that; three times
    // that
    CHECK(cases.measurement->force_noise == Approx(force_noise).epsilon(1.5 / std::sqrt(513)));
    CHECK(cases.measurement->displacement_noise_m == Approx(displacement_noise).epsilon(1.5 / std::sqrt(513)));
    CHECK(cases.measurement->outliers.empty());
    // repeats of a training indentation are one case; in the test set each row is a path
    CHECK(arcs_by_role(cases)["train"].size() == 27 - 5 - 3);
    CHECK(arcs_by_role(cases)["held_out"].size() == 20 * 5);
    for (const LoadPath& path : cases.paths) CHECK(path.again_N.has_value() == (path.role != "train"));

    table.rows[100].force_N *= 1.5;
    const Cases kept = measured_cases(measured_study(), table);
    REQUIRE(kept.measurement->outliers.size() == 1);
    CHECK_THAT(kept.measurement->outliers[0], Contains("line 102:"));
    CHECK(kept.measurement->rows == 540);
}

TEST_CASE("without repeats the noise is the value stated in the study or unknown", "[measured]") {
    Study study = measured_study();
    CHECK(measured_cases(study, presses(every_cm())).measurement->noise_source == "unknown");
    study.data->stated_force_noise = 0.01;
    const Cases cases = measured_cases(study, presses(every_cm()));
    CHECK(cases.measurement->noise_source == "stated");
    CHECK(cases.measurement->force_noise == 0.01);
}

TEST_CASE("a training case is the mean of its repeats in displacement and force", "[measured]") {
    MeasuredTable table = presses(every_cm());
    table.rows[0].push = "first";
    for (std::size_t i = 1; i < table.rows.size(); ++i) table.rows[i].push = fmt::format("{}", i);
    MeasuredRow again = table.rows[0];
    again.displacement_m += Eigen::Vector2d(0.0001, 0.0002);
    again.force_N *= 1.1;
    table.rows.push_back(again);
    const Cases cases = measured_cases(measured_study(), table);
    const LoadPath& path = cases.paths.front();
    REQUIRE(path.records.size() == 1);
    const MeasuredRow& once = table.rows[0];
    CHECK(path.push_m(path.records[0]).isApprox((once.displacement_m + again.displacement_m) / 2, tolerance::rounding));
    CHECK(path.records[0].contact_force_N.isApprox(1.05 * once.force_N, tolerance::rounding));
}

TEST_CASE("finely stepped directions at one contact are not averaged into one training case", "[measured]") {
    const Outline outline(measured_mesh());
    MeasuredTable table = presses(every_cm());
    for (MeasuredRow& row : table.rows) row.role = "train";
    table.rows[3].role = "held_out";
    std::vector<Eigen::Vector2d> made;
    for (int degrees = -60; degrees <= 60; degrees += 2) {
        made.push_back(0.005 * outline.direction(0.155, degrees * 3.14159265358979 / 180));
        table.rows.push_back({100 + degrees, outline.position(0.155), made.back(), 2 * made.back(), "", "train"});
    }
    int records = 0;
    for (const LoadPath& path : measured_cases(measured_study(), table).paths) {
        if (std::abs(outline.arc_of(path.contact_m) - 0.155) > 1e-6) continue;
        for (const PathRecord& record : path.records) {
            ++records;
            const Eigen::Vector2d push = path.push_m(record);
            const auto away = [&](const Eigen::Vector2d& m) { return std::acos(std::min(1.0, push.normalized().dot(m.normalized()))) * 180 / 3.14159265358979; };
            CHECK(std::any_of(made.begin(), made.end(), [&](const Eigen::Vector2d& m) { return away(m) < 1.5; }));
            CHECK(push.norm() > 0.99 * 0.005);
            CHECK(push.norm() < 1.01 * 0.005);
        }
    }
    CHECK(records == 31);  // 61 indentations, averaged in pairs within 3 degrees
}

TEST_CASE("training paths with nearly equal directions get distinct names", "[measured]") {
    const Outline outline(measured_mesh());
    MeasuredTable table = presses(every_cm());
    for (int i = 0; i <= 1000; ++i) {  // the last one, 3.001 degrees from the first, is close to the mean of all others
        const double degrees = i == 0 ? 0 : i < 1000 ? 2.9999 : 3.001;
        const Eigen::Vector2d push = 0.005 * outline.direction(0.105, degrees * 3.14159265358979 / 180);
        table.rows.push_back({100 + i, outline.position(0.105), push, 2 * push, "", ""});
    }
    std::set<std::string> names;
    for (const LoadPath& path : measured_cases(measured_study(), table).paths) CHECK(names.insert(path.name).second);
}

TEST_CASE("indentations spaced finely along the surface keep their places in training", "[measured]") {
    const Outline outline(measured_mesh());
    MeasuredTable table = presses(every_cm());
    for (MeasuredRow& row : table.rows) row.role = "train";
    table.rows[3].role = "held_out";
    for (int i = 0; i <= 40; ++i) {
        const double arc = 0.152 + 0.00015 * i;
        const Eigen::Vector2d push = 0.005 * outline.inward_normal(arc);
        table.rows.push_back({100 + i, outline.position(arc), push, 2 * push, "", "train"});
    }
    std::set<double> places;
    for (const LoadPath& path : measured_cases(measured_study(), table).paths) {
        const double arc = outline.arc_of(path.contact_m);
        if (arc > 0.1515 && arc < 0.1585) places.insert(arc);
    }
    CHECK(places.size() == 21);  // averaged in pairs within 0.2 mm
    REQUIRE(!places.empty());
    CHECK(*places.begin() < 0.1521);
    CHECK(*places.rbegin() > 0.1579);
}

TEST_CASE("measured cases are read back unchanged", "[measured]") {
    MeasuredTable table = presses(every_cm());
    for (std::size_t i = 0, n = table.rows.size(); i < n; ++i) {
        table.rows[i].push = fmt::format("{}", i);
        table.rows.push_back(table.rows[i]);
        table.rows.back().force_N *= 1.02;
        table.rows.back().line += 100;
    }
    const Cases cases = measured_cases(measured_study(), table);
    const TemporaryFolder folder;
    write_cases(folder.file("cases.h5"), cases, {"test", 0, {}});
    const Cases back = read_cases(folder.file("cases.h5"));
    REQUIRE(back.measurement);
    CHECK(back.measurement->force_noise == cases.measurement->force_noise);
    CHECK(back.measurement->origin == "made up");
    REQUIRE(back.paths.size() == cases.paths.size());
    for (std::size_t p = 0; p < back.paths.size(); ++p) {
        CHECK(back.paths[p].again_N == cases.paths[p].again_N);
        REQUIRE(back.paths[p].records.size() == cases.paths[p].records.size());
        for (std::size_t r = 0; r < back.paths[p].records.size(); ++r) {
            CHECK(back.paths[p].push_m(back.paths[p].records[r]) == cases.paths[p].push_m(cases.paths[p].records[r]));
            CHECK(back.paths[p].records[r].contact_force_N == cases.paths[p].records[r].contact_force_N);
        }
    }
    CHECK(load_cases(back).size() == 27 - 5 - 3);
}

TEST_CASE("measured rows with an impossible contact or displacement or force are refused by line", "[measured]") {
    const MeasuredTable good = presses(every_cm());
    const auto spoilt = [&](auto&& spoil) {
        MeasuredTable table = good;
        spoil(table.rows[3]);
        const std::string said = refused(table);
        CHECK_THAT(said, Contains("data.csv:5: "));
        return said;
    };
    CHECK_THAT(spoilt([](MeasuredRow& r) { r.contact_m.x() -= 0.001; }), Contains("off the free surface") && Contains("1 mm"));
    CHECK_THAT(spoilt([](MeasuredRow& r) { r.contact_m = Eigen::Vector2d(0.05, 0.05); }), Contains("off the free surface"));
    CHECK_THAT(spoilt([](MeasuredRow& r) { r.contact_m = Eigen::Vector2d(0.05, 0); }), Contains("contact_x"));
    CHECK_THAT(spoilt([](MeasuredRow& r) { r.contact_m.y() = 0.0005; }), Contains("fixed edge"));
    CHECK_THAT(spoilt([](MeasuredRow& r) { r.displacement_m *= -1; }), Contains("out of the tissue"));
    // millimetres with the unit m
    CHECK_THAT(spoilt([](MeasuredRow& r) { r.displacement_m *= 1e3; }), Contains("displacement_x") && Contains("size of 100 mm"));
    CHECK_THAT(spoilt([](MeasuredRow& r) { r.force_N *= -1; }), Contains("tool's force on the tissue"));
    MeasuredTable table = good;
    table.rows[3].push = table.rows[4].push = "p";
    CHECK_THAT(refused(table), Contains("data.csv:6: ") && Contains("'p' has on line 5"));
    table = good;
    table.rows.resize(4);
    CHECK_THAT(refused(table), Contains("4 rows at 4 contacts") && Contains("needed"));
}
