#include "springs/tissue_energy.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <algorithm>
#include <cmath>

#include "error.h"
#include "springs/cell_areas.h"
#include "../example.h"
#include "../mesh/disc.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

std::vector<SpringMesh> meshes() { return {make_lattice("grid8", 4, 3, 0.1, 0.06), edge_mesh(disc(12))}; }

Eigen::VectorXd some_constants(const TissueEnergy& energy) {
    Eigen::VectorXd c(energy.constant_count());
    for (Eigen::Index i = 0; i < c.size(); ++i) c[i] = 1.5 + std::sin(1.7 * static_cast<double>(i));
    return c;
}

/// Largest difference over the largest entry of b.
double off(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("tissue at rest stores no energy and exerts no force") {
    for (const SpringMesh& mesh : meshes()) {
        const TissueEnergy energy(mesh, true);
        const Eigen::VectorXd c = some_constants(energy);
        const NodeField rest = NodeField::Zero(mesh.node_count(), 2);
        CHECK(energy.energy(c, rest) <= tolerance::rounding * energy.energy(c, scattered(mesh, 0.001)));
        CHECK(energy.force(c, rest).norm() <= tolerance::rounding * energy.force(c, scattered(mesh, 0.001)).norm());
        CHECK(energy.smallest_ratio(rest) == Approx(1).epsilon(tolerance::rounding));
    }
}

TEST_CASE("a square cell at half its height stores the energies of its springs and of its change of area") {
    const SpringMesh mesh = make_lattice("grid8", 1, 1, 0.1, 0.1);
    const TissueEnergy energy(mesh, false);
    REQUIRE(energy.constant_count() == 7);
    NodeField u = NodeField::Zero(4, 2);
    u(2, 1) = u(3, 1) = -0.05;
    // two vertical springs shorter by 0.05, two diagonals from 0.1 sqrt 2 to 0.1 sqrt 1.25, half the area
    const double diagonal = 0.1 * (std::sqrt(1.25) - std::sqrt(2.0));
    const Eigen::VectorXd springs = (Eigen::VectorXd(7) << 1, 1, 1, 1, 1, 1, 0).finished();
    CHECK(energy.energy(springs, u) == Approx(0.05 * 0.05 + diagonal * diagonal).epsilon(tolerance::rounding));
    const Eigen::VectorXd cell = (Eigen::VectorXd(7) << 0, 0, 0, 0, 0, 0, 3).finished();
    CHECK(energy.energy(cell, u) == Approx(3 * 0.01 * 0.25 / 2).epsilon(tolerance::rounding));
    CHECK(energy.smallest_ratio(u) == Approx(0.5).epsilon(tolerance::rounding));
}

TEST_CASE("force is the derivative of the energy and tangent that of the force; also with inverted cells") {
    for (const SpringMesh& mesh : meshes())
        for (double size : {0.003, 0.05}) {
            const TissueEnergy energy(mesh, true, size < 0.01 ? SpringCurve::mooney_rivlin(0.5, 2, 0.9, 1.05) : SpringCurve());
            const Eigen::VectorXd c = some_constants(energy);
            const NodeField u = scattered(mesh, size);
            if (size > 0.01) REQUIRE(energy.smallest_ratio(u) < 0);
            const NodeField force = energy.force(c, u);
            const Eigen::MatrixXd tangent = energy.tangent(c, u);
            NodeField slope(u.rows(), 2);
            Eigen::MatrixXd bend(u.size(), u.size());
            const double h = 1e-6;
            for (Eigen::Index i = 0; i < u.size(); ++i) {
                NodeField ahead = u, behind = u;
                ahead.data()[i] += h;
                behind.data()[i] -= h;
                slope.data()[i] = (energy.energy(c, ahead) - energy.energy(c, behind)) / (2 * h);
                const NodeField difference = (energy.force(c, ahead) - energy.force(c, behind)) / (2 * h);
                bend.col(i) = as_vector(difference);
            }
            CHECK(off(slope, force) <= tolerance::difference);
            CHECK(off(bend, tangent) <= tolerance::difference);
            CHECK(off(tangent.transpose(), tangent) <= tolerance::rounding);
        }
}

TEST_CASE("energy and force are linear in the constants") {
    for (const SpringMesh& mesh : meshes()) {
        const TissueEnergy energy(mesh, true);
        const Eigen::VectorXd c = some_constants(energy), d = c.cwiseInverse();
        const NodeField u = scattered(mesh, 0.003);
        CHECK(off(as_vector(energy.force(2 * c + d, u)), Eigen::VectorXd(2 * as_vector(energy.force(c, u)) + as_vector(energy.force(d, u)))) <= tolerance::rounding);
        CHECK(energy.energy(2 * c, u) == Approx(2 * energy.energy(c, u)).epsilon(tolerance::rounding));
    }
}

TEST_CASE("forces of springs and cells vanish under rigid translation and rotation of any size") {
    for (const SpringMesh& mesh : meshes()) {
        const TissueEnergy energy(mesh, true);
        const Eigen::VectorXd c = some_constants(energy);
        const double size = energy.force(c, scattered(mesh, 0.01)).norm();
        for (double angle : {0.0, 0.1, 1.0, 3.0}) {
            const Eigen::Matrix2d R = Eigen::Rotation2Dd(angle).toRotationMatrix();
            const NodeField u = (mesh.nodes * R.transpose() - mesh.nodes).rowwise() + Eigen::RowVector2d(0.013, -0.007);
            CHECK(energy.force(c, u).norm() <= tolerance::rounding * size);
        }
    }
}

TEST_CASE("a rotation of deformed tissue keeps its energy and rotates its forces") {
    for (const SpringMesh& mesh : meshes()) {
        const TissueEnergy energy(mesh, true);
        const Eigen::VectorXd c = some_constants(energy);
        const NodeField u = scattered(mesh, 0.003);
        const Eigen::Matrix2d R = Eigen::Rotation2Dd(0.7).toRotationMatrix();
        const NodeField turned = (mesh.nodes + u) * R.transpose() - mesh.nodes;
        CHECK(off(energy.force(c, turned), energy.force(c, u) * R.transpose()) <= 100 * tolerance::rounding);
        CHECK(energy.energy(c, turned) == Approx(energy.energy(c, u)).epsilon(100 * tolerance::rounding));
    }
}

TEST_CASE("smallest_ratio detects an inverted triangle also where the nodal area is unchanged") {
    const SpringMesh mesh = edge_mesh(disc(12));
    const TissueEnergy energy(mesh, false);
    int centre = 0;
    const std::vector<int> loop = mesh.loop();
    while (std::find(loop.begin(), loop.end(), centre) != loop.end()) ++centre;
    NodeField u = NodeField::Zero(mesh.node_count(), 2);
    const Eigen::RowVector2d rim = (mesh.nodes.row(mesh.loop()[0]) + mesh.nodes.row(mesh.loop()[1])) / 2;
    u.row(centre) = 1.01 * (rim - mesh.nodes.row(centre));  // just beyond that side
    CHECK(energy.smallest_ratio(u) == Approx(-0.01).epsilon(1e-6));
    Eigen::VectorXd star = Eigen::VectorXd::Zero(energy.constant_count());
    star[mesh.spring_count() + centre] = 1;
    CHECK(energy.energy(star, u) <= tolerance::rounding);
}

TEST_CASE("cells exert no force under a shear or a stretch that keeps their area") {
    const SpringMesh mesh = make_lattice("grid8", 4, 3, 0.1, 0.06);
    const CellAreas cells(mesh);
    NodeField sheared = NodeField::Zero(mesh.node_count(), 2), stretched = sheared;
    sheared.col(0) = 0.4 * mesh.nodes.col(1);
    stretched.col(0) = 0.25 * mesh.nodes.col(0);
    stretched.col(1) = -0.2 * mesh.nodes.col(1);  // 1.25 x 0.8 = 1
    ElementVector f;
    for (int e = 0; e < cells.count(); ++e)
        for (const NodeField& u : {sheared, stretched}) {
            cells.force(e, u, f);
            CHECK(f.norm() <= tolerance::rounding);
        }
}

TEST_CASE("the energy of a region depends on the area in its outline and not on inner nodes") {
    const SpringMesh mesh = make_lattice("grid8", 4, 3, 0.1, 0.06);
    const TissueEnergy energy(mesh, true);
    const int first = TissueEnergy(mesh, false).constant_count();
    REQUIRE(energy.constant_count() == first + 5);
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(energy.constant_count());
    whole[first] = 5;
    NodeField swollen = 0.1 * mesh.nodes;
    const std::vector<int> loop = mesh.loop();
    CHECK(energy.energy(whole, swollen) == Approx(5 * 0.006 * 0.21 * 0.21 / 2).epsilon(tolerance::rounding));
    for (int node = 0; node < mesh.node_count(); ++node)
        if (std::find(loop.begin(), loop.end(), node) == loop.end()) swollen.row(node).setZero();
    CHECK(energy.energy(whole, swollen) == Approx(5 * 0.006 * 0.21 * 0.21 / 2).epsilon(tolerance::rounding));
}

TEST_CASE("springs of E2 = 1 have lambda = mu = 1/2 and cells add their constant to lambda") {
    // whole lattice under uniform strain; Van Gelder's springs of E2 = 1: axes 1, diagonals 1/2, boundary half of that
    const SpringMesh mesh = make_lattice("grid8", 6, 6, 0.06, 0.06);
    const TissueEnergy energy(mesh, false);
    const double cell = 0.7;
    Eigen::VectorXd c(energy.constant_count());
    for (int s = 0; s < mesh.spring_count(); ++s) c[s] = mesh.incident_measure[s] / (mesh.rest_length(s) * mesh.rest_length(s));
    c.tail(36).setConstant(cell);
    // energy density of a small strain, over the strain's square
    const auto density = [&](double xx, double yy, double xy) {
        const double small = 1e-5;
        NodeField u(mesh.node_count(), 2);
        u.col(0) = small * (xx * mesh.nodes.col(0) + xy * mesh.nodes.col(1));
        u.col(1) = small * (xy * mesh.nodes.col(0) + yy * mesh.nodes.col(1));
        return energy.energy(c, u) / (0.06 * 0.06) / (small * small);
    };
    const double lambda = 0.5 + cell, mu = 0.5;
    CHECK(density(1, 0, 0) == Approx(lambda / 2 + mu).epsilon(1e-4));
    CHECK(density(1, 1, 0) == Approx(2 * lambda + 2 * mu).epsilon(1e-4));
    CHECK(density(1, -1, 0) == Approx(2 * mu).epsilon(1e-4));
    CHECK(density(0, 0, 1) == Approx(2 * mu).epsilon(1e-4));
}

TEST_CASE("CellAreas refuses a mesh in space and clockwise cells") {
    SpringMesh mesh = make_lattice("grid8", 2, 2, 0.1, 0.1);
    SpringMesh solid = mesh;
    solid.nodes = NodeField::Zero(9, 3);
    CHECK_THAT(refusal<MismatchError>([&] { CellAreas cells(solid); }), Contains("in the plane"));
    mesh.nodes.col(0) *= -1;
    CHECK_THAT(refusal<MismatchError>([&] { CellAreas cells(mesh); }), Contains("clockwise"));
}
