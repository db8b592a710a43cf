#include "springs/heuristic.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../tolerances.h"

using namespace tissue;

namespace {

constexpr double E2 = 0.754;

struct Edge {
    bool boundary, diagonal, along_x;
};

Edge edge_of(const SpringMesh& mesh, int s) {
    const Eigen::RowVector2d a = mesh.nodes.row(mesh.springs(s, 0)), b = mesh.nodes.row(mesh.springs(s, 1));
    const Eigen::RowVector2d top = mesh.nodes.colwise().maxCoeff();
    bool boundary = false;
    for (int axis : {0, 1}) boundary |= a[axis] == b[axis] && (a[axis] == 0 || a[axis] == top[axis]);
    return {boundary, a.x() != b.x() && a.y() != b.y(), a.y() == b.y()};
}

}  // namespace

TEST_CASE("the heuristic (7) is E2 on inner axis springs, E2/2 on the boundary and on diagonals") {
    for (const char* topology : {"grid4", "grid8"}) {
        const SpringMesh mesh = make_lattice(topology, 10, 10, 0.1, 0.1);
        const Eigen::VectorXd theta = heuristic_stiffness(mesh, E2);
        int halves = 0;
        for (int s = 0; s < mesh.spring_count(); ++s) {
            const Edge edge = edge_of(mesh, s);
            const bool half = edge.boundary || edge.diagonal;
            halves += half ? 1 : 0;
            CHECK(theta[s] == Approx(half ? E2 / 2 : E2).epsilon(tolerance::rounding));
        }
        CHECK(halves == (mesh.topology == "grid4" ? 40 : 240));
    }
}

TEST_CASE("on rectangular cells (7) gives inner springs E2 times dy/dx, dx/dy or dx dy/(dx^2 + dy^2)") {
    const double dx = 0.03, dy = 0.01;
    const SpringMesh mesh = make_lattice("grid8", 4, 6, 4 * dx, 6 * dy);
    const Eigen::VectorXd theta = heuristic_stiffness(mesh, E2);
    for (int s = 0; s < mesh.spring_count(); ++s) {
        const Edge edge = edge_of(mesh, s);
        const double inner = edge.diagonal ? dx * dy / (dx * dx + dy * dy) : edge.along_x ? dy / dx : dx / dy;
        CHECK(theta[s] == Approx(E2 * (edge.boundary ? inner / 2 : inner)).epsilon(tolerance::rounding));
    }
}

TEST_CASE("the heuristic is proportional to the modulus and independent of the lattice's size") {
    const SpringMesh mesh = make_lattice("grid8", 4, 4, 0.1, 0.1), larger = make_lattice("grid8", 4, 4, 3.0, 3.0);
    const Eigen::VectorXd theta = heuristic_stiffness(mesh, E2);
    CHECK(heuristic_stiffness(mesh, 3 * E2).isApprox(3 * theta, tolerance::rounding));
    CHECK(heuristic_stiffness(larger, E2).isApprox(theta, tolerance::rounding));
}

TEST_CASE("uniform_stiffness gives all springs one stiffness and diagonals half of it") {
    for (const double height : {0.1, 0.3}) {
        const SpringMesh mesh = make_lattice("grid8", 4, 4, 0.1, height);
        const Eigen::VectorXd theta = uniform_stiffness(mesh, 2.0);
        for (int s = 0; s < mesh.spring_count(); ++s) CHECK(theta[s] == (edge_of(mesh, s).diagonal ? 1.0 : 2.0));
    }
}

TEST_CASE("node masses (8) sum to rho t L^2 and a corner has a quarter of an inner node's mass") {
    const double L = 0.1, t = 1.0 / 6000, rho = 1040;
    const SpringMesh mesh = make_lattice("grid4", 10, 10, L, L);
    const Eigen::VectorXd mass = node_masses(mesh, rho, t);
    CHECK(mass.size() == mesh.node_count());
    CHECK(mass.sum() == Approx(rho * t * L * L).epsilon(tolerance::rounding));
    CHECK(mass[node_at(mesh, Eigen::Vector2d(0.05, 0.05))] == Approx(rho * t * 1e-4).epsilon(tolerance::rounding));
    CHECK(mass[node_at(mesh, Eigen::Vector2d(0.0, 0.1))] == Approx(rho * t * 1e-4 / 4).epsilon(tolerance::rounding));
    CHECK(mass.minCoeff() > 0);
}
