#include "cases/cases_table.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "cases/load_path.h"
#include "error.h"
#include "../example.h"
#include "../solid_example.h"
#include "../mutations.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

Cases fe_cases() {
    return example_cases(example_study(), example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1)));
}

Cases shape_cases() {
    Cases cases = fe_cases();
    cases.shape = shape_of(make_lattice("grid4", 4, 4, 0.1, 0.1));
    return cases;
}

Cases hand_cases() {
    Cases cases = fe_cases();
    cases.measurement.emplace();
    cases.measurement->origin = "a hand";
    cases.measurement->outliers = {"line 3"};
    cases.measurement->noise_source = "repeats";
    cases.magnitudes_m.clear();
    for (LoadPath& path : cases.paths) {
        path.records = {measured_record(0.004, Eigen::Vector2d(1, 2), Eigen::Vector2d(0, 1e-4)), measured_record(0.008, Eigen::Vector2d(2, 3), Eigen::Vector2d(0, 2e-4))};
        path.again_N = Eigen::Vector2d(2, 3);
    }
    return cases;
}

/// In space: a training path with one disc and a test path with two discs.
Cases pair_cases() {
    Cases cases;
    cases.study = "pairs";
    cases.nodes = (NodeField(4, 3) << 0, 0, 0, 0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.05).finished();
    cases.magnitudes_m = {0.005};
    for (const char* name : {"down", "held-out-two-0001"}) {
        LoadPath path;
        path.name = name;
        path.role = cases.paths.empty() ? "train" : "held_out_two";
        path.contact_m = Eigen::Vector3d(0.02, 0.05, 0.05);
        path.direction = Eigen::Vector3d(0, 0, -1);
        path.depth_m = 0.005;
        if (!cases.paths.empty()) path.second = SecondTool{Eigen::Vector3d(0.06, 0.05, 0.05), Eigen::Vector3d(0.6, 0, -0.8), 0.003};
        for (const double s : {0.0, 0.005}) {
            const NodeField field = NodeField::Constant(4, 3, 0.1 * s);
            PathRecord record{s, field, field, Eigen::Vector3d(0, 0.1, -20 * s), Eigen::Vector3d(0, 0, 20 * s), s, 1 - s, 3, 1e-12};
            record.second_force_N = Eigen::Vector3d(0.1, -0.2, -10 * s);
            path.records.push_back(record);
        }
        cases.paths.push_back(path);
    }
    return cases;
}

}  // namespace

TEST_CASE("load cases with one altered dataset are refused in one line or are valid") {
    const TemporaryFolder folder;
    const std::string whole = folder.file("whole.h5");
    for (const Cases& cases : {fe_cases(), shape_cases(), hand_cases(), pair_cases()}) {
        write_cases(whole, cases, {"tissuectl test", 0, {}});
        const DatasetTable& table = cases_table(cases.measurement.has_value());
        REQUIRE(datasets_of(whole, table).size() == Hdf5Reader(whole, "cases").datasets().size());
        const auto of_another_path = [&](const std::string& dataset) {  // only the first and the last path are altered
            return dataset.rfind("/paths/", 0) == 0 && dataset.find("/" + cases.paths.front().name + "/") == std::string::npos &&
                   dataset.find("/" + cases.paths.back().name + "/") == std::string::npos;
        };
        const auto altered = [&](const std::string& dataset) { return !of_another_path(dataset) && (!cases.shape || dataset.rfind("/shape/", 0) == 0); };
        CHECK(refused_mutations(whole, table, read_load_cases, "/", altered) > (cases.shape ? 20 : 100));
    }
}

TEST_CASE("a tool displacement larger than the tissue is refused by path") {
    const TemporaryFolder folder;
    const std::string file = folder.file("cases.h5");
    for (Cases cases : {fe_cases(), hand_cases()}) {
        cases.paths[0].records.back().magnitude_m = 83;
        write_cases(file, cases, {"tissuectl test", 0, {}});
        CHECK_THAT(refusal<FileError>([&] { read_cases(file); }), Contains("/paths/" + cases.paths[0].name + "/magnitude") && Contains("8.3e+04 mm"));
    }
}

TEST_CASE("a shape in cases with a clockwise triangle or a hole is refused by dataset") {
    const TemporaryFolder folder;
    const auto said = [&](const Cases& cases) {
        write_cases(folder.file("cases.h5"), cases, {"tissuectl test", 0, {}});
        try {
            read_cases(folder.file("cases.h5"));
        } catch (const FileError& e) {
            return std::string(e.what());
        }
        return std::string("read");
    };
    CHECK(said(shape_cases()) == "read");
    Cases turned = shape_cases();
    turned.shape->simplices.col(0).swap(turned.shape->simplices.col(1));
    CHECK_THAT(said(turned), Contains("cases.h5: /shape/triangles: triangle 0 is clockwise"));
    Cases holed = shape_cases();
    for (Eigen::Index t = 0; t < holed.shape->simplices.rows(); ++t)
        if ((holed.shape->simplices.row(t).array() == 12).any()) {  // a triangle at the middle node
            holed.shape->simplices.row(t) = holed.shape->simplices.row(holed.shape->simplices.rows() - 1).eval();
            holed.shape->simplices.conservativeResize(holed.shape->simplices.rows() - 1, 3);
            holed.shape->region.pop_back();
            break;
        }
    CHECK_THAT(said(holed), Contains("cases.h5: /shape: ") && Contains("one closed loop"));
}
