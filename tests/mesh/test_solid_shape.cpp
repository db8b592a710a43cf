#include "mesh/solid_shape.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include "dome.h"
#include "error.h"
#include "mesh/free_surface.h"
#include "mesh/mesh_fault.h"
#include "../example.h"
#include "../haptic/haptic_example.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Approx = Catch::Detail::Approx;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

Shape made(const MshFile& file, ShapeNotes* notes = nullptr) { return make_solid_shape(file, {"bed"}, {}, 0.001, notes); }

std::string refused(const MshFile& file, const std::vector<std::string>& fixed = {"bed"}, const std::vector<std::string>& regions = {}) {
    const std::string words = refusal<FileError>([&] { make_solid_shape(file, fixed, regions, 0.001); });
    CHECK_THAT(words, StartsWith("dome.msh: "));
    CHECK(words.find('\n') == std::string::npos);
    return words;
}

}  // namespace

TEST_CASE("make_solid_shape converts units, turns tetrahedra to positive volume and drops unused points", "[solid_shape]") {
    MshFile file = dome_file();
    for (std::size_t t = 0; t < file.tetrahedra.size(); t += 3) std::swap(file.tetrahedra[t].node[0], file.tetrahedra[t].node[1]);
    file.points.push_back({1, 2, 3});  // unused
    ShapeNotes notes;
    for (MshFile::Point& p : file.points) p.x *= 1.2;
    const Shape shape = made(file, &notes);
    CHECK(notes.turned == static_cast<int>((file.tetrahedra.size() + 2) / 3));
    CHECK(notes.dropped == 1);
    CHECK(shape.is_solid());
    CHECK(shape.nodes.col(0).maxCoeff() == Approx(0.06).epsilon(tolerance::rounding));
    CHECK(shape.nodes(0, 0) < -0.05);
    CHECK(shape.nodes(shape.nodes.rows() - 1, 0) > 0.05);
    const SpringMesh mesh = edge_mesh(shape);
    CHECK_FALSE(mesh_fault(mesh));
    CHECK(mesh.node_measure.sum() == Approx(edge_mesh(dome()).node_measure.sum() * 1.2).epsilon(1e-9));
}

TEST_CASE("nodes of a solid shape are numbered along its length for any orientation", "[solid_shape]") {
    Draw draw(12);
    for (int k = 0; k < 12; ++k) {
        const Eigen::Matrix3d turn = Eigen::Quaterniond(draw(-1, 1), draw(-1, 1), draw(-1, 1), draw(-1, 1)).normalized().toRotationMatrix();
        MshFile file = dome_file();
        for (MshFile::Point& p : file.points) {
            const Eigen::Vector3d x = turn * Eigen::Vector3d(1.7 * p.x, p.y, p.z);
            p = {x.x(), x.y(), x.z()};
        }
        const Shape shape = made(file);
        const Eigen::RowVector3d along = turn.col(0).transpose() * (turn(0, 0) > 0 ? 1 : -1);
        INFO("rotated by " << turn);
        const Eigen::VectorXd place = shape.nodes * along.transpose();
        // the principal axis of the points is not exactly x
        CHECK((place.tail(place.size() - 1) - place.head(place.size() - 1)).minCoeff() > -0.002);
        CHECK(place[place.size() - 1] - place[0] > 0.16);
    }
}

TEST_CASE("springs of a solid shape are the edges of its tetrahedra; their measures sum to six volumes", "[solid_shape]") {
    const SpringMesh mesh = edge_mesh(dome());
    const double volume = mesh.node_measure.sum();
    CHECK(volume > 2.0 / 3 * 3.1415 * 0.05 * 0.05 * 0.05);
    CHECK(volume < 0.1 * 0.1 * 0.05);
    CHECK(mesh.incident_measure.sum() == Approx(6 * volume).epsilon(tolerance::rounding));
    // Euler characteristic of a ball: corners - edges + faces - tetrahedra = 1
    const Eigen::Index faces = (4 * mesh.simplices.rows() + mesh.facets.rows()) / 2;
    CHECK(mesh.node_count() - mesh.spring_count() + faces - mesh.simplices.rows() == 1);
    for (int s = 1; s < mesh.spring_count(); ++s) CHECK(mesh.springs(s, 0) < mesh.springs(s, 1));
    CHECK(mesh.fixed.size() == 121);
}

TEST_CASE("a fixed facet anywhere on a solid shape is recovered from its spring mesh", "[solid_shape]") {
    Shape shape = dome(6);
    const Cells facets = edge_mesh(shape).facets;
    for (const Eigen::Index f : {Eigen::Index{0}, facets.rows() / 2, facets.rows() - 1}) {
        std::array<int, 3> held{facets(f, 0), facets(f, 1), facets(f, 2)};
        shape.fixed_facets = {held};
        const Shape back = shape_of(edge_mesh(shape));
        REQUIRE(back.fixed_facets.size() == 1);
        std::array<int, 3> found{back.fixed_facets[0][0], back.fixed_facets[0][1], back.fixed_facets[0][2]};
        std::sort(held.begin(), held.end());
        std::sort(found.begin(), found.end());
        CHECK(found == held);
    }
}

TEST_CASE("a solid shape is read back from MSH bit by bit; an empty mesh is refused", "[solid_shape]") {
    const TemporaryFolder folder;
    Shape shape = made(dome_file());
    shape.region[5] = 1;
    const std::string text = to_msh(shape, {"stone"});
    const Shape back = read_solid_shape(folder.file("mesh.msh", text));
    CHECK(back.nodes == shape.nodes);
    CHECK(back.simplices == shape.simplices);
    CHECK(back.region == shape.region);
    CHECK(back.fixed_facets == shape.fixed_facets);
    CHECK_THAT(text, Contains("2 1 \"fixed\"") && Contains("2 2 \"free\"") && Contains("3 10 \"tissue\"") && Contains("3 11 \"stone\""));
    CHECK_THAT(refusal<FileError>([&] { read_solid_shape(folder.file("plane.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n0\n$EndNodes\n$Elements\n0\n$EndElements\n")); }),
               Contains("is not a mesh in space"));
}

TEST_CASE("a solid shape's regions are its named volumes", "[solid_shape]") {
    MshFile file = dome_file();
    file.tetrahedron_names[8] = "stone";
    for (std::size_t t = 0; t < 12; ++t) file.tetrahedra[t].physical = 8;
    const Shape shape = make_solid_shape(file, {"bed"}, {"stone"}, 0.001);
    CHECK(std::count(shape.region.begin(), shape.region.end(), 1) == 12);
    CHECK(std::count(shape.region.begin(), shape.region.end(), 0) == static_cast<long>(file.tetrahedra.size()) - 12);
    CHECK_THAT(refused(file, {"bed"}, {"pebble"}), Contains("has no physical volume 'pebble'; it has: flesh, stone"));
    MshFile twice = file;
    twice.tetrahedra.push_back(twice.tetrahedra[0]);
    twice.tetrahedra.back().physical = 7;
    CHECK(make_solid_shape(twice, {"bed"}, {"stone"}, 0.001).simplices.rows() == shape.simplices.rows());
    CHECK_THAT(refused(twice, {"bed"}, {"stone", "flesh"}), Contains("two of the study's regions"));
}

TEST_CASE("an invalid mesh of a solid shape is refused with file and cause", "[solid_shape]") {
    const MshFile good = dome_file();
    MshFile file = good;
    file.tetrahedra.clear();
    CHECK_THAT(refused(file), Contains("has no tetrahedra"));
    CHECK_THAT(refused(good, {"chair"}), Contains("has no physical surface 'chair'; it has: bed"));

    file = good;  // a node moved onto another one
    const MshFile::Tetrahedron& first = file.tetrahedra[0];
    file.points[static_cast<std::size_t>(first.node[1])] = file.points[static_cast<std::size_t>(first.node[0])];
    CHECK_THAT(refused(file), Contains("is a sliver") && Contains(" m "));
    // volume over the cube of the longest edge
    for (const auto& [thin, is_sliver] : {std::pair{5e-4, false}, std::pair{5e-5, true}}) {
        MshFile flat = good;
        flat.tetrahedra.clear();
        flat.triangles.clear();
        flat.points = {{0, 0, 0}, {100, 0, 0}, {0, 100, 0}, {30, 30, thin * 1200 * std::sqrt(2)}};
        flat.tetrahedra.push_back({1, {0, 1, 2, 3}, good.tetrahedra[0].physical});
        flat.triangles.push_back({2, {0, 1, 2}, good.triangles[0].physical});
        std::string words;
        try {
            make_solid_shape(flat, {"bed"}, {}, 0.001);
        } catch (const FileError& e) {
            words = e.what();
        }
        INFO(words);
        CHECK((words.find("is a sliver") != std::string::npos) == is_sliver);
    }

    file = good;  // an inner node moved through the opposite faces
    file.points[static_cast<std::size_t>(good.tetrahedra[6 * 255].node[3])].x += 17;
    CHECK_THAT(refused(file), Contains("overlap at ("));

    file = good;
    // without a box at the bed: no cavity, but a part of the bed is not on the surface
    file.tetrahedra.erase(file.tetrahedra.begin() + 6 * 5, file.tetrahedra.begin() + 6 * 6);
    CHECK_THAT(refused(file), Contains("fixed surface"));

    file = good;  // without an inner box
    const std::size_t inside = 6 * (2 * 100 + 5 * 10 + 5);
    file.tetrahedra.erase(file.tetrahedra.begin() + inside, file.tetrahedra.begin() + inside + 6);
    CHECK_THAT(refused(file), Contains("a cavity or a second part at ("));

    file = good;  // without a column of boxes from bottom to top
    for (int z = 4; z >= 0; --z) {
        const std::size_t box = 6 * static_cast<std::size_t>(z * 100 + 5 * 10 + 5);
        file.tetrahedra.erase(file.tetrahedra.begin() + static_cast<long>(box), file.tetrahedra.begin() + static_cast<long>(box) + 6);
    }
    CHECK_THAT(refused(file), Contains("a hole through it"));

    file = good;  // of four neighbouring boxes at the bed two remain, which share only an edge
    for (int box : {11, 0})
        file.tetrahedra.erase(file.tetrahedra.begin() + 6 * box, file.tetrahedra.begin() + 6 * box + 6);
    CHECK_THAT(refused(file), Contains("touches itself between ("));

    file = good;
    file.triangles.clear();
    CHECK_THAT(refused(file), Contains("no part of the surface is in the fixed surfaces bed"));
    file = good;
    file.triangles.push_back({1, {good.tetrahedra[inside].node[0], good.tetrahedra[inside].node[1], good.tetrahedra[inside].node[2]}, 5});
    CHECK_THAT(refused(file), Contains("the fixed surface at (") && Contains("is not on the tissue's surface"));
    file = good;
    const SpringMesh mesh = edge_mesh(dome());
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) file.triangles.push_back({1, {mesh.facets(f, 0), mesh.facets(f, 1), mesh.facets(f, 2)}, 5});
    CHECK_THAT(refused(file), Contains("leave no part of the surface free"));
}

TEST_CASE("tetrahedra are read in space and refused in the plane", "[solid_shape]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("mesh.msh", to_msh(dome(4), {}));
    CHECK(read_msh(file, true).tetrahedra.size() == static_cast<std::size_t>(6 * 32));
    CHECK_THAT(refusal<FileError>([&] { read_msh(file); }), Contains("is a tetrahedron; a tissue needs straight triangles, in the plane"));
}

TEST_CASE("a dome's clearance is its distance from the bed's edge; thickness ends at the opposite surface", "[solid_shape]") {
    const FreeSurface surface(edge_mesh(dome()));
    CHECK(surface.clearance_m(Eigen::Vector3d(0, 0, 0.05)) == Approx(std::sqrt(0.005)).epsilon(0.1));
    CHECK(surface.clearance_m(Eigen::Vector3d(0.05, 0, 0.013)) == Approx(0.013).epsilon(0.02));
    const std::vector<Point> points = surface.points(4);
    CHECK(points.size() == static_cast<std::size_t>(16 * surface.facets().rows()));
    std::set<std::array<double, 3>> distinct;
    for (const Point& p : points) {
        distinct.insert({p[0], p[1], p[2]});
        CHECK(surface.nearest(p).distance_m < 1e-12);
    }
    CHECK(distinct.size() == points.size());
    CHECK(surface.nearest(Eigen::Vector3d(0, 0, 0.06)).inward[2] < -0.99);
    const Eigen::Vector3d top(0, 0, 0.05), right(0.05, 0, 0.013), down(0, 0, -1), left(-1, 0, 0);
    const Point start = surface.nearest(top).point_m, side = surface.nearest(right).point_m;
    CHECK(surface.thickness_m(start, down) == Approx(start[2]).epsilon(1e-9));                        // to the bed, which is fixed
    CHECK(surface.thickness_m(Eigen::Vector3d(start - 1e-4 * down), down) == Approx(start[2] + 1e-4).epsilon(1e-9));  // not to the point where the ray enters
    CHECK(surface.thickness_m(side, left) == Approx(2 * side[0]).epsilon(0.02));                      // to the other side, which is free
    CHECK(surface.thickness_m(start, Eigen::Vector3d(-down)) == std::numeric_limits<double>::infinity());
}
