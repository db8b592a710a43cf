#include "mesh/nodule_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "../refusal.h"
#include "dome.h"
#include "error.h"
#include "mesh/carried_points.h"
#include "mesh/embedded_lattice.h"

using namespace tissue;

namespace {

NoduleSurface ball() { return nodule_surface(Inclusion(Eigen::Vector3d(0.03, -0.02, 0.5), 0.008)); }

/// A tetrahedron, normals out.
NoduleSurface corner() {
    NoduleSurface s{NodeField(4, 3), Cells(4, 3)};
    s.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    s.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
    return s;
}

}  // namespace

TEST_CASE("a ball's surface is 320 even triangles with corners on it that enclose 96 to 97 per cent of it") {
    const NoduleSurface s = ball();
    CHECK(s.points.rows() == 162);
    REQUIRE(s.triangles.rows() == 320);
    CHECK_FALSE(nodule_fault(s));
    for (const auto& p : s.points.rowwise()) CHECK((p.transpose() - Eigen::Vector3d(0.03, -0.02, 0.5)).norm() == Approx(0.008).epsilon(1e-12));
    double least = 1e9, most = 0;
    for (const auto& t : s.triangles.rowwise())
        for (int k = 0; k < 3; ++k) {
            const double side = (s.points.row(t[k]) - s.points.row(t[(k + 1) % 3])).norm();
            least = std::min(least, side), most = std::max(most, side);
        }
    CHECK(most < 1.25 * least);
    const double part = enclosed_by({s.points, s.triangles, {}}).volume_m3 / Inclusion(Eigen::Vector3d(0.03, -0.02, 0.5), 0.008).volume_m3();
    CHECK((part > 0.96 && part < 0.97));
}

TEST_CASE("nodule_surface returns the surface of a file's nodule and nothing above 20000 points") {
    const Surface given{corner().points, corner().triangles, {Surface::free_label, Surface::free_label, Surface::free_label, Surface::free_label}};
    const NoduleSurface s = nodule_surface(Inclusion(given));
    CHECK(s.points == given.nodes);
    CHECK(s.triangles == given.triangles);
    Surface large = given;
    large.nodes = given.nodes.replicate(5001, 1).eval();
    CHECK(nodule_surface(Inclusion(large)).empty());
}

TEST_CASE("nodule_fault detects open surfaces and inward normals and unused points") {
    CHECK_FALSE(nodule_fault(corner()));
    NoduleSurface open = corner(), inward = corner(), turned = corner(), twice = corner(), more = corner();
    open.triangles.conservativeResize(3, 3);
    CHECK(nodule_fault(open)->find("are not closed") != std::string::npos);
    inward.triangles.col(1).swap(inward.triangles.col(2));
    CHECK(nodule_fault(inward)->find("have inward normals") != std::string::npos);
    turned.triangles.row(3) << 1, 3, 2;
    CHECK(nodule_fault(turned)->find("are not closed") != std::string::npos);
    twice.triangles.conservativeResize(8, 3);
    twice.triangles.bottomRows(4) = corner().triangles;
    CHECK(nodule_fault(twice)->find("are not closed") != std::string::npos);
    more.points.conservativeResize(5, 3);
    more.points.row(4) << 2, 2, 2;
    CHECK(*nodule_fault(more) == "do not use point 4");
}

TEST_CASE("carried points follow an affine motion of the mesh exactly inside and outside it") {
    const SpringMesh mesh = embedded_lattice(dome(6), 0.011);
    NodeField points(4, 3);
    const Eigen::RowVector3d middle = mesh.own_nodes().colwise().mean();
    points << middle, middle + Eigen::RowVector3d(0.004, -0.003, 0.005), mesh.nodes.row(mesh.simplices(0, 2)), middle + Eigen::RowVector3d(0, 0, 0.2);
    const CarriedPoints carried = carried_points(mesh, points);
    CHECK((carried.weight.rowwise().sum().array() - 1).abs().maxCoeff() < 1e-9);
    CHECK(carried.weight.topRows(3).minCoeff() > -1e-9);
    CHECK(carried.weight.row(3).minCoeff() < -0.1);
    // nodes of the solid, whose displacements a page gets
    CHECK(carried.node.maxCoeff() < mesh.embedding.node_count());
    Eigen::Matrix3d stretch = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    stretch.col(1) *= 1.3;
    const Eigen::RowVector3d shift(0.01, 0.02, -0.03);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        Eigen::RowVector3d moved = points.row(v);
        for (int k = 0; k < 4; ++k) {
            const Eigen::RowVector3d at = mesh.nodes.row(carried.node(v, k));
            moved += carried.weight(v, k) * (at * stretch + shift - at);
        }
        CHECK((moved - points.row(v) * stretch - shift).norm() < 1e-12);
    }
    CHECK_THAT(refusal<MismatchError>([] { carried_points(make_lattice("grid8", 2, 2, 0.1, 0.1), NodeField::Zero(1, 3)); }), Catch::Matchers::Contains("in the plane"));
}
