#include "mesh/solid_block.h"
#include "mesh/carried_surface.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "../refusal.h"
#include "dome.h"
#include "error.h"
#include "mesh/embedded_lattice.h"
#include "mesh/surface.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const SpringMesh& mesh() {
    static const SpringMesh m = embedded_lattice(dome(8), 0.011);
    return m;
}

/// The mesh's boundary in millimetres, each facet divided into four and offset outwards by out_mm.
MshFile finer(double out_mm = 0) {
    MshFile file;
    file.file = "organ.stl";
    const auto at = [&](int node) -> Eigen::RowVector3d { return 1e3 * mesh().nodes.row(node); };
    for (const auto& facet : mesh().facets.rowwise()) {
        const Eigen::RowVector3d a = at(facet[0]), b = at(facet[1]), c = at(facet[2]), normal = (b - a).cross(c - a).normalized();
        const auto first = static_cast<int>(file.points.size());
        for (const Eigen::RowVector3d& corner : {a, b, c, Eigen::RowVector3d((a + b) / 2), Eigen::RowVector3d((b + c) / 2), Eigen::RowVector3d((c + a) / 2)}) {
            const Eigen::RowVector3d p = corner + out_mm * normal;
            file.points.push_back({p[0], p[1], p[2]});
        }
        for (const auto& [i, j, k] : {std::array{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}) file.triangles.push_back({0, {first + i, first + j, first + k}, 0});
    }
    return file;
}

/// A displacement field that differs from node to node.
NodeField waves() {
    return (37 * mesh().nodes.array()).sin() * 1e-3;
}

}  // namespace

TEST_CASE("a finer surface follows the facets that carry it and keeps its offset", "[carried]") {
    const NodeField u = waves();
    const CarriedSurface on = carried_surface(mesh(), finer(), 1e-3);
    REQUIRE(on.facets.rows() == 4 * mesh().facets.rows());
    CHECK((on.moved(0 * u) - on.vertices).cwiseAbs().maxCoeff() == 0);
    const NodeField moved = on.moved(u) - on.vertices;
    // corners move as nodes, midpoints as the mean of two nodes
    for (Eigen::Index f = 0; f < mesh().facets.rows(); ++f) {
        const auto node = [&](int k) { return u.row(mesh().facets(f, k % 3)); };
        for (int k = 0; k < 3; ++k) {
            CHECK((moved.row(6 * f + k) - node(k)).norm() < 1e-12);
            CHECK((moved.row(6 * f + 3 + k) - (node(k) + node(k + 1)) / 2).norm() < 1e-12);
        }
    }
    const CarriedSurface off = carried_surface(mesh(), finer(0.5), 1e-3);
    CHECK((off.moved(0 * u) - off.vertices).cwiseAbs().maxCoeff() == 0);
    for (Eigen::Index f = 0; f < mesh().facets.rows(); ++f) {
        const Eigen::RowVector3d middle = (moved.row(6 * f + 3) + moved.row(6 * f + 4) + moved.row(6 * f + 5)) / 3;
        const NodeField now = off.moved(u) - off.vertices;
        CHECK(((now.row(6 * f + 3) + now.row(6 * f + 4) + now.row(6 * f + 5)) / 3 - middle).norm() < 2e-4);  // near an edge the next facet may carry it
    }
}

TEST_CASE("vertices of a thin sheet are carried by the side of equal orientation", "[carried]") {
    // vertices so deep that the opposite side of the plate is nearer
    const SpringMesh plate = embedded_lattice(solid_block(Lattice{{6, 6, 1}, {0.06, 0.06, 0.01}}), 0.01);
    MshFile top;
    top.file = "top.stl";
    top.points = {{0.02, 0.02, 0.004}, {0.04, 0.02, 0.004}, {0.02, 0.04, 0.004}};  // nearer to the bottom, normal up
    top.triangles = {{0, {0, 1, 2}, 0}};
    const CarriedSurface carried = carried_surface(plate, top, 1);
    for (Eigen::Index v = 0; v < 3; ++v)
        for (int k = 0; k < 3; ++k) CHECK(plate.nodes(carried.node(v, k), 2) == 0.01);
}

TEST_CASE("a carried surface with inward normals is turned and its unused points are dropped", "[carried]") {
    MshFile inward = finer();
    inward.points.insert(inward.points.begin(), {0, 0, 0});  // in the middle of the bed
    for (MshFile::Element& e : inward.triangles) e = {0, {e.node[0] + 1, e.node[2] + 1, e.node[1] + 1}, 0};
    const CarriedSurface turned = carried_surface(mesh(), inward, 1e-3), given = carried_surface(mesh(), finer(), 1e-3);
    REQUIRE(turned.vertices.rows() == given.vertices.rows());
    CHECK(enclosed_by({turned.vertices, turned.facets, {}}).volume_m3 == Approx(enclosed_by({given.vertices, given.facets, {}}).volume_m3).epsilon(1e-9));
    CHECK(turned.moved(waves()).colwise().sum().isApprox(given.moved(waves()).colwise().sum(), 1e-9));
}

TEST_CASE("a mesh's own surface is its boundary", "[carried]") {
    const NodeField u = waves();
    const CarriedSurface own = own_surface(mesh());
    REQUIRE(own.facets.rows() == mesh().facets.rows());
    const NodeField moved = own.moved(u);
    for (Eigen::Index f = 0; f < own.facets.rows(); ++f)
        for (int k = 0; k < 3; ++k) CHECK(moved.row(own.facets(f, k)) == mesh().nodes.row(mesh().facets(f, k)) + u.row(mesh().facets(f, k)));
}

TEST_CASE("a carried surface in another unit or without triangles is refused and so is a mesh in the plane", "[carried]") {
    CHECK_THAT(refusal<MismatchError>([] { carried_surface(mesh(), finer(), 1); }), Contains("organ.stl: is up to ") && Contains("is its unit not 1 m?"));
    CHECK_THAT(refusal<MismatchError>([] { carried_surface(mesh(), MshFile{"empty.msh", {}, {}, {}, {}, {}, {}, {}}, 1); }), Contains("empty.msh: has no triangles"));
    CHECK_THAT(refusal<MismatchError>([] { carried_surface(make_lattice("grid8", 2, 2, 0.1, 0.1), finer(), 1e-3); }), Contains("in the plane"));
    CHECK_THAT(refusal<MismatchError>([] { own_surface(make_lattice("grid8", 2, 2, 0.1, 0.1)); }), Contains("in the plane"));
}
