#include "cases/load_path.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "error.h"
#include "../example.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// The corners of a 1 m square.
const NodeField& corners() {
    static const NodeField nodes = (NodeField(4, 2) << 0, 0, 1, 0, 0, 1, 1, 1).finished();
    return nodes;
}

/// FreeFEM's CSV of a load path with two records, whose nodes have another order than the mesh's. Line numbers from 1.
const std::string& csv() {
    static const std::string text =
        "tissuectl load path,1\n"                                                      // 1
        "step,0,0,0,0,0,0,0,1,0,0\n"                                                   // 2
        "node,1,1,0,0,0,0\nnode,0,0,0,0,0,0\nnode,1,0,0,0,0,0\nnode,0,1,0,0,0,0\n"     // 3-6
        "step,1,0.01,0.0025,0.5,0.25,-0.5,-0.25,0.90000000000000002,4,3e-11\n"         // 7
        "node,1,1,0.1,-0.2,0.5,0.25\nnode,0,0,0,0,-0.125,0\n"                          // 8-9
        "node,1,0,0,0,-0.375,-0.25\nnode,0,1,0.30000000000000004,0,0,0\n"              // 10-11
        "end,2\n";                                                                     // 12
    return text;
}

std::string said(const std::string& text) {
    const TemporaryFolder folder;
    const std::string file = folder.file("left.csv", text);
    return refusal<FileError>([&] { read_path_csv(file, corners()); });
}

Cases written_and_read(const Cases& cases) {
    const TemporaryFolder folder;
    write_cases(folder.file("cases.h5"), cases, {"tissuectl test", 0, {}});
    return read_cases(folder.file("cases.h5"));
}

Cases example() {
    const Study study = example_study();
    return example_cases(study, example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1)));
}

}  // namespace

TEST_CASE("rows of a load path are assigned to nodes by position and not by order") {
    const TemporaryFolder folder;
    const LoadPath path = read_path_csv(folder.file("left.csv", csv()), corners());
    REQUIRE(path.records.size() == 2);
    const PathRecord& r = path.records[1];
    CHECK(r.magnitude_m == 0.01);
    CHECK(r.energy_J == 0.0025);
    CHECK(r.contact_force_N == Eigen::Vector2d(0.5, 0.25));
    CHECK(r.support_force_N == Eigen::Vector2d(-0.5, -0.25));
    CHECK(r.smallest_J == 0.9);
    CHECK(r.newton_iterations == 4);
    CHECK(r.newton_residual == 3e-11);
    CHECK(r.displacement.row(3) == Eigen::RowVector2d(0.1, -0.2));
    CHECK(r.displacement(2, 0) == 0.30000000000000004);  // 17 digits give the same bits
    CHECK(r.force.row(1) == Eigen::RowVector2d(-0.375, -0.25));
    CHECK(path.records[0].displacement.norm() == 0);
}

TEST_CASE("a two-disc path has the force of the second disc and the number of discs must match") {
    const TemporaryFolder folder;
    const std::string two = with(with(with(csv(), "path,1", "path,2"), "1,0,0\n", "1,0,0,0,0\n"), ",3e-11", ",3e-11,-0.5,0.125");
    const LoadPath path = read_path_csv(folder.file("two.csv", two), corners(), true);
    REQUIRE(path.records.size() == 2);
    CHECK(path.records[1].second_force_N == Eigen::Vector2d(-0.5, 0.125));
    CHECK(path.records[1].newton_residual == 3e-11);
    CHECK(path.records[0].second_force_N == Eigen::Vector2d(0, 0));
    CHECK_THAT(said(two), Contains("left.csv:1: has two discs, and the path has one"));
    const auto said_of_two = [&](const std::string& text) { return refusal<FileError>([&] { read_path_csv(folder.file("bad.csv", text), corners(), true); }); };
    CHECK_THAT(said_of_two(csv()), Contains("bad.csv:1: has one disc, and the path has two"));
    CHECK_THAT(said_of_two(with(two, ",-0.5,0.125", "")), Contains("bad.csv:7: has 11 fields"));
    CHECK_THAT(said_of_two(with(two, "-0.5,0.125", "-0.5,nan")), Contains("bad.csv:7: field 13"));
    CHECK_THAT(said_of_two(with(two, "path,2", "path,3")), Contains("another format version"));
}

TEST_CASE("a load path with a field that is no finite number is refused with its place") {
    for (const char* bad : {"nan", "inf", "-inf", "", "0.1x", " 0.1", "1e999"}) {
        INFO(bad);
        CHECK_THAT(said(with(csv(), "node,1,1,0.1,", std::string("node,1,1,") + bad + ",")),
                   Contains("left.csv:8: field 4") && Contains("not a finite number"));
    }
    CHECK_THAT(said(with(csv(), "step,1,0.01,", "step,1,nan,")), Contains("left.csv:7: field 3"));
}

TEST_CASE("a record with a missing node row is refused at its end") {
    CHECK_THAT(said(with(csv(), "node,1,0,0,0,0,0\n", "")), Contains("left.csv:6") && Contains("3 of 4 nodes"));
    CHECK_THAT(said(with(csv(), "node,1,0,0,0,-0.375,-0.25\n", "")), Contains("left.csv:11") && Contains("3 of 4"));
}

TEST_CASE("a node row that is repeated or off the lattice is refused with its line") {
    CHECK_THAT(said(with(csv(), "node,0,0,0,0,-0.125,0", "node,1,1,0,0,-0.125,0")),
               Contains("left.csv:9") && Contains("twice"));
    CHECK_THAT(said(with(csv(), "node,0,0,0,0,-0.125,0", "node,0.5,0,0,0,-0.125,0")),
               Contains("left.csv:9") && Contains("no lattice node"));
}

TEST_CASE("a load path truncated at any byte is refused") {
    for (std::size_t size = 0; size + 1 < csv().size(); ++size) {  // the last line break may be missing
        INFO(size);
        CHECK_THAT(said(csv().substr(0, size)), Contains("left.csv:"));
    }
    CHECK_THAT(said(csv().substr(0, csv().find("end"))), Contains("truncated"));
}

TEST_CASE("a missing record and a node row before any record are refused") {
    const std::string text = csv();
    const std::size_t second = text.find("step,1");
    CHECK_THAT(said(text.substr(0, second) + "end,2\n"), Contains("records are missing"));
    CHECK_THAT(said("tissuectl load path,1\nnode,0,0,0,0,0,0\nend,0\n"), Contains("left.csv:2"));
}

TEST_CASE("load path magnitudes that do not ascend are refused") {
    CHECK_THAT(said(with(csv(), "step,1,0.01,", "step,1,0,")), Contains("left.csv:7") && Contains("ascend"));
    CHECK_THAT(said(with(csv(), "step,1,0.01,", "step,1,-0.01,")), Contains("ascend"));
}

TEST_CASE("a foreign file and another format version and malformed rows of a load path are refused") {
    CHECK_THAT(said("x,y\n1,2\n"), Contains("left.csv:1") && Contains("not a tissuectl load path"));
    CHECK_THAT(said(with(csv(), "load path,1", "load path,3")), Contains("left.csv:1") && Contains("version"));
    CHECK_THAT(said(with(csv(), "node,0,0,0,0,-0.125,0", "edge,0,0,0,0,-0.125,0")), Contains("left.csv:9"));
    CHECK_THAT(said(with(csv(), "node,0,0,0,0,-0.125,0", "node,0,0,0,0,-0.125")),
               Contains("left.csv:9") && Contains("6 fields"));
    CHECK_THAT(said(with(csv(), "4,3e-11", "4")), Contains("left.csv:7") && Contains("10 fields"));
}

TEST_CASE("rows after the end row of a load path are refused") {
    CHECK_THAT(said(csv() + "step,2,0.02,0,0,0,0,0,1,0,0\n"), Contains("left.csv:13") && Contains("end row"));
    CHECK_THAT(said(csv() + csv()), Contains("left.csv:13") && Contains("end row"));
}

TEST_CASE("a missing load path file is refused by name") {
    const TemporaryFolder folder;
    CHECK_THAT(refusal<FileError>([&] { read_path_csv(folder.file("none.csv"), corners()); }), Contains("none.csv"));
}

TEST_CASE("cases are read back from HDF5 bit for bit") {
    const Cases before = example(), after = written_and_read(before);
    CHECK(after.study == before.study);
    CHECK(after.nodes == before.nodes);
    CHECK(after.magnitudes_m == before.magnitudes_m);
    REQUIRE(after.paths.size() == before.paths.size());
    for (std::size_t p = 0; p < before.paths.size(); ++p) {
        CHECK(after.paths[p].name == before.paths[p].name);
        CHECK(after.paths[p].contact_m == before.paths[p].contact_m);
        CHECK(after.paths[p].direction == before.paths[p].direction);
        REQUIRE(after.paths[p].records.size() == before.paths[p].records.size());
        for (std::size_t r = 0; r < before.paths[p].records.size(); ++r) {
            const PathRecord &a = after.paths[p].records[r], &b = before.paths[p].records[r];
            CHECK(a.magnitude_m == b.magnitude_m);
            CHECK(a.displacement == b.displacement);
            CHECK(a.force == b.force);
            CHECK(a.contact_force_N == b.contact_force_N);
            CHECK(a.support_force_N == b.support_force_N);
            CHECK(a.energy_J == b.energy_J);
            CHECK(a.smallest_J == b.smallest_J);
            CHECK(a.newton_iterations == b.newton_iterations);
            CHECK(a.newton_residual == b.newton_residual);
        }
    }
}

TEST_CASE("datasets of a load path in cases.h5 have their units and a description") {
    const TemporaryFolder folder;
    write_cases(folder.file("cases.h5"), example(), {"tissuectl test", 0, {}});
    const Hdf5Reader in(folder.file("cases.h5"), "cases");
    CHECK(in.describe().size() == 3 + 2 * in.children("/paths/left").size());
    for (const auto& [name, units] : std::vector<std::pair<std::string, std::string>>{{"displacement", "m"},
                                                                                      {"force", "N"},
                                                                                      {"contact_force", "N"},
                                                                                      {"support_force", "N"},
                                                                                      {"energy", "J"},
                                                                                      {"magnitude", "m"},
                                                                                      {"contact", "m"},
                                                                                      {"direction", "1"},
                                                                                      {"smallest_J", "1"}})
        CHECK(in.text_attribute("/paths/left/" + name, "units") == units);
    for (const std::string& name : in.children("/paths/left"))
        CHECK_FALSE(in.text_attribute("/paths/left/" + name, "description").empty());
}

TEST_CASE("load cases are all paths at all magnitudes in the order of paths") {
    const Cases cases = example();
    std::vector<std::string> names;
    for (const LoadCase& load : load_cases(cases)) {
        names.push_back(load.name);
        CHECK(std::abs(load.record->magnitude_m - (load.name.find("-4mm") == std::string::npos ? 0.008 : 0.004)) < 1e-15);
    }
    CHECK(names == std::vector<std::string>{"left-4mm", "left-8mm", "corner-4mm", "corner-8mm"});
}

TEST_CASE("load cases with nearly equal magnitudes get the shortest distinct names") {
    Cases measured;
    measured.measurement.emplace();
    LoadPath path;
    path.name = "s012500-p00000";
    for (double m : {0.0123456, 0.0123457, 0.0200000}) path.records.push_back(measured_record(m, Eigen::Vector2d(0, -m), Eigen::Vector2d(0, 0)));
    measured.paths = {path};
    std::vector<std::string> names;
    for (const LoadCase& load : load_cases(measured)) names.push_back(load.name);
    CHECK(names == std::vector<std::string>{"s012500-p00000-12.3456mm", "s012500-p00000-12.3457mm", "s012500-p00000-20mm"});

    measured.paths[0].records.push_back(path.records.back());
    refusal<MismatchError>([&] { load_cases(measured); });

    Cases cases;
    cases.magnitudes_m = {0.01234561, 0.01234562};
    path.records = {measured_record(0.01234561, Eigen::Vector2d(0, -1), Eigen::Vector2d(0, 0)), measured_record(0.01234562, Eigen::Vector2d(0, -1), Eigen::Vector2d(0, 0))};
    cases.paths = {path};
    names.clear();
    for (const LoadCase& load : load_cases(cases)) names.push_back(load.name);
    CHECK(names == std::vector<std::string>{"s012500-p00000-12.34561mm", "s012500-p00000-12.34562mm"});
}

TEST_CASE("a cases file with a repeated path name is refused") {
    const TemporaryFolder folder;
    Hdf5Writer out(folder.file("twice.h5"), "cases", {"tissuectl test", 0, {}});
    out.attribute("/", "study", "example");
    out.write("/nodes", corners(), "m", "nodes");
    out.write("/magnitudes", Eigen::VectorXd(Eigen::VectorXd::Constant(1, 0.008)), "m", "tool displacements that are load cases");
    out.write_texts("/path_names", {"left", "left"}, "load paths");
    out.write_texts("/paths/left/role", {"validation", "lost before it began"}, "role");
    for (const char* one : {"depth", "magnitude", "energy", "smallest_J", "newton_residual"})
        out.write(std::string("/paths/left/") + one, Eigen::VectorXd(Eigen::VectorXd::Constant(1, 0.008)), "m", one);
    for (const char* two : {"contact", "direction"})
        out.write(std::string("/paths/left/") + two, Eigen::VectorXd(Eigen::VectorXd::Constant(2, 0.5)), "m", two);
    for (const char* row : {"contact_force", "support_force"})
        out.write(std::string("/paths/left/") + row, NodeField(NodeField::Zero(1, 2)), "N", row);
    for (const char* field : {"displacement", "force"})
        out.write(std::string("/paths/left/") + field, Array{{1, 4, 2}, std::vector<double>(8)}, "m", field);
    out.write_integers("/paths/left/newton_iterations", {1}, {1}, "iterations");
    out.commit();
    CHECK_THAT(refusal<FileError>([&] { read_cases(folder.file("twice.h5")); }), Contains("path_names") && Contains("'left' is present twice"));
}

TEST_CASE("a path without a record at a magnitude of the cases is refused by path and magnitude") {
    Cases cases = example();
    cases.paths[1].records.pop_back();
    CHECK_THAT(refusal<MismatchError>([&] { load_cases(cases); }), Contains("corner") && Contains("8 mm"));
    cases = example();
    cases.magnitudes_m.push_back(0.0081);
    CHECK_THROWS_AS(load_cases(cases), MismatchError);
}

TEST_CASE("cases with a path dataset missing or of the wrong size are refused with its place") {
    const TemporaryFolder folder;
    const std::string file = folder.file("cases.h5");
    for (const std::string name : {"contact", "direction", "magnitude", "displacement", "force", "contact_force",
                                   "support_force", "energy", "smallest_J", "newton_residual", "newton_iterations"}) {
        INFO(name);
        write_cases(file, example(), {"tissuectl test", 0, {}});
        replace_dataset(file, "/paths/left/" + name, {1, 2, 3});
        CHECK_THAT(refusal<FileError>([&] { read_cases(file); }), Contains("cases.h5") && Contains("/paths/left"));
        write_cases(file, example(), {"tissuectl test", 0, {}});
        replace_dataset(file, "/paths/left/" + name);
        CHECK_THAT(refusal<FileError>([&] { read_cases(file); }), Contains("/paths/left/" + name) && Contains("missing"));
    }
}

TEST_CASE("a load path that FE ended early keeps its records and its cause") {
    const TemporaryFolder folder;
    const std::string lost = with(csv(), "end,2\n", "lost,2,folded at (1, 0) m, 12 mm\n");
    const LoadPath path = read_path_csv(folder.file("left.csv", lost), corners());
    CHECK(path.lost == "folded at (1, 0) m, 12 mm");
    // control characters are escaped
    CHECK(read_path_csv(folder.file("left.csv", with(lost, "folded", "\033]0;owned\007")), corners()).lost == "\\x1b]0;owned\\x07 at (1, 0) m, 12 mm");
    CHECK(path.records.size() == 2);
    CHECK_THAT(said(with(lost, "lost,2,", "lost,3,")), Contains("records are missing"));
    CHECK_THAT(said(with(csv(), "end,2\n", "lost,2\n")), Contains("left.csv:12"));
}

TEST_CASE("load cases include the reached magnitudes of an unfinished path and no path of the test set") {
    Cases cases = example();
    cases.paths[1].records.pop_back();
    cases.paths[1].lost = "folded";
    CHECK(load_cases(cases).size() == 3);
    cases.paths[0].role = "held_out";
    REQUIRE(load_cases(cases).size() == 1);
    CHECK(load_cases(cases)[0].name == "corner-4mm");
    const Cases after = written_and_read(cases);
    CHECK(after.paths[0].role == "held_out");
    CHECK(after.paths[1].lost == "folded");
    CHECK(after.paths[1].depth_m == cases.paths[1].depth_m);
}

TEST_CASE("a mirrored path has mirrored contact and fields and mirroring twice restores its fields") {
    Cases cases = example();
    cases.paths[1].records[0] = cases.paths[1].records[1];  // so that the first record is not zero
    const LoadPath &path = cases.paths[1], once = mirrored(path, cases.nodes, 0.1);
    CHECK(once.name == "corner-mirror");
    CHECK(once.contact_m == Eigen::Vector2d(0, 0.1));
    CHECK(once.direction == Eigen::Vector2d(-path.direction.x(), path.direction.y()));
    const SpringMesh mesh = make_lattice("grid8", 4, 4, 0.1, 0.1);
    const int here = node_at(mesh, Eigen::Vector2d(0.1, 0.1)), there = node_at(mesh, Eigen::Vector2d(0.0, 0.1));
    for (std::size_t r = 0; r < path.records.size(); ++r) {
        const PathRecord &image = once.records[r], &record = path.records[r];
        CHECK(image.displacement(there, 0) == -record.displacement(here, 0));
        CHECK(image.force(there, 1) == record.force(here, 1));
        CHECK(image.contact_force_N.x() == -record.contact_force_N.x());
        CHECK(image.energy_J == record.energy_J);
    }
    const LoadPath twice = mirrored(once, cases.nodes, 0.1);
    for (std::size_t r = 0; r < path.records.size(); ++r) {
        CHECK(twice.records[r].displacement == path.records[r].displacement);
        CHECK(twice.records[r].force == path.records[r].force);
        CHECK(twice.records[r].support_force_N == path.records[r].support_force_N);
    }
    CHECK_THROWS_AS(mirrored(path, cases.nodes, 0.11), MismatchError);
}

TEST_CASE("reading cases from a missing or foreign file and writing into a missing folder are refused") {
    const TemporaryFolder folder;
    CHECK_THROWS_AS(read_cases(folder.file("none.h5")), FileError);
    {
        Hdf5Writer out(folder.file("model.h5"), "model", {"tissuectl test", 0, {}});
        out.commit();
    }
    CHECK_THAT(refusal<FileError>([&] { read_cases(folder.file("model.h5")); }), Contains("'model'"));
    CHECK_THROWS_AS(write_cases(folder.file("none/cases.h5"), example(), {"tissuectl test", 0, {}}), FileError);
}
