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

/// Of 64 x 64 x 32 mm, in whole cubes of 8 mm.
SpringMesh flat() { return embedded_lattice(solid_block(Lattice{{5, 5, 3}, {0.064, 0.064, 0.032}}), h); }

/// What rows take of displacements.
Eigen::VectorXd taken(const ContactRows& rows, const NodeField& u) {
    Eigen::VectorXd own(3 * static_cast<Eigen::Index>(rows.nodes.size()));
    for (std::size_t i = 0; i < rows.nodes.size(); ++i) own.segment<3>(3 * static_cast<Eigen::Index>(i)) = u.row(rows.nodes[i]).transpose();
    return rows.pull * own;
}

double shares(const ContactRows& rows) { return rows.share.tail(rows.share.size() - 3).sum() / 3; }

}  // namespace

TEST_CASE("through the mean of a disc's own points the tissue bears 5/4 of the hand's force, and linear fields are exact in it", "[embedded]") {
    const SpringMesh mesh = flat();
    const DiscContact kernel(mesh, R);
    const Eigen::Vector3d at(0.0331, 0.0287, 0.032);
    const ContactRows rows = kernel.rows_at(at);
    REQUIRE(rows.share.size() == 3 + 3 * (PolarPoints::under + PolarPoints::beyond));
    CHECK(rows.mean.sum() == Approx(1));
    NodeField u = NodeField::Ones(mesh.node_count(), 3);
    CHECK((1.25 * rows.push.topRows<3>() * Eigen::Vector3d::Ones() - taken(rows, u).head<3>()).norm() < 1e-12);
    double hertz = 0, felt = 0;  // the pressure that a parabola has on a half space, and what is conjugate to the parabola's depth
    for (double x = 5e-5; x < 1; x += 1e-4) hertz += std::sqrt(1 - x * x) * x, felt += std::sqrt(1 - x * x) * disc_profile(x) * x;
    CHECK(hertz / felt == Approx(PolarPoints::total).epsilon(1e-4));
    Eigen::Matrix3d strain;
    strain << 1, 0.3, -2, 0.5, -1, 0.1, 0.2, 0.4, 0.7;
    u = (mesh.nodes.rowwise() - at.transpose()) * strain;
    CHECK(taken(rows, u).head<3>().norm() < 1e-12);
}

TEST_CASE("the mean of a disc's own points reaches 1.6 edges of a cube, however small the disc, and 1.5 radii of a larger one", "[embedded]") {
    const SpringMesh mesh = flat();
    const Eigen::Vector3d at(0.0331, 0.0287, 0.032);
    const auto squared_m2 = [&](const ContactRows& rows) {  // mean of the squared way along the surface
        double sum = 0;
        for (std::size_t i = 0; i < rows.nodes.size(); ++i)
            if (static_cast<Eigen::Index>(i) < rows.mean.size()) sum += rows.mean[static_cast<Eigen::Index>(i)] * (mesh.nodes.row(rows.nodes[i]).head<2>().transpose() - at.head<2>()).squaredNorm();
        return sum;
    };
    for (const double radius_m : {0.002, 0.007, 0.012}) {
        const double m = std::max(1.6 * h, 1.5 * radius_m);
        // of (1 - (r / m)^2)^2 over a circle m^2 / 4; a point between two nodes has of each axis h^2 / 6 more, on average
        CHECK(squared_m2(DiscContact(mesh, radius_m).rows_at(at)) == Approx(m * m / 4 + h * h / 3).epsilon(0.1));
    }
    const ContactRows small = DiscContact(mesh, 0.002).rows_at(at), usual = DiscContact(mesh, R).rows_at(at);
    CHECK(squared_m2(small) == Approx(squared_m2(usual)));
}

TEST_CASE("the tangent of a disc's own points is that of all its rows", "[embedded]") {
    const SpringMesh mesh = flat();
    const DiscContact kernel(mesh, R);
    PatchLaw law;
    law.log_N_m.setConstant(PatchLaw::disc_rows, PatchLaw::factors, 0.3);
    ContactRows rows = kernel.rows_at(Eigen::Vector3d(0.0011, 0.0287, 0.032));  // some points off the tissue
    const Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(rows.pull.cols(), -1e-3, 2e-3);
    const Eigen::Vector3d push(1e-3, -2e-3, -4e-3);
    REQUIRE(rows.touched.size() == 61);
    const Eigen::MatrixXd sparse = ContactSpring(rows, law).tangent(push, u);
    rows.touched.clear();
    const Eigen::MatrixXd dense = ContactSpring(rows, law).tangent(push, u);
    CHECK((sparse - dense).norm() < 1e-13 * dense.norm());
}

TEST_CASE("shares of a disc's own points are 1 in all under it, and fall to none at the imprint's end", "[embedded]") {
    const SpringMesh mesh = flat();
    const ContactRows rows = DiscContact(mesh, R).rows_at(Eigen::Vector3d(0.0331, 0.0287, 0.032));
    for (int k = 0; k < PolarPoints::under; ++k) CHECK(rows.share[3 + 3 * k] == Approx(1.0 / 24));
    for (int ring = 0; ring < 3; ++ring) {
        const double x2 = 1 + (2.5 * 2.5 - 1) * (ring + 0.5) / 3;
        for (int k = 0; k < 12; ++k) CHECK(rows.share[3 + 3 * (24 + 12 * ring + k)] == Approx(std::pow(1 - x2 / (2.5 * 2.5), 2) / 36));
    }
}

TEST_CASE("beyond all tissue a disc's own points fade; far from it there is no contact", "[embedded]") {
    const SpringMesh mesh = flat();
    const DiscContact kernel(mesh, R);
    const double whole = shares(kernel.rows_at(Eigen::Vector3d(0.032, 0.032, 0.032)));
    double before = whole;
    for (double x : {0.015, 0.011, 0.006, 0.002, 0.0001}) {
        const double here = shares(kernel.rows_at(Eigen::Vector3d(x, 0.032, 0.032)));
        CHECK(here < before);
        CHECK(here > 0.4 * whole);  // half of the disc stands on tissue at the edge
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

TEST_CASE("a disc's own point that fades to nothing still has nodes to give back what it remembers", "[embedded]") {
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

TEST_CASE("a disc that goes along an embedded solid's surface takes of the lattice what moves without jumps, over cubes' faces too", "[embedded]") {
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
        const Eigen::Matrix3d axes = rows.push.topRows<3>().transpose();  // in space: rows lie along these, which may turn at once
        for (Eigen::Index r = 0; r < now.size(); r += 3) now.segment<3>(r) = (r < 3 ? 1 : PolarPoints::under * rows.share[r]) * axes * now.segment<3>(r).eval();
        now.conservativeResize(now.size() + 1);
        now[now.size() - 1] = rows.factors[PatchLaw::curved_factor];
        if (i > 0) largest = std::max(largest, (now - before).cwiseAbs().maxCoeff());
        before = now;
    }
    CHECK(largest < 0.06);  // 0.14 mm of 300 / m are 0.043
}

TEST_CASE("the frame that a disc's points lie along turns without jumps all over a solid, and is one of unit vectors across the normal", "[embedded]") {
    const SpringMesh mesh = embedded_lattice(dome(6), 0.011);
    const PolarPoints points(mesh, 2.5);
    const auto inward = [](double polar, double azimuth) { return Eigen::Vector3d(-std::sin(polar) * std::cos(azimuth), -std::sin(polar) * std::sin(azimuth), -std::cos(polar)); };
    const double step = 1e-3;
    for (double polar = 0; polar < 2.6; polar += 0.05)  // 180 degrees: as the bed faces
        for (double azimuth = 0; azimuth < 2 * pi; azimuth += 0.05) {
            const Eigen::Vector3d n = inward(polar, azimuth);
            Eigen::Matrix3d frame;
            frame << points.tangents(n), n;
            CHECK((frame.transpose() * frame - Eigen::Matrix3d::Identity()).norm() < 1e-12);
            CHECK((points.tangents(inward(polar + step, azimuth)) - points.tangents(n)).norm() < 5 * step);
            CHECK((points.tangents(inward(polar, azimuth + step)) - points.tangents(n)).norm() < 10 * step);
        }
}

TEST_CASE("how a surface bends counts as far as it was trained, and a place's correction scales all of a contact", "[embedded]") {
    const SpringMesh mesh = flat();
    const Eigen::Vector3d place(3.2 * h, 3.1 * h, 4 * h);
    const DiscContact free(mesh, R), bounded(mesh, R, {{}, {0.1, 0.2}, {}}), corrected(mesh, R, {{}, {-9, 9}, {NodeField::Constant(mesh.facets.rows(), 6, 0.3)}});
    REQUIRE(std::abs(free.rows_at(place).factors[PatchLaw::curved_factor]) < 1e-9);
    CHECK(bounded.rows_at(place).factors[PatchLaw::curved_factor] == 0.1);
    CHECK(corrected.rows_at(place).factors == free.rows_at(place).factors);

    PatchLaw law;
    law.log_N_m.setConstant(PatchLaw::disc_rows, PatchLaw::factors, 0.1);
    law.log_N_m.col(PatchLaw::curved_factor).setConstant(3);
    const ContactSpring unscaled(free.rows_at(place), law), scaled(corrected.rows_at(place), law);
    CHECK(ContactSpring(bounded.rows_at(place), law).k_N_m[0] == Approx(unscaled.k_N_m[0] * std::exp(3 * 0.1)));
    CHECK(scaled.k_N_m.isApprox(std::exp(0.3) * unscaled.k_N_m, 1e-12));
    CHECK(scaled.hardening_1_J == Approx(std::exp(-0.3) * unscaled.hardening_1_J));
}

TEST_CASE("a place in an embedded lattice is found by its cube, and where that was left out by the nearest", "[embedded]") {
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
    CHECK_THROWS_WITH(CubeSearch(mesh.nodes, mesh.embedding.cubes, 2 * h), Contains("does not stand on a lattice of 16 mm"));
    CHECK_THROWS_WITH(CubeSearch(mesh.nodes, mesh.embedding.cubes, h / 3), Contains("does not stand on a lattice of"));
    CHECK_THROWS_WITH(CubeSearch(mesh.nodes, mesh.embedding.cubes, 1e-6 * h), Contains("stand in a box of"));
}
