#include <catch2/catch.hpp>
#include <set>

#include "error.h"
#include "mesh/spring_mesh.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

double cross(const Eigen::RowVector2d& a, const Eigen::RowVector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
}

double triangle_area(const SpringMesh& mesh, int t) {
    const Eigen::RowVector2d a = mesh.nodes.row(mesh.simplices(t, 0)), b = mesh.nodes.row(mesh.simplices(t, 1)),
                             c = mesh.nodes.row(mesh.simplices(t, 2));
    return cross(b - a, c - a) / 2;
}

}  // namespace

TEST_CASE("the paper's lattice has 121 nodes, 220 springs, and 420 with both diagonals") {
    const SpringMesh grid4 = make_lattice("grid4", 10, 10, 0.1, 0.1), grid8 = make_lattice("grid8", 10, 10, 0.1, 0.1);
    CHECK(grid4.node_count() == 121);
    CHECK(grid4.dimension() == 2);
    CHECK(grid4.spring_count() == 220);
    CHECK(grid8.spring_count() == 420);
    CHECK(grid4.simplices.rows() == 200);
    CHECK(grid4.loop().size() == 40);
    CHECK(grid4.topology == "grid4");
    CHECK(grid8.topology == "grid8");
}

TEST_CASE("the lattice of one cell has four sides and two diagonals and two triangles") {
    const SpringMesh mesh = make_lattice("grid8", 1, 1, 0.2, 0.1);
    CHECK(mesh.node_count() == 4);
    CHECK(mesh.spring_count() == 6);
    CHECK(mesh.simplices.rows() == 2);
    CHECK(mesh.fixed == std::vector<int>{0, 1});
    CHECK(mesh.loop() == std::vector<int>{0, 1, 3, 2});
    std::multiset<double> lengths;
    for (int s = 0; s < mesh.spring_count(); ++s) lengths.insert(mesh.rest_length(s));
    CHECK(lengths.count(0.2) == 2);
    CHECK(lengths.count(0.1) == 2);
    CHECK(*lengths.rbegin() == Approx(std::hypot(0.1, 0.2)).epsilon(tolerance::rounding));
}

TEST_CASE("every spring joins two different nodes and no two springs join the same pair") {
    for (const char* topology : {"grid4", "grid8"}) {
        const SpringMesh mesh = make_lattice(topology, 5, 3, 0.1, 0.1);
        std::set<std::pair<int, int>> pairs;
        for (int s = 0; s < mesh.spring_count(); ++s) {
            const int i = mesh.springs(s, 0), j = mesh.springs(s, 1);
            CHECK(i != j);
            CHECK(pairs.insert(std::minmax(i, j)).second);
        }
    }
}

TEST_CASE("the lattice is mirror-symmetric about its vertical axis") {
    for (const char* topology : {"grid4", "grid8"}) {
        const SpringMesh mesh = make_lattice(topology, 6, 4, 0.12, 0.1);
        std::vector<int> mirror;
        for (int i = 0; i < mesh.node_count(); ++i)
            mirror.push_back(node_at(mesh, Eigen::Vector2d(0.12 - mesh.nodes(i, 0), mesh.nodes(i, 1))));

        std::set<std::pair<int, int>> springs;
        for (int s = 0; s < mesh.spring_count(); ++s)
            springs.insert(std::minmax(mesh.springs(s, 0), mesh.springs(s, 1)));
        for (const auto& [i, j] : springs) {
            const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
            CHECK(springs.count(std::minmax(mirror[a], mirror[b])) == 1);
        }
        std::set<std::set<int>> triangles;
        for (int t = 0; t < mesh.simplices.rows(); ++t)
            triangles.insert({mesh.simplices(t, 0), mesh.simplices(t, 1), mesh.simplices(t, 2)});
        for (const std::set<int>& triangle : triangles) {
            std::set<int> reflected;
            for (int node : triangle) reflected.insert(mirror[static_cast<std::size_t>(node)]);
            CHECK(triangles.count(reflected) == 1);
        }
        for (int node : mesh.fixed)
            CHECK(std::count(mesh.fixed.begin(), mesh.fixed.end(), mirror[static_cast<std::size_t>(node)]) == 1);
    }
}

TEST_CASE("triangles are counter-clockwise and sum to the tissue's area; each top corner lies in two") {
    const SpringMesh mesh = make_lattice("grid4", 6, 4, 0.12, 0.1);
    double area = 0;
    for (int t = 0; t < mesh.simplices.rows(); ++t) {
        CHECK(triangle_area(mesh, t) > 0);
        area += triangle_area(mesh, t);
    }
    CHECK(area == Approx(0.12 * 0.1).epsilon(tolerance::rounding));
    for (double x : {0.0, 0.12}) CHECK((mesh.simplices.array() == node_at(mesh, Eigen::Vector2d(x, 0.1))).count() == 2);
}

TEST_CASE("the areas of (8) sum to the tissue's area; a corner has a quarter of an inner node's") {
    const SpringMesh mesh = make_lattice("grid4", 5, 2, 0.1, 0.06);
    CHECK(mesh.node_measure.sum() == Approx(0.1 * 0.06).epsilon(tolerance::rounding));
    const double inner = mesh.node_measure[node_at(mesh, Eigen::Vector2d(0.04, 0.03))];
    CHECK(inner == Approx(0.02 * 0.03).epsilon(tolerance::rounding));
    CHECK(mesh.node_measure[node_at(mesh, Eigen::Vector2d(0, 0.06))] == Approx(inner / 4).epsilon(tolerance::rounding));
    CHECK(mesh.node_measure[node_at(mesh, Eigen::Vector2d(0.04, 0.06))] == Approx(inner / 2).epsilon(tolerance::rounding));
}

TEST_CASE("the outline is one counter-clockwise loop of neighbours about the whole tissue") {
    const SpringMesh mesh = make_lattice("grid4", 5, 3, 0.1, 0.06);
    double twice_area = 0, length = 0;
    for (std::size_t b = 0; b < mesh.loop().size(); ++b) {
        const Eigen::RowVector2d here = mesh.nodes.row(mesh.loop()[b]),
                                 next = mesh.nodes.row(mesh.loop()[(b + 1) % mesh.loop().size()]);
        twice_area += cross(here, next);
        length += (next - here).norm();
    }
    CHECK(twice_area / 2 == Approx(0.1 * 0.06).epsilon(tolerance::rounding));
    CHECK(length == Approx(2 * (0.1 + 0.06)).epsilon(tolerance::rounding));
    const std::vector<int> loop = mesh.loop();
    CHECK(std::set<int>(loop.begin(), loop.end()).size() == mesh.loop().size());
}

TEST_CASE("the bottom row and nothing else is fixed") {
    const SpringMesh mesh = make_lattice("grid4", 5, 3, 0.1, 0.06);
    CHECK(std::is_sorted(mesh.fixed.begin(), mesh.fixed.end()));
    for (int i = 0; i < mesh.node_count(); ++i)
        CHECK((mesh.nodes(i, 1) == 0) == (std::count(mesh.fixed.begin(), mesh.fixed.end(), i) == 1));
}

TEST_CASE("a point of the outline is the weighted mean of its segment's nodes, (16)-(17)") {
    const SpringMesh mesh = make_lattice("grid4", 10, 10, 0.1, 0.1);
    for (const Eigen::Vector2d& x : {Eigen::Vector2d(0.0, 0.053), Eigen::Vector2d(0.1, 0.0999),
                                    Eigen::Vector2d(0.0123, 0.1), Eigen::Vector2d(0.05, 0.1), Eigen::Vector2d(0, 0.1)}) {
        const SurfacePoint p = locate_on_surface(mesh, x);
        CHECK(p.weight[0] + p.weight[1] == Approx(1).epsilon(tolerance::rounding));
        CHECK(std::min(p.weight[0], p.weight[1]) >= 0);
        const Eigen::RowVector2d mean =
            p.weight[0] * mesh.nodes.row(p.node[0]) + p.weight[1] * mesh.nodes.row(p.node[1]);
        CHECK((mean.transpose() - x).norm() <= tolerance::rounding);
    }
    const SurfacePoint third = locate_on_surface(mesh, {0.1, 0.053});  // counter-clockwise: the right side goes up
    CHECK(third.node[0] == node_at(mesh, Eigen::Vector2d(0.1, 0.05)));
    CHECK(third.weight[1] == Approx(0.3).epsilon(1e-9));  // 0.053 is rounded to a part in 1e16 of 0.1, a cell is 0.01
}

TEST_CASE("node_at finds a node at its position and refuses other positions") {
    const SpringMesh mesh = make_lattice("grid4", 5, 3, 0.1, 0.06);
    for (int i = 0; i < mesh.node_count(); ++i) CHECK(node_at(mesh, mesh.nodes.row(i)) == i);
    CHECK(node_at(mesh, mesh.nodes.row(7) + Eigen::RowVector2d(5e-8, 0)) == 7);  // half of the tolerance
    CHECK_THAT(refusal<MismatchError>([&] { node_at(mesh, Eigen::Vector2d(0.011, 0.02)); }), Contains("0.011"));
    CHECK_THROWS_AS(node_at(mesh, Eigen::Vector2d(std::nan(""), 0)), MismatchError);
}

TEST_CASE("locate_on_surface refuses a contact inside or outside the tissue") {
    const SpringMesh mesh = make_lattice("grid4", 10, 10, 0.1, 0.1);
    CHECK_THAT(refusal<MismatchError>([&] { locate_on_surface(mesh, {0.002, 0.05}); }),
               Contains("0.002") && Contains("2 mm"));
    CHECK_THROWS_AS(locate_on_surface(mesh, {0.1, 0.101}), MismatchError);
    CHECK_THROWS_AS(locate_on_surface(mesh, {std::nan(""), 0.05}), MismatchError);
}

TEST_CASE("an unknown topology and an impossible size are refused") {
    CHECK_THAT(refusal<MismatchError>([] { make_lattice("grid6", 2, 2, 1, 1); }),
               Contains("grid6") && Contains("grid4, grid8"));
    CHECK_THROWS_AS(make_lattice("grid4", 0, 2, 1, 1), MismatchError);
    CHECK_THROWS_AS(make_lattice("grid4", 2, -1, 1, 1), MismatchError);
    CHECK_THROWS_AS(make_lattice("grid4", 2, 2, 0, 1), MismatchError);
    CHECK_THROWS_AS(make_lattice("grid4", 2, 2, 1, std::nan("")), MismatchError);
}
