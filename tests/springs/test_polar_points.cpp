#include "springs/polar_points.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../mesh/dome.h"
#include "mesh/solid_block.h"
#include "mesh/embedded_lattice.h"
#include "springs/contact_spring.h"
#include "springs/disc_contact.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

constexpr double h = 0.008, R = 0.007, pi = 3.14159265358979323846;
const Eigen::Vector3d down(0, 0, -1);

/// A block of 64 x 64 x 32 mm in whole cubes of 8 mm.
SpringMesh flat() { return embedded_lattice(solid_block(Lattice{{5, 5, 3}, {0.064, 0.064, 0.032}}), h); }

/// The rows' sums of nodal displacements.
Eigen::VectorXd taken(const ContactRows& rows, const NodeField& u) {
    Eigen::VectorXd own(3 * static_cast<Eigen::Index>(rows.nodes.size()));
    for (std::size_t i = 0; i < rows.nodes.size(); ++i) own.segment<3>(3 * static_cast<Eigen::Index>(i)) = u.row(rows.nodes[i]).transpose();
    return rows.pull * own;
}

double shares(const ContactRows& rows) { return rows.share.tail(rows.share.size() - 3).sum() / 3; }

}  // namespace

TEST_CASE("the mean of a disc's points has total weight 5/4 of the tool's force and is exact for linear fields", "[embedded]") {
    const SpringMesh mesh = flat();
    const DiscContact kernel(mesh, R);
    const Eigen::Vector3d at(0.0331, 0.0287, 0.032);
    const ContactRows rows = kernel.rows_at(at);
    REQUIRE(rows.share.size() == 3 + 3 * (PolarPoints::under + PolarPoints::beyond));
    CHECK(rows.mean.sum() == Approx(1));
    NodeField u = NodeField::Ones(mesh.node_count(), 3);
    CHECK((1.25 * rows.push.topRows<3>() * Eigen::Vector3d::Ones() - taken(rows, u).head<3>()).norm() < 1e-12);
    // integrals of Hertz's pressure p and of p phi, which is conjugate to the tool displacement
    double hertz = 0, felt = 0;
    for (double x = 5e-5; x < 1; x += 1e-4) hertz += std::sqrt(1 - x * x) * x, felt += std::sqrt(1 - x * x) * disc_profile(x) * x;
    CHECK(hertz / felt == Approx(PolarPoints::total).epsilon(1e-4));
    Eigen::Matrix3d strain;
    strain << 1, 0.3, -2, 0.5, -1, 0.1, 0.2, 0.4, 0.7;
    u = (mesh.nodes.rowwise() - at.transpose()) * strain;
    CHECK(taken(rows, u).head<3>().norm() < 1e-12);
}

TEST_CASE("the mean of a disc's points reaches the larger of 1.6 cube edges and 1.5 radii", "[embedded]") {
    const SpringMesh mesh = flat();
    const Eigen::Vector3d at(0.0331, 0.0287, 0.032);
    const auto squared_m2 = [&](const ContactRows& rows) {  // weighted mean of the squared distance along the surface
        double sum = 0;
        for (std::size_t i = 0; i < rows.nodes.size(); ++i)
            if (static_cast<Eigen::Index>(i) < rows.mean.size()) sum += rows.mean[static_cast<Eigen::Index>(i)] * (mesh.nodes.row(rows.nodes[i]).head<2>().transpose() - at.head<2>()).squaredNorm();
        return sum;
    };
    for (const double radius_m : {0.002, 0.007, 0.012}) {
        const double m = std::max(1.6 * h, 1.5 * radius_m);
        // m^2 / 4 for weights (1 - (r / m)^2)^2 on a circle; interpolation between nodes adds h^2 / 6 per axis on
        // average
        CHECK(squared_m2(DiscContact(mesh, radius_m).rows_at(at)) == Approx(m * m / 4 + h * h / 3).epsilon(0.1));
    }
    const ContactRows small = DiscContact(mesh, 0.002).rows_at(at), usual = DiscContact(mesh, R).rows_at(at);
    CHECK(squared_m2(small) == Approx(squared_m2(usual)));
}

TEST_CASE("the sparse tangent of a disc's points is the dense one of all its rows", "[embedded]") {
    const SpringMesh mesh = flat();
    const DiscContact kernel(mesh, R);
    ContactParameters contact_parameters;
    contact_parameters.log_N_m.setConstant(ContactParameters::disc_rows, ContactParameters::factors, 0.3);
    ContactRows rows = kernel.rows_at(Eigen::Vector3d(0.0011, 0.0287, 0.032));  // some points outside the tissue
    const Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(rows.pull.cols(), -1e-3, 2e-3);
    const Eigen::Vector3d push(1e-3, -2e-3, -4e-3);
    REQUIRE(rows.touched.size() == 61);
    const Eigen::MatrixXd sparse = ContactSpring(rows, contact_parameters).tangent(push, u);
    rows.touched.clear();
    const Eigen::MatrixXd dense = ContactSpring(rows, contact_parameters).tangent(push, u);
    CHECK((sparse - dense).norm() < 1e-13 * dense.norm());
}

TEST_CASE("shares of a disc's points sum to 1 under it and decrease to 0 at the imprint's end", "[embedded]") {
    const SpringMesh mesh = flat();
    const ContactRows rows = DiscContact(mesh, R).rows_at(Eigen::Vector3d(0.0331, 0.0287, 0.032));
    for (int k = 0; k < PolarPoints::under; ++k) CHECK(rows.share[3 + 3 * k] == Approx(1.0 / 24));
    for (int ring = 0; ring < 3; ++ring) {
        const double x2 = 1 + (2.5 * 2.5 - 1) * (ring + 0.5) / 3;
        for (int k = 0; k < 12; ++k) CHECK(rows.share[3 + 3 * (24 + 12 * ring + k)] == Approx(std::pow(1 - x2 / (2.5 * 2.5), 2) / 36));
    }
}

TEST_CASE("shares of a disc's points decrease beyond the tissue's edge; far away there is no contact", "[embedded]") {
    const SpringMesh mesh = flat();
    const DiscContact kernel(mesh, R);
    const double whole = shares(kernel.rows_at(Eigen::Vector3d(0.032, 0.032, 0.032)));
    double before = whole;
    for (double x : {0.015, 0.011, 0.006, 0.002, 0.0001}) {
        const double here = shares(kernel.rows_at(Eigen::Vector3d(x, 0.032, 0.032)));
        CHECK(here < before);
        CHECK(here > 0.4 * whole);  // at the edge half of the disc is over tissue
        before = here;
    }
    const PolarPoints points(mesh, 2.5);
    Footing footing;
    SurfaceQuadric away{Eigen::Vector3d(1, 1, 1), down, Eigen::Matrix<double, 3, 2>::Identity(), Eigen::Vector2d::Zero(), Eigen::Matrix2d::Zero()};
    points.lay(away, R, [](const Eigen::Vector3d&, double) { return Eigen::Matrix3d(Eigen::Matrix3d::Identity()); }, footing);
    CHECK(footing.means == 0);
    CHECK(footing.entries == 0);
    for (int k = 0; k < footing.points; ++k) CHECK(footing.point[k].share == 0);
}

TEST_CASE("a disc's point of share 0 keeps its eight nodes for its branch state", "[embedded]") {
    const SpringMesh mesh = flat();
    const PolarPoints points(mesh, 2.5);
    Footing footing;
    Eigen::Matrix<double, 3, 2> tangents = Eigen::Matrix<double, 3, 2>::Identity();
    const SurfaceQuadric ridge{Eigen::Vector3d(0.032, 0.032, 0.032), down, tangents, Eigen::Vector2d::Zero(), Eigen::Matrix2d::Identity() / R};
    points.lay(ridge, R, [](const Eigen::Vector3d&, double) { return Eigen::Matrix3d(Eigen::Matrix3d::Identity()); }, footing);
    const Footing::Point& outer = footing.point[PolarPoints::under + PolarPoints::beyond - 1];
    CHECK(outer.share == 0);
    CHECK(outer.end - outer.begin == 8);
}

TEST_CASE("displacements under a disc that moves along an embedded surface are continuous across cube faces", "[embedded]") {
    const SpringMesh mesh = embedded_lattice(dome(8), 0.009);
    const DiscContact kernel(mesh, R);
    const NodeField u = (mesh.nodes.array() * 300).sin().matrix();  // smooth, of size 1
    const FreeSurface surface(mesh);
    Eigen::VectorXd before;
    double largest = 0;
    for (int i = 0; i < 1000; ++i) {  // from one side over the top to the other
        const double angle = pi * (0.12 + 0.76 * i / 1000);
        const ContactRows rows = kernel.rows_at(surface.nearest(Eigen::Vector3d(-0.06 * std::cos(angle), 0.0043, 0.06 * std::sin(angle))).point_m);
        REQUIRE(rows.share.size() == 3 + 3 * (PolarPoints::under + PolarPoints::beyond));
        Eigen::VectorXd now = taken(rows, u);
        // to global axes, because the axes of the rows may turn discontinuously
        const Eigen::Matrix3d axes = rows.push.topRows<3>().transpose();
        for (Eigen::Index r = 0; r < now.size(); r += 3) now.segment<3>(r) = (r < 3 ? 1 : PolarPoints::under * rows.share[r]) * axes * now.segment<3>(r).eval();
        now.conservativeResize(now.size() + 1);
        now[now.size() - 1] = rows.factors[ContactParameters::curved_factor];
        if (i > 0) largest = std::max(largest, (now - before).cwiseAbs().maxCoeff());
        before = now;
    }
    CHECK(largest < 0.06);  // a step of 0.14 mm times the gradient 300 / m is 0.043
}

TEST_CASE("the tangent frame of a disc's points is orthonormal and continuous except where the bed faces", "[embedded]") {
    const SpringMesh mesh = embedded_lattice(dome(6), 0.011);
    const PolarPoints points(mesh, 2.5);
    const auto inward = [](double polar, double azimuth) { return Eigen::Vector3d(-std::sin(polar) * std::cos(azimuth), -std::sin(polar) * std::sin(azimuth), -std::cos(polar)); };
    const double step = 1e-3;
    for (double polar = 0; polar < 2.6; polar += 0.05)  // 180 degrees: the direction that the bed faces
        for (double azimuth = 0; azimuth < 2 * pi; azimuth += 0.05) {
            const Eigen::Vector3d n = inward(polar, azimuth);
            Eigen::Matrix3d frame;
            frame << points.tangents(n), n;
            CHECK((frame.transpose() * frame - Eigen::Matrix3d::Identity()).norm() < 1e-12);
            CHECK((points.tangents(inward(polar + step, azimuth)) - points.tangents(n)).norm() < 5 * step);
            CHECK((points.tangents(inward(polar, azimuth + step)) - points.tangents(n)).norm() < 10 * step);
        }
}

TEST_CASE("the curvature factor is clamped to its trained range; a correction scales the whole contact", "[embedded]") {
    const SpringMesh mesh = flat();
    const Eigen::Vector3d place(3.2 * h, 3.1 * h, 4 * h);
    const DiscContact free(mesh, R), bounded(mesh, R, {{}, {0.1, 0.2}, {}}), corrected(mesh, R, {{}, {-9, 9}, {NodeField::Constant(mesh.facets.rows(), 6, 0.3)}});
    REQUIRE(std::abs(free.rows_at(place).factors[ContactParameters::curved_factor]) < 1e-9);
    CHECK(bounded.rows_at(place).factors[ContactParameters::curved_factor] == 0.1);
    CHECK(corrected.rows_at(place).factors == free.rows_at(place).factors);

    ContactParameters contact_parameters;
    contact_parameters.log_N_m.setConstant(ContactParameters::disc_rows, ContactParameters::factors, 0.1);
    contact_parameters.log_N_m.col(ContactParameters::curved_factor).setConstant(3);
    const ContactSpring unscaled(free.rows_at(place), contact_parameters), scaled(corrected.rows_at(place), contact_parameters);
    CHECK(ContactSpring(bounded.rows_at(place), contact_parameters).k_N_m[0] == Approx(unscaled.k_N_m[0] * std::exp(3 * 0.1)));
    CHECK(scaled.k_N_m.isApprox(std::exp(0.3) * unscaled.k_N_m, 1e-12));
    CHECK(scaled.hardening_1_J == Approx(std::exp(-0.3) * unscaled.hardening_1_J));
}

TEST_CASE("CubeSearch finds the cube of a place or the nearest of its neighbours or none far away", "[embedded]") {
    const SpringMesh mesh = flat();
    const CubeSearch search(mesh.nodes, mesh.embedding.cubes, h);
    for (Eigen::Index c = 0; c < mesh.embedding.cubes.rows(); ++c) {
        const Eigen::Vector3d in = mesh.nodes.row(mesh.embedding.cubes(c, 0)).transpose() + h * Eigen::Vector3d(0.2, 0.5, 0.9);
        const CubeSearch::Found found = search.at(in);
        REQUIRE(found.cube == c);
        CHECK(found.away == 0);
        CHECK(found.weight[6] == Approx(0.8 * 0.5 * 0.9));
    }
    const CubeSearch::Found above = search.at(Eigen::Vector3d(0.5 * h, 0.5 * h, 4.5 * h));
    REQUIRE(above.cube >= 0);
    CHECK(above.away == Approx(0.5));
    CHECK(above.weight[4] == Approx(1.5 / 4));
    CHECK(above.weight[0] == Approx(-0.5 / 4));
    CHECK(search.at(Eigen::Vector3d(0.5 * h, 0.5 * h, 6.5 * h)).cube == -1);
    CHECK(search.at(Eigen::Vector3d(-1e9, 0.5 * h, 1e30)).cube == -1);
    CHECK_THROWS_WITH(CubeSearch(mesh.nodes, mesh.embedding.cubes, 2 * h), Contains("is not on a lattice of 16 mm"));
    CHECK_THROWS_WITH(CubeSearch(mesh.nodes, mesh.embedding.cubes, h / 3), Contains("is not on a lattice of"));
    CHECK_THROWS_WITH(CubeSearch(mesh.nodes, mesh.embedding.cubes, 1e-6 * h), Contains("are in a box of"));
}
