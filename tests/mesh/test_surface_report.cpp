#include <catch2/catch.hpp>
#include <algorithm>
#include <cmath>

#include "error.h"
#include "mesh/open_faces.h"
#include "mesh/solid_block.h"
#include "mesh/surface.h"
#include "mesh/surface_repair.h"
#include "mesh/surface_report.h"
#include "surface_file/surface_file.h"
#include "../refusal.h"
#include "../example.h"

namespace tissue {
namespace {

using Catch::Matchers::Contains;
using Kind = SurfaceFault::Kind;

/// Adds a box of 80 x 60 x 50, scaled by `factor`, with its lowest corner at (x, y, z). Before scaling its faces are
/// squares of 10 with two triangles each.
void add_box(MshFile& mesh, double x, double y, double z, double factor = 1) {
    const Shape solid = solid_block(Lattice{{8, 6, 5}, {80, 60, 50}});
    const Cells facets = open_faces(solid.simplices);
    const int first = static_cast<int>(mesh.points.size());
    for (Eigen::Index n = 0; n < solid.nodes.rows(); ++n) mesh.points.push_back({x + factor * solid.nodes(n, 0), y + factor * solid.nodes(n, 1), z + factor * solid.nodes(n, 2)});
    for (Eigen::Index f = 0; f < facets.rows(); ++f)
        mesh.triangles.push_back({f + 1, {first + facets(f, 0), first + facets(f, 1), first + facets(f, 2)}, 0});
}

MshFile box() {
    MshFile mesh;
    mesh.file = "box.stl";
    add_box(mesh, 0, 0, 0);
    return mesh;
}

const SurfaceFault* fault(const SurfaceReport& report, Kind kind) {
    for (const SurfaceFault& f : report.faults)
        if (f.kind == kind) return &f;
    return nullptr;
}

}  // namespace

TEST_CASE("a closed surface is reported with its sizes and without faults", "[surface_report]") {
    const SurfaceReport r = report_on(box());
    CHECK(r.faults.empty());
    CHECK(r.points == 9 * 7 * 6 - 7 * 5 * 4);
    CHECK(r.triangles == 2 * 2 * (48 + 40 + 30));
    CHECK(r.volume == Approx(240'000));
    CHECK(r.area == Approx(2 * (4800 + 4000 + 3000)));
    CHECK(r.shortest == Approx(10));
    CHECK(r.mean == Approx(10 * (2 + std::sqrt(2.0)) / 3));
    CHECK(r.slivers == 0);
    CHECK((r.high - r.low - Eigen::Vector3d(80, 60, 50)).norm() < 1e-12);
    MshFile twice = box();  // every triangle in two groups
    twice.triangles.insert(twice.triangles.end(), twice.triangles.begin(), twice.triangles.end());
    CHECK(report_on(twice).faults.empty());
    CHECK_THAT(refusal<FileError>([] { report_on(MshFile{}); }), Contains("has no triangles"));
}

TEST_CASE("holes, crowded edges, pinched points, parts, crossings and flat triangles are counted and located", "[surface_report]") {
    // a hole of one triangle, then also one of two triangles far away
    MshFile mesh = box();
    const auto middle = [&](std::size_t t) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int n : mesh.triangles[t].node) sum += Eigen::Vector3d(mesh.points[static_cast<std::size_t>(n)].x, mesh.points[static_cast<std::size_t>(n)].y, mesh.points[static_cast<std::size_t>(n)].z) / 3;
        return sum;
    };
    const Eigen::Vector3d gone = middle(7);
    mesh.triangles.erase(mesh.triangles.begin() + 7);
    SurfaceReport r = report_on(mesh);
    REQUIRE(r.faults.size() == 1);
    REQUIRE(fault(r, Kind::holes));
    CHECK(fault(r, Kind::holes)->count == 1);
    CHECK(fault(r, Kind::holes)->largest == Approx(10 * (2 + std::sqrt(2.0))));
    CHECK((fault(r, Kind::holes)->first.at(0) - gone).norm() < 1e-9);
    CHECK(r.volume == 0);
    CHECK_THAT(fault_text(r.faults[0], " mm", 2), Contains("1 hole, perimeter 68.3 mm; at ("));
    mesh.triangles.resize(mesh.triangles.size() - 2);
    r = report_on(mesh);
    CHECK(fault(r, Kind::holes)->count == 2);
    CHECK_THAT(fault_text(r.faults[0], "", 1), Contains("2 holes, longest perimeter 40"));

    mesh = box();
    std::swap(mesh.triangles[3].node[0], mesh.triangles[3].node[1]);
    r = report_on(mesh);
    CHECK(r.faults.empty());  // filling turns it
    CHECK(r.turned == 1);
    CHECK(r.volume == Approx(240'000));
    CHECK_NOTHROW(make_surface(mesh, {"surface-1"}, 0.001));
    for (auto& e : mesh.triangles) std::swap(e.node[0], e.node[1]);
    CHECK(report_on(mesh).turned == mesh.triangles.size() - 1);
    CHECK(report_on(mesh).volume == Approx(240'000));

    mesh = box();
    mesh.points.push_back({40, 30, 90});
    mesh.triangles.push_back({1, {mesh.triangles[0].node[0], mesh.triangles[0].node[1], static_cast<int>(mesh.points.size()) - 1}, 0});
    r = report_on(mesh);
    CHECK(fault(r, Kind::crowded)->count == 1);
    CHECK(fault(r, Kind::holes)->count == 1);
    CHECK(r.volume == 0);

    // two boxes that share a point: no handle
    mesh = box();
    add_box(mesh, 80, 60, 50);
    const auto same = [&](const MshFile::Point& p) { return p.x == 80 && p.y == 60 && p.z == 50; };
    const auto first = static_cast<int>(std::find_if(mesh.points.begin(), mesh.points.end(), same) - mesh.points.begin());
    for (auto& e : mesh.triangles)
        for (int& n : e.node)
            if (same(mesh.points[static_cast<std::size_t>(n)])) n = first;
    r = report_on(mesh);
    CHECK_FALSE(fault(r, Kind::handles));
    REQUIRE(fault(r, Kind::pinched));
    CHECK(fault(r, Kind::pinched)->count == 1);
    CHECK((fault(r, Kind::pinched)->first.at(0) - Eigen::Vector3d(80, 60, 50)).norm() < 1e-12);

    mesh = box();
    add_box(mesh, 200, 0, 0, 0.1);
    r = report_on(mesh);
    REQUIRE(r.faults.size() == 1);
    CHECK(fault(r, Kind::parts)->count == 1);
    CHECK(fault(r, Kind::parts)->largest == Approx(8));
    CHECK((fault(r, Kind::parts)->first.at(0) - Eigen::Vector3d(204, 3, 2.5)).norm() < 1e-9);
    CHECK(r.volume == Approx(240'000));

    // a second box of the same size with a corner inside the first one
    mesh = box();
    add_box(mesh, 45, 35, 25);
    r = report_on(mesh);
    CHECK(fault(r, Kind::parts)->count == 1);
    REQUIRE(fault(r, Kind::crossings));
    const std::size_t crossing = fault(r, Kind::crossings)->count;
    CHECK(crossing > 40);
    CHECK(crossing < 200);
    for (const Eigen::Vector3d& at : fault(r, Kind::crossings)->first) {
        CHECK((at - Eigen::Vector3d(40, 30, 20)).minCoeff() > -1e-9);
        CHECK((at - Eigen::Vector3d(85, 65, 55)).maxCoeff() < 1e-9);
    }

    // a point of the top is moved through the bottom: its triangles cross those of the bottom
    mesh = box();
    for (MshFile::Point& p : mesh.points)
        if (p.x == 40 && p.y == 30 && p.z == 50) p = {41, 32, -20};
    r = report_on(mesh);
    REQUIRE(r.faults.size() == 1);
    CHECK(fault(r, Kind::crossings)->count > 5);

    // a point of the top is moved past its neighbour: triangles with a common side overlap
    mesh = box();
    for (MshFile::Point& p : mesh.points)
        if (p.x == 40 && p.y == 30 && p.z == 50) p = {58, 30, 50};
    CHECK(fault(report_on(mesh), Kind::crossings));

    mesh = box();
    for (MshFile::Point& p : mesh.points)
        if (p.x == 40 && p.y == 30 && p.z == 50) p = {30, 30, 50};  // onto the next point
    CHECK(fault(report_on(mesh), Kind::flat)->count >= 1);
    for (const double angle : {1.2, 0.8}) {  // degrees, at both ends of the longest edge
        MshFile flat;
        flat.points = {{0, 0, 0}, {20, 0, 0}, {10, 10 * std::tan(angle * 3.14159265358979 / 180), 0}};
        flat.triangles = {{1, {0, 1, 2}, 0}};
        CHECK(report_on(flat).slivers == (angle < 1 ? 1u : 0u));
    }
}

TEST_CASE("a hole through a surface is detected by its Euler characteristic", "[surface_report]") {
    // a block of 3 x 3 x 1 cubes without its middle one
    MshFile mesh;
    mesh.file = "frame.stl";
    for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i) mesh.points.push_back({10. * i, 10. * j, 10. * k});
    const auto point = [](int i, int j, int k) { return i + 4 * (j + 4 * k); };
    const auto quad = [&](int a, int b, int c, int d) {
        mesh.triangles.push_back({1, {a, b, c}, 0});
        mesh.triangles.push_back({1, {a, c, d}, 0});
    };
    const auto there = [](int i, int j) { return i >= 0 && j >= 0 && i < 3 && j < 3 && !(i == 1 && j == 1); };
    for (int i = -1; i < 4; ++i)
        for (int j = -1; j < 4; ++j) {
            if (!there(i, j)) continue;
            quad(point(i, j, 0), point(i, j + 1, 0), point(i + 1, j + 1, 0), point(i + 1, j, 0));
            quad(point(i, j, 1), point(i + 1, j, 1), point(i + 1, j + 1, 1), point(i, j + 1, 1));
            if (!there(i - 1, j)) quad(point(i, j, 0), point(i, j, 1), point(i, j + 1, 1), point(i, j + 1, 0));
            if (!there(i + 1, j)) quad(point(i + 1, j, 0), point(i + 1, j + 1, 0), point(i + 1, j + 1, 1), point(i + 1, j, 1));
            if (!there(i, j - 1)) quad(point(i, j, 0), point(i + 1, j, 0), point(i + 1, j, 1), point(i, j, 1));
            if (!there(i, j + 1)) quad(point(i, j + 1, 0), point(i, j + 1, 1), point(i + 1, j + 1, 1), point(i + 1, j + 1, 0));
        }
    const SurfaceReport r = report_on(mesh);
    REQUIRE(r.faults.size() == 1);
    CHECK(fault(r, Kind::handles)->count == 1);
    CHECK_THAT(refusal<FileError>([&] { make_surface(mesh, {"surface-1"}, 1); }), Contains("holes through it"));
    // a hole of width 10 is closed if `closes` is larger
    for (const double closes : {7.0, 13.0}) {
        const RepairedSurface made = repaired(mesh, {closes, 0.1});
        const SurfaceReport after = report_on(made.mesh);
        CHECK((fault(after, Kind::handles) != nullptr) == (closes < 10));
        CHECK((after.volume > 8600) == (closes > 10));  // 8000 without the volume of the hole
        if (closes > 10) CHECK(made.distances.most > 1);  // over the hole, also where the new surface has no corner
    }
}

TEST_CASE("make_surface accepts a surface reported without faults and a repaired surface", "[surface_report]") {
    CHECK_NOTHROW(make_surface(box(), {"surface-1"}, 0.001));
    // all at once: a hole, a crossing box, a turned triangle, one without area, and a small part far away
    MshFile mesh = box();
    add_box(mesh, 45, 35, 25);
    mesh.triangles.erase(mesh.triangles.begin() + 7);
    std::swap(mesh.triangles[30].node[0], mesh.triangles[30].node[1]);
    mesh.triangles.push_back({1, {0, 0, 1}, 0});
    add_box(mesh, 300, 0, 0, 0.05);
    CHECK(report_on(mesh).faults.size() >= 4);
    const RepairedSurface made = repaired(mesh, {30, 1});
    const SurfaceReport r = report_on(made.mesh);
    CHECK(r.faults.empty());
    CHECK_NOTHROW(make_surface(made.mesh, {"below z = 0.02"}, 0.001));
    // volume of the union of both boxes, and of the layer of thickness 1 around it
    const double both = 2 * 240'000. - 35 * 25 * 25, shell = r.area * 1;
    CHECK(r.volume > both + shell);
    CHECK(r.volume < 1.06 * (both + shell));  // a ball of radius 15 does not fit into the concave edges
    CHECK(made.distances.left_out == 1);
    CHECK(made.distances.median == Approx(1).epsilon(0.05));
    CHECK(made.distances.most > 1.5);  // over the hole and in the concave edges between the boxes
    CHECK(made.distances.most < 12);
    CHECK(made.distances.given_median == Approx(1).epsilon(0.05));
    CHECK(made.distances.given_most > 150);  // the small part
    CHECK((made.distances.given_at - Eigen::Vector3d(304, 3, 2.5)).norm() < 4);
    for (const SurfaceRepair& wrong : {SurfaceRepair{0.1, 1}, {30, 0}, {30, NAN}, {INFINITY, 1}})
        CHECK_THAT(refusal<MismatchError>([&] { repaired(mesh, wrong); }), Contains("box.stl: has the size 304 in its file's unit"));
    const TemporaryFolder folder;
    const MshFile read = read_surface_file(folder.file("made.stl", to_stl(made.mesh)));
    CHECK(read.triangles.size() == made.mesh.triangles.size());
    CHECK(report_on(read).faults.empty());
    CHECK(report_on(read).volume == Approx(r.volume).epsilon(1e-5));
}

}  // namespace tissue
