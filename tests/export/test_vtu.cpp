#include "export/vtu.h"

#include <catch2/catch.hpp>

#include "mesh/topology.h"

using namespace tissue;
using Catch::Matchers::Contains;

TEST_CASE("a path's cells are the lattice's, of one cell along an axis too, and none where the nodes are no lattice", "[export]") {
    const auto cells = [](const NodeField& nodes) {
        Cases cases;
        cases.nodes = nodes;
        const NodeField still = NodeField::Zero(nodes.rows(), nodes.cols());
        const Point none = Point::Zero(nodes.cols());
        return path_vtu(cases, {"left", none, none, "train", 0, "", {{0, still, still, none, none, 0, 1, 0, 0, {}}}, {}});
    };
    CHECK_THAT(cells(make_lattice("grid8", 1, 1, 0.1, 0.1).nodes), Contains("NumberOfCells=\"1\""));
    CHECK_THAT(cells(make_lattice("grid8", 3, 1, 0.1, 0.1).nodes), Contains("NumberOfCells=\"3\""));
    CHECK_THAT(cells(make_lattice("grid26", Lattice{{1, 2, 1}, {1, 2, 1}}).nodes), Contains("NumberOfCells=\"2\""));
    NodeField moved = make_lattice("grid8", 3, 1, 0.1, 0.1).nodes;
    moved(0, 0) += 0.01;
    CHECK_THAT(cells(moved), Contains("NumberOfCells=\"8\""));  // its nodes alone
}
