#include "mesh/cells.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "disc.h"
#include "error.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

TEST_CASE("a lattice's cells are its rectangles with either diagonal") {
    for (const char* topology : {"grid4", "grid8"}) {
        const SpringMesh mesh = make_lattice(topology, 4, 3, 0.1, 0.06);
        const Cells cells = mesh_cells(mesh);
        REQUIRE(cells.rows() == 12);
        REQUIRE(cells.cols() == 4);
        const Eigen::VectorXd areas = cell_areas(mesh, cells);
        for (double area : areas) CHECK(area == Approx(0.025 * 0.02).epsilon(tolerance::rounding));
        CHECK(cells.row(0) == Eigen::RowVector4i(0, 1, 6, 5));
        CHECK(cells.row(3) == Eigen::RowVector4i(3, 4, 9, 8));  // with the other diagonal
    }
}

TEST_CASE("a shape's cells are its triangles") {
    const Shape shape = disc(12);
    const SpringMesh mesh = edge_mesh(shape);
    CHECK(mesh_cells(mesh) == Cells(shape.simplices));
    CHECK(cell_areas(mesh, mesh_cells(mesh)).sum() == Approx(6 * 0.05 * 0.05 * std::sin(std::acos(-1.0) / 6)).epsilon(tolerance::rounding));
}

TEST_CASE("a lattice whose triangles do not pair up is refused") {
    SpringMesh mesh = make_lattice("grid8", 2, 2, 0.1, 0.1);
    mesh.simplices.row(1).swap(mesh.simplices.row(2));
    CHECK_THAT(refusal<MismatchError>([&] { mesh_cells(mesh); }), Contains("form pairs"));
}

TEST_CASE("regions are the whole tissue and its quarters; on a symmetric mesh they are symmetric") {
    for (int across : {4, 5}) {
        const SpringMesh mesh = make_lattice("grid8", across, 4, 0.1, 0.1);
        const Cells cells = mesh_cells(mesh);
        const std::vector<std::vector<int>> regions = cell_regions(mesh, cells);
        REQUIRE(regions.size() == 5);
        CHECK(regions[0].size() == static_cast<std::size_t>(4 * across));
        for (std::size_t q = 1; q < 5; ++q) CHECK(regions[q].size() == static_cast<std::size_t>(across == 4 ? 4 : 6));  // the middle column counts twice
        for (int c : regions[1]) {
            const int row = c / across, mirror = row * across + across - 1 - c % across;
            CHECK(std::find(regions[2].begin(), regions[2].end(), mirror) != regions[2].end());
        }
    }
}
