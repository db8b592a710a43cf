#include "cases/history.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "cases/histories_file.h"
#include "cases/history_plan.h"
#include "cases/load_path.h"
#include "cases/sweep.h"
#include "error.h"
#include "../example.h"
#include "../mutations.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

/// FreeFEM's CSV of a history: contact, no contact, and the second contact. Line numbers from 1.
const std::string& csv() {
    static const std::string text =
        "tissuectl history,2\n"                                                   // 1
        "step,0,0,0,0,1,0,0,0,0,1,0,0\n"                                          // 2
        "step,1,0.01,0,-0.001,1,0.25,-0.5,-0.25,0.5,0.9,3,1e-11\n"                // 3
        "step,2,0.02,0,0,0,0,0,0.125,0.0625,0.95,4,2e-11\n"                       // 4
        "step,3,0.030000000000000002,0.001,-0.002,2,0.75,-1,-0.5,1,0.9,3,1e-11\n"  // 5
        "end,4\n";                                                                // 6
    return text;
}

const std::string& first_csv() {
    static const std::string text =
        "tissuectl history,1\nstep,0,0,0,0,0,0,0,0,1,0,0\nstep,1,0.01,0,-0.001,0.25,-0.5,-0.25,0.5,0.9,3,1e-11\nend,2\n";
    return text;
}

std::string said(const std::string& text) {
    const TemporaryFolder folder;
    return refusal<FileError>([&] { read_history_csv(folder.file("ramp-0001.csv", text), 2); });
}

History read(const std::string& text, Eigen::Index D = 2) {
    const TemporaryFolder folder;
    return read_history_csv(folder.file("ramp-0001.csv", text), D);
}

PlannedHistory planned() {
    PlannedHistory p;
    p.push = {"again-0001", Eigen::Vector2d(0.05, 0.1), Eigen::Vector2d(0, -1), 0.002};
    p.group = "again";
    p.kind = "again";
    p.role = "held_out";
    p.second_contact_m = Eigen::Vector2d(0.07, 0.1);
    return p;
}

/// Four histories: with an elastic solve, without one, ended early, and without any step.
std::vector<History> examples() {
    const TemporaryFolder folder;
    folder.file("again-0001.csv", csv());
    folder.file("again-0001-elastic.csv", csv());
    std::vector<History> all = {read_planned_history(planned(), folder.path(), true), read_planned_history(planned(), folder.path(), false),
                                read_planned_history(planned(), folder.path(), true), read_planned_history(planned(), folder.path(), true)};
    for (std::size_t i = 0; i < all.size(); ++i) all[i].name = "again-000" + std::to_string(i + 1);
    all[0].elastic_N *= 2;
    all[1].second_contact_m.reset();
    all[1].contact = {1, 1, 0, 1};
    History &lost = all[2], &nothing = all[3];
    lost.time_s.conservativeResize(2);
    lost.push_m.conservativeResize(2, 2);
    lost.force_N.conservativeResize(2, 2);
    lost.elastic_N.conservativeResize(2, 2);
    lost.contact.resize(2);
    lost.lost = "folded at (1, 0) m, 12 mm";
    nothing.time_s.resize(0);
    for (NodeField* field : {&nothing.push_m, &nothing.force_N, &nothing.elastic_N}) field->resize(0, 2);
    nothing.contact.clear();
    nothing.lost = "the patch reaches the fixed edge";
    return all;
}

Cases example() {
    Cases cases = example_cases(example_study(), example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1)));
    cases.histories = examples();
    return cases;
}

void check_same(const History& a, const History& b) {
    INFO(a.name);
    CHECK(a.name == b.name);
    CHECK(a.group == b.group);
    CHECK(a.kind == b.kind);
    CHECK(a.role == b.role);
    CHECK(a.lost == b.lost);
    CHECK(a.contact_m == b.contact_m);
    CHECK(a.direction == b.direction);
    CHECK(a.second_contact_m == b.second_contact_m);
    REQUIRE(a.time_s.size() == b.time_s.size());
    CHECK(a.time_s == b.time_s);
    CHECK(a.push_m == b.push_m);
    CHECK(a.force_N == b.force_N);
    REQUIRE(a.elastic_N.rows() == b.elastic_N.rows());
    CHECK(a.elastic_N == b.elastic_N);
    CHECK(a.contact == b.contact);
}

}  // namespace

TEST_CASE("a history file gives times and displacements and forces and contacts of the tool", "[histories]") {
    const History h = read(csv());
    REQUIRE(h.time_s.size() == 4);
    CHECK(h.time_s[3] == 0.030000000000000002);
    CHECK(h.push_m.row(3) == Eigen::RowVector2d(0.001, -0.002));
    CHECK(h.force_N.row(1) == Eigen::RowVector2d(0.25, -0.5));
    CHECK(h.contact == std::vector<int>{1, 1, 0, 2});
    CHECK(h.lost.empty());
    CHECK(h.elastic_N.rows() == 0);
}

TEST_CASE("a history file of version 1 without contact column and a file in space are read", "[histories]") {
    const History h = read(first_csv());
    CHECK(h.contact == std::vector<int>{1, 1});
    CHECK(h.force_N.row(1) == Eigen::RowVector2d(0.25, -0.5));
    const History solid = read("tissuectl history,2\nstep,0,0,0,0,0,1,0,0,0,0,0,0,1,0,0\nstep,1,0.5,1,2,3,1,4,5,6,7,8,9,0.9,3,0\nend,2\n", 3);
    CHECK(solid.push_m.row(1) == Eigen::RowVector3d(1, 2, 3));
    CHECK(solid.force_N.row(1) == Eigen::RowVector3d(4, 5, 6));
    CHECK(solid.contact == std::vector<int>{1, 1});
}

TEST_CASE("a history that FE ended early keeps its rows and its cause", "[histories]") {
    const History h = read(with(csv(), "end,4\n", "lost,4,folded at (1, 0) m, 12 mm\n"));
    CHECK(h.lost == "folded at (1, 0) m, 12 mm");
    CHECK(h.time_s.size() == 4);
    const History none = read("tissuectl load path,1\nlost,0,the patch reaches the fixed edge\n");
    CHECK(none.lost == "the patch reaches the fixed edge");
    CHECK(none.time_s.size() == 0);
    CHECK(none.push_m.cols() == 2);
}

TEST_CASE("an invalid history file is refused with line and cause", "[histories]") {
    CHECK_THAT(said("x,y\n1,2\n"), Contains("ramp-0001.csv:1") && Contains("not a tissuectl history"));
    CHECK_THAT(said(with(csv(), "history,2", "history,3")), Contains("ramp-0001.csv:1") && Contains("version"));
    CHECK_THAT(said(with(csv(), "step,1,0.01,", "step,1,nan,")), Contains("ramp-0001.csv:3: field 3") && Contains("not a finite number"));
    CHECK_THAT(said(with(csv(), "0.95,4,2e-11", "0.95,4,x")), Contains("ramp-0001.csv:4: field 13"));
    CHECK_THAT(said(with(csv(), "0.95,4,2e-11", "0.95,4")), Contains("ramp-0001.csv:4: has 12 fields") && Contains("must have 13"));
    CHECK_THAT(said(with(first_csv(), "0.9,3,1e-11", "0.9,3,1e-11,1")), Contains("ramp-0001.csv:3") && Contains("must have 12"));
    CHECK_THAT(said(with(csv(), "step,2,0.02,", "step,2,0.01,")), Contains("ramp-0001.csv:4") && Contains("ascend"));
    CHECK_THAT(said(with(csv(), "step,0,0,", "step,0,0.001,")), Contains("ramp-0001.csv:2") && Contains("ascend from 0"));
    CHECK_THAT(said(with(csv(), "step,2,", "step,1,")), Contains("ramp-0001.csv:4") && Contains("step 2 is missing"));
    CHECK_THAT(said(with(csv(), "0.001,-0.002,2,", "0.001,-0.002,3,")), Contains("ramp-0001.csv:5") && Contains("contact is 3"));
    CHECK_THAT(said(with(csv(), "end,4", "end,5")), Contains("ramp-0001.csv:6") && Contains("missing"));
    CHECK_THAT(said(csv() + "end,4\n"), Contains("ramp-0001.csv:7") && Contains("follows the end row"));
    CHECK_THAT(said(with(csv(), "end,4", "edge,4")), Contains("ramp-0001.csv:6") && Contains("is not a step"));
    CHECK_THAT(said("tissuectl load path,1\nend,0\n"), Contains("ramp-0001.csv:2"));
    for (std::size_t size = 0; size + 1 < csv().size(); ++size) CHECK_THAT(said(csv().substr(0, size)), Contains("ramp-0001.csv:"));
    const TemporaryFolder folder;
    CHECK_THAT(refusal<FileError>([&] { read_history_csv(folder.file("none.csv"), 2); }), Contains("none.csv"));
}

TEST_CASE("an elastic solve needs the times of its history; an unfinished one is left out", "[histories]") {
    const TemporaryFolder folder;
    folder.file("again-0001.csv", csv());
    const auto elastic = [&](const std::string& text) {
        folder.file("again-0001-elastic.csv", text);
        return read_planned_history(planned(), folder.path(), true);
    };
    const History both = elastic(with(csv(), "0.25,-0.5,", "0.375,-0.75,"));
    CHECK(both.name == "again-0001");
    CHECK(both.contact_m == Eigen::Vector2d(0.05, 0.1));
    REQUIRE(both.second_contact_m);
    REQUIRE(both.elastic_N.rows() == 4);
    CHECK(both.elastic_N.row(1) == Eigen::RowVector2d(0.375, -0.75));
    CHECK(both.force_N.row(1) == Eigen::RowVector2d(0.25, -0.5));
    // after time without contact the displacement may differ
    CHECK(elastic(with(csv(), "0.001,-0.002,2", "0.0011,-0.002,2")).elastic_N.rows() == 4);
    CHECK(elastic("tissuectl history,2\nstep,0,0,0,0,1,0,0,0,0,1,0,0\nlost,1,folded\n").elastic_N.rows() == 0);
    // ended early after as many steps as the history
    CHECK(elastic(with(csv(), "end,4", "lost,4,folded")).elastic_N.rows() == 0);
    const auto refused = [&](const std::string& text) { return refusal<FileError>([&] { elastic(text); }); };
    CHECK_THAT(refused(with(csv(), "step,2,0.02,", "step,2,0.025,")), Contains("again-0001-elastic.csv: step 2"));
    CHECK_THAT(refused(with(csv(), "step,2,0.02,0,0,0,", "step,2,0.02,0,0,1,")), Contains("again-0001-elastic.csv: step 2"));
    CHECK_THAT(refused("tissuectl history,2\nstep,0,0,0,0,1,0,0,0,0,1,0,0\nend,1\n"), Contains("has 1 steps"));
    folder.file("again-0001.csv", "tissuectl history,2\nstep,0,0,0,0,1,0,0,0,0,1,0,0\nlost,1,folded\n");
    CHECK(elastic(csv()).elastic_N.rows() == 1);  // up to the last step of the history
}

TEST_CASE("histories are read back from cases.h5 bit for bit even if unfinished or without an elastic solve", "[histories]") {
    const TemporaryFolder folder;
    const Cases before = example();
    write_cases(folder.file("cases.h5"), before, {"tissuectl test", 0, {}});
    const Cases after = read_cases(folder.file("cases.h5"));
    REQUIRE(after.histories.size() == before.histories.size());
    for (std::size_t i = 0; i < before.histories.size(); ++i) check_same(after.histories[i], before.histories[i]);
    CHECK(after.histories[1].elastic_N.rows() == 0);
    CHECK(after.paths.size() == before.paths.size());
}

TEST_CASE("cases with histories have a later format version than cases without", "[histories]") {
    const TemporaryFolder folder;
    const auto version = [&](const Cases& cases) {
        write_cases(folder.file("cases.h5"), cases, {"tissuectl test", 0, {}});
        return Hdf5Reader(folder.file("cases.h5"), "cases").number_attribute("/", "format_version");
    };
    Cases cases = example();
    CHECK(version(cases) == time_format_version);
    cases.histories.clear();
    CHECK(version(cases) == format_version);
    CHECK_FALSE(Hdf5Reader(folder.file("cases.h5"), "cases").has("/histories"));
}

TEST_CASE("removing mirror images and thinning keep the histories of cases", "[histories]") {
    Cases cases = example();
    CHECK(without_mirrors(cases).histories.size() == 4);
    const Study study = read_study("fem/studies/surface-quick.toml");
    Cases swept;
    swept.nodes = cases.nodes;
    swept.histories = cases.histories;
    CHECK(thinned(study, swept, study.whole()).histories.size() == 4);
}

TEST_CASE("histories with one altered dataset are refused in one line or are valid", "[histories]") {
    const TemporaryFolder folder;
    const std::string whole = folder.file("whole.h5");
    write_cases(whole, example(), {"tissuectl test", 0, {}});
    REQUIRE(datasets_of(whole, histories_table()).size() == histories_table().size());
    CHECK(refused_mutations(whole, histories_table(), [](const std::string& file) { read_cases(file); }, "/histories") > 50);
}

TEST_CASE("histories with inconsistent datasets are refused by dataset", "[histories]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("cases.h5");
    const auto said = [&](const std::string& dataset, const std::vector<double>& values) {
        write_cases(file, example(), {"tissuectl test", 0, {}});
        replace_dataset(file, "/histories/" + dataset, values);
        const std::string words = refusal<FileError>([&] { read_cases(file); });
        CHECK_THAT(words, StartsWith(file + ": /histories/" + dataset + ": "));
        return words;
    };
    CHECK_THAT(said("offset", {0, 4, 8, 10, 11}), Contains("does not divide"));
    CHECK_THAT(said("offset", {0, 4, 2, 10, 10}), Contains("does not divide"));
    CHECK_THAT(said("offset", {0, 4, 4, 10, 10}), Contains("'again-0002' has no rows"));
    CHECK_THAT(said("time", {0, 0.01, 0.02, 0.03, 0, 0.01, 0.005, 0.03, 0, 0.01}), Contains("row 2 of 'again-0002'"));
    CHECK_THAT(said("contact", {1, 1, 0, 2, 1, 1, 0, 2, 1, 1}), Contains("'again-0002' has contact 2"));
}
