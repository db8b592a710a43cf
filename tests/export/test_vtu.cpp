#include "export/vtu.h"
#include "mesh/solid_block.h"

#include <catch2/catch.hpp>

#include "mesh/topology.h"

using namespace tissue;
using Catch::Matchers::Contains;

TEST_CASE("an exported path has the cells of its lattice or one cell per node without a lattice", "[export]") {
    const auto cells = [](const NodeField& nodes) {
        Cases cases;
        cases.nodes = nodes;
        const NodeField still = NodeField::Zero(nodes.rows(), nodes.cols());
        const Point none = Point::Zero(nodes.cols());
        return path_vtu(cases, {"left", none, none, "train", 0, "", {{0, still, still, none, none, 0, 1, 0, 0, {}}}, {}}).at("left/0000.vtu");
    };
    CHECK_THAT(cells(make_lattice("grid8", 1, 1, 0.1, 0.1).nodes), Contains("NumberOfCells=\"1\""));
    CHECK_THAT(cells(make_lattice("grid8", 3, 1, 0.1, 0.1).nodes), Contains("NumberOfCells=\"3\""));
    CHECK_THAT(cells(solid_block({{1, 2, 1}, {1, 2, 1}}).nodes), Contains("NumberOfCells=\"2\""));
    NodeField moved = make_lattice("grid8", 3, 1, 0.1, 0.1).nodes;
    moved(0, 0) += 0.01;
    CHECK_THAT(cells(moved), Contains("NumberOfCells=\"8\""));  // one cell per node
}

TEST_CASE("a path is exported as one file per record with the displacement magnitude as time", "[export]") {
    Cases cases;
    cases.nodes = make_lattice("grid8", 1, 1, 0.1, 0.1).nodes;
    const Point none = Point::Zero(2);
    LoadPath path{"a&b", none, none, "train", 0, "", {}, {}};
    for (const double push_m : {0.001, 0.002}) {
        const NodeField u = NodeField::Constant(4, 2, push_m);
        path.records.push_back({push_m, u, u, none, none, 0, 1, 0, 0, {}});
    }
    const Files files = path_vtu(cases, path);
    REQUIRE(files.size() == 3);
    CHECK_THAT(files.at("a&b.pvd"), Contains("<DataSet timestep=\"0.001\" part=\"0\" file=\"a&amp;b/0000.vtu\"/>") && Contains("timestep=\"0.002\""));
    for (const char* name : {"a&b/0000.vtu", "a&b/0001.vtu"}) {
        const std::string& grid = files.at(name);
        CHECK_THAT(grid, !Contains("TimeStep") && !Contains("TimeValues"));
        CHECK(grid.find("\"displacement_m\" N") == grid.rfind("\"displacement_m\" N"));
    }
    CHECK_THAT(files.at("a&b/0001.vtu"), Contains("0.002 0.002 0 \n"));
}
