#include "springs/spring_law.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "error.h"
#include "../example.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const SpringMesh& block() {
    static const SpringMesh mesh = make_lattice("grid8", 4, 3, 0.1, 0.06);
    return mesh;
}

Eigen::VectorXd force(const std::string& law, const NodeField& u) {
    return make_spring_law(law)->force_matrix(block(), u) * example_theta(block());
}

/// A spring from the origin to a point [m].
SpringMesh one_spring(double x, double y) {
    SpringMesh one;
    one.nodes.resize(2, 2);
    one.nodes << 0, 0, x, y;
    one.springs.resize(1, 2);
    one.springs << 0, 1;
    return one;
}

/// u = H x.
NodeField affine(const Eigen::Matrix2d& H) {
    return block().nodes * H.transpose();
}

Eigen::Matrix2d rotation(double angle) {
    return Eigen::Rotation2Dd(angle).toRotationMatrix();
}

}  // namespace

TEST_CASE("a spring of 2 N/m stretched by 1 mm along its axis has a force of 2 mN in every spring law") {
    const SpringMesh one = one_spring(0.03, 0.04);
    NodeField u = NodeField::Zero(2, 2);
    u.row(1) << 0.0006, 0.0008;
    for (const char* name : {"isotropic", "axial", "geometric"}) {
        INFO(name);
        const Eigen::VectorXd f = make_spring_law(name)->force_matrix(one, u) * Eigen::VectorXd::Constant(1, 2.0);
        Eigen::VectorXd expected(4);
        expected << -0.0012, -0.0016, 0.0012, 0.0016;
        CHECK((f - expected).norm() <= tolerance::rounding * 0.05);  // geometric subtracts lengths of 0.05 m
    }
}

TEST_CASE("across its axis an isotropic spring resists fully; an axial one not; a geometric one by extension") {
    const SpringMesh one = one_spring(0.05, 0);
    NodeField u = NodeField::Zero(2, 2);
    u(1, 1) = 0.001;
    const Eigen::VectorXd k = Eigen::VectorXd::Constant(1, 2.0);
    const auto at_end = [&](const char* law) {
        const Eigen::VectorXd f = make_spring_law(law)->force_matrix(one, u) * k;
        return Eigen::Vector2d(f[2], f[3]);
    };
    CHECK((at_end("isotropic") - Eigen::Vector2d(0, 0.002)).norm() <= tolerance::rounding);
    CHECK(at_end("axial").norm() <= tolerance::rounding);
    const double length = std::hypot(0.05, 0.001);
    CHECK((at_end("geometric") - 2 * (length - 0.05) / length * Eigen::Vector2d(0.05, 0.001)).norm() <=
          tolerance::rounding);
}

TEST_CASE("spring forces vanish under rigid translation") {
    NodeField u(block().node_count(), 2);
    u.rowwise() = Eigen::RowVector2d(0.013, -0.007);
    const double size = force("isotropic", scattered(block(), 0.01)).norm();
    for (const std::string& name : spring_laws().names()) CHECK(force(name, u).norm() <= tolerance::rounding * size);
}

TEST_CASE("geometric springs have no force under rotations of any size; linear laws have one") {
    const double size = force("isotropic", scattered(block(), 0.01)).norm();
    for (double angle : {0.1, 1.0, 3.0}) {
        const NodeField u = affine(rotation(angle) - Eigen::Matrix2d::Identity());
        CHECK(force("geometric", u).norm() <= tolerance::rounding * size);
        CHECK(force("axial", u).norm() > 1e-3 * size);
        CHECK(force("isotropic", u).norm() > 1e-3 * size);
    }
}

TEST_CASE("axial springs have no force under an infinitesimal rotation; isotropic ones have one") {
    Eigen::Matrix2d spin;
    spin << 0, -0.01, 0.01, 0;
    const double size = force("isotropic", affine(spin)).norm();
    CHECK(force("axial", affine(spin)).norm() <= tolerance::rounding * size);
    CHECK(size > 0);
}

TEST_CASE("forces of geometric springs rotate with the tissue") {
    const NodeField u = scattered(block(), 0.003);
    const Eigen::Matrix2d R = rotation(0.7);
    const NodeField turned = (block().nodes + u) * R.transpose() - block().nodes;
    const Eigen::VectorXd f = force("geometric", u), g = force("geometric", turned);
    const NodeField expected = Eigen::Map<const NodeField>(f.data(), u.rows(), 2) * R.transpose();
    CHECK((g - as_vector(expected)).norm() <= tolerance::rounding * g.norm() * 100);  // forces are differences of lengths
}

TEST_CASE("spring forces sum to zero; so do moments of axial and of geometric springs") {
    const NodeField u = scattered(block(), 0.003);
    for (const std::string& name : spring_laws().names()) {
        INFO(name);
        const Eigen::VectorXd flat = force(name, u);
        const NodeField f = Eigen::Map<const NodeField>(flat.data(), u.rows(), 2);
        CHECK(f.colwise().sum().norm() <= tolerance::rounding * f.norm());
        if (name == "isotropic") continue;  // its transverse force has a moment
        const NodeField x = name == "axial" ? block().nodes : NodeField(block().nodes + u);
        const double moment = (x.col(0).cwiseProduct(f.col(1)) - x.col(1).cwiseProduct(f.col(0))).sum();
        CHECK(std::abs(moment) <= tolerance::rounding * f.norm());
    }
}

TEST_CASE("axial and geometric springs agree to first order in displacement") {
    const auto difference = [&](double size) {
        return (force("geometric", scattered(block(), size)) - force("axial", scattered(block(), size))).norm();
    };
    const double order = std::log2(difference(2e-5) / difference(1e-5));
    CHECK(order == Approx(2).margin(tolerance::order));
}

TEST_CASE("geometric stiffness is the derivative of force: halving the difference step quarters the error") {
    const Eigen::VectorXd theta = example_theta(block());
    const NodeField u = scattered(block(), 0.003), du = scattered(block(), 1.0).rowwise().reverse();
    const auto law = make_spring_law("geometric");
    const Eigen::VectorXd exact = law->stiffness(block(), theta, u) * as_vector(du);
    const auto error = [&](double h) {
        const NodeField ahead = u + h * du, behind = u - h * du;
        const Eigen::VectorXd slope =
            (law->force_matrix(block(), ahead) * theta - law->force_matrix(block(), behind) * theta) / (2 * h);
        return (slope - exact).norm() / exact.norm();
    };
    CHECK(std::log2(error(2e-4) / error(1e-4)) == Approx(2).margin(tolerance::order));
    CHECK(error(1e-6) < 1e-6);
}

TEST_CASE("force matrix times theta equals stiffness times u for the linear laws") {
    const Eigen::VectorXd theta = example_theta(block());
    const NodeField u = scattered(block(), 0.01);
    for (const char* name : {"isotropic", "axial"}) {
        const auto law = make_spring_law(name);
        CHECK(law->linear_in_displacement());
        const Eigen::VectorXd f = law->force_matrix(block(), u) * theta,
                              Ku = law->stiffness(block(), theta, u) * as_vector(u);
        CHECK((f - Ku).norm() <= tolerance::rounding * f.norm());
    }
    CHECK_FALSE(make_spring_law("geometric")->linear_in_displacement());
}

TEST_CASE("stiffness is symmetric; at rest it is positive along a scattered displacement") {
    const Eigen::VectorXd theta = example_theta(block());
    for (const std::string& name : spring_laws().names()) {
        const auto law = make_spring_law(name);
        const Eigen::MatrixXd K = law->stiffness(block(), theta, scattered(block(), 0.002));
        CHECK((K - K.transpose()).norm() <= tolerance::rounding * K.norm());
        const Eigen::MatrixXd at_rest = law->stiffness(block(), theta, NodeField::Zero(block().node_count(), 2));
        const Eigen::VectorXd v = as_vector(scattered(block(), 1.0));
        CHECK(v.dot(at_rest * v) > 0);
    }
}

TEST_CASE("uniform compression of a lattice loads each spring in proportion to its shortening") {
    // 1 % along x: each spring along x shortens by 1 % of its length, each along y not at all
    const SpringMesh mesh = make_lattice("grid4", 4, 3, 0.1, 0.06);
    NodeField u = NodeField::Zero(mesh.node_count(), 2);
    u.col(0) = -0.01 * mesh.nodes.col(0);
    const SparseMatrix A = make_spring_law("axial")->force_matrix(mesh, u);
    for (int s = 0; s < mesh.spring_count(); ++s) {
        const bool along_x = mesh.nodes(mesh.springs(s, 0), 1) == mesh.nodes(mesh.springs(s, 1), 1);
        const Eigen::VectorXd column = A.col(s);
        CHECK(column.norm() == Approx(along_x ? std::sqrt(2) * 0.01 * 0.025 : 0).margin(tolerance::rounding * 0.1));
    }
}

TEST_CASE("make_spring_law makes the law of a name and refuses an unknown name with the known ones") {
    for (const std::string& name : spring_laws().names()) CHECK(make_spring_law(name)->name() == name);
    CHECK_THAT(refusal<MismatchError>([] { make_spring_law("elastic"); }),
               Contains("elastic") && Contains("isotropic, axial, geometric"));
}

TEST_CASE("a geometric spring with coincident nodes has finite force and stiffness") {
    const SpringMesh one = one_spring(0.05, 0);
    NodeField u = NodeField::Zero(2, 2);
    u(1, 0) = -0.05;
    const auto law = make_spring_law("geometric");
    CHECK(Eigen::MatrixXd(law->force_matrix(one, u)).allFinite());
    CHECK(Eigen::MatrixXd(law->stiffness(one, Eigen::VectorXd::Ones(1), u)).allFinite());
}
