#include "mesh/disc_rim.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <random>

#include "error.h"
#include "io/atomic_file.h"
#include "mesh/surface_remesh.h"
#include "../refusal.h"
#include "ball.h"

using namespace tissue;

namespace {

/// A box of 100 x 100 x 50 mm in twelve triangles, bottom named; in millimetres.
MshFile box() {
    MshFile mesh;
    mesh.file = "box.msh";
    for (int k = 0; k < 8; ++k) mesh.points.push_back({k & 1 ? 100.0 : 0.0, k & 2 ? 100.0 : 0.0, k & 4 ? 50.0 : 0.0});
    const int faces[12][3] = {{0, 1, 2}, {1, 3, 2}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                              {2, 3, 6}, {3, 7, 6}, {0, 2, 4}, {2, 6, 4}, {1, 3, 5}, {3, 7, 5}};
    long number = 0;
    for (const auto& f : faces) {
        ++number;
        mesh.triangles.push_back({number, {f[0], f[1], f[2]}, number <= 2 ? 1 : 2});
    }
    mesh.triangle_names = {{1, "bottom"}, {2, "rest"}};
    return mesh;
}

/// An ellipsoid of half axes 60, 45 and 30 mm, in metres, fixed below z = -10 mm: an octahedron, its triangles
/// quartered `times` times.
Surface ellipsoid(int times) {
    std::vector<Eigen::Vector3d> p{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<std::array<int, 3>> t{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int k = 0; k < times; ++k) {
        std::map<std::pair<int, int>, int> middle;
        std::vector<std::array<int, 3>> finer;
        const auto between = [&](int a, int b) {
            const auto [there, made] = middle.emplace(std::minmax(a, b), static_cast<int>(p.size()));
            if (made) p.push_back((p[static_cast<std::size_t>(a)] + p[static_cast<std::size_t>(b)]).normalized());
            return there->second;
        };
        for (const auto& [a, b, c] : t) {
            const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
            for (const auto& made : {std::array<int, 3>{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) finer.push_back(made);
        }
        t = finer;
    }
    Surface s;
    s.nodes.resize(static_cast<Eigen::Index>(p.size()), 3);
    for (std::size_t i = 0; i < p.size(); ++i) s.nodes.row(static_cast<Eigen::Index>(i)) << 0.06 * p[i].x(), 0.045 * p[i].y(), 0.03 * p[i].z();
    s.triangles.resize(static_cast<Eigen::Index>(t.size()), 3);
    for (std::size_t k = 0; k < t.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        s.triangles.row(row) << t[k][0], t[k][1], t[k][2];
        s.label.push_back((s.corner(row, 0) + s.corner(row, 1) + s.corner(row, 2)).z() < -0.03 ? Surface::fixed_label : Surface::free_label);
    }
    return s;
}

double area(const Surface& s, int label) {
    double sum = 0;
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
        if (s.label[static_cast<std::size_t>(t)] == label) sum += (s.corner(t, 1) - s.corner(t, 0)).cross(s.corner(t, 2) - s.corner(t, 0)).norm() / 2;
    return sum;
}

double volume(const Surface& s) {
    double six = 0;
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) six += s.corner(t, 0).cross(s.corner(t, 1)).dot(s.corner(t, 2));
    return six / 6;
}

/// Sides between the disc and the rest, as first node -> second node, anticlockwise.
std::map<int, int> rim_of(const Surface& s) {
    std::map<std::pair<int, int>, int> label;
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
        for (int i = 0; i < 3; ++i) label[{s.triangles(t, i), s.triangles(t, (i + 1) % 3)}] = s.label[static_cast<std::size_t>(t)];
    std::map<int, int> next;
    for (const auto& [side, l] : label) {
        REQUIRE(label.count({side.second, side.first}) == 1);  // the surface is closed
        if (l == Surface::disc_label && label[{side.second, side.first}] != Surface::disc_label) CHECK(next.emplace(side).second);
    }
    return next;
}

const DiscRim on_top{{0.043, 0.052, 0.05}, 0.007, 0.003, 0.015};

}  // namespace

TEST_CASE("the disc's rim is one closed line of sides at its radius and no triangle crosses it", "[solid][rim]") {
    const auto check = [](const Surface& whole, const DiscRim& disc, double least) {
        const RimmedSurface made = with_rim(whole, disc);
        const Surface& s = made.surface;
        CHECK(made.least_quality > least);
        const std::map<int, int> next = rim_of(s);
        REQUIRE(next.size() >= 10);
        std::size_t steps = 0;
        int node = next.begin()->first;
        do {
            CHECK((Eigen::Vector3d(s.nodes.row(node)) - made.contact_m).norm() == Approx(disc.radius_m).epsilon(1e-9));
            node = next.at(node);
            ++steps;
        } while (node != next.begin()->first && steps <= next.size());
        CHECK(steps == next.size());
        bool middle = false;
        for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
            for (int i = 0; i < 3; ++i) {
                const double r = (s.corner(t, i) - made.contact_m).norm();
                if (s.label[static_cast<std::size_t>(t)] == Surface::disc_label) CHECK(r <= disc.radius_m * (1 + 1e-9));
                else CHECK(r >= disc.radius_m * (1 - 1e-9));
                middle |= r == 0;
            }
        CHECK(middle);
    };
    check(make_surface(box(), {"bottom"}, 1e-3), on_top, 0.65);  // 0.55 without flips
    check(ellipsoid(5), {{0.02, 0.01, 0.03}, 0.007, 0.003, 0.012}, 0.3);  // the fixed part has a zigzag border
    check(ellipsoid(5), {{0.058, 0, 0.01}, 0.007, 0.002, 0.012}, 0.3);
}

TEST_CASE("a box with a disc's rim keeps its volume and its free and fixed areas", "[solid][rim]") {
    const RimmedSurface made = with_rim(make_surface(box(), {"bottom"}, 1e-3), on_top);
    CHECK(volume(made.surface) == Approx(5e-4).epsilon(1e-9));
    CHECK(area(made.surface, Surface::fixed_label) == Approx(0.01).epsilon(1e-9));
    CHECK(area(made.surface, Surface::free_label) + area(made.surface, Surface::disc_label) == Approx(0.03).epsilon(1e-9));
    const double disc = area(made.surface, Surface::disc_label) / (M_PI * 0.007 * 0.007);
    CHECK(disc < 1);
    CHECK(disc > 0.95);
    CHECK((made.contact_m - on_top.contact_m).norm() < 1e-12);
}

TEST_CASE("the fixed part keeps its border within a flat face", "[solid][rim]") {
    MshFile mesh = box();
    mesh.triangles[2].physical = 3;  // half of the top
    mesh.triangle_names[3] = "half";
    const RimmedSurface made = with_rim(make_surface(mesh, {"half"}, 1e-3), {{0.07, 0.07, 0.05}, 0.007, 0.003, 0.015});
    CHECK(area(made.surface, Surface::fixed_label) == Approx(0.005).epsilon(1e-9));
    CHECK(volume(made.surface) == Approx(5e-4).epsilon(1e-9));
}

TEST_CASE("volume and area of a curved surface converge faster than first order in the side length", "[solid][rim][long]") {
    const Surface whole = ellipsoid(5);
    const double all = area(whole, Surface::free_label) + area(whole, Surface::fixed_label);
    std::vector<double> volumes, areas;
    for (const double h : {0.006, 0.003}) {
        const Surface s = with_rim(whole, {{0, 0, 0.03}, 0.014, h, h}).surface;
        volumes.push_back(volume(s) / volume(whole) - 1);
        areas.push_back((area(s, Surface::free_label) + area(s, Surface::fixed_label) + area(s, Surface::disc_label)) / all - 1);
        CHECK(area(s, Surface::fixed_label) == Approx(area(whole, Surface::fixed_label)).epsilon(0.01));
    }
    CHECK(std::abs(volumes[0]) < 0.01);
    CHECK(std::abs(volumes[1]) < std::abs(volumes[0]) / 2.5);
    CHECK(std::abs(areas[1]) < std::abs(areas[0]) / 2.5);
}

TEST_CASE("sides are at most 1.6 times as long as wanted near the disc and far away", "[solid][rim]") {
    const RimmedSurface made = with_rim(make_surface(box(), {"bottom"}, 1e-3), on_top);
    const SideLength wanted = side_length(on_top, on_top.contact_m);
    double worst = 1;
    for (Eigen::Index t = 0; t < made.surface.triangles.rows(); ++t)
        for (int i = 0; i < 3; ++i) {
            const Eigen::Vector3d a = made.surface.corner(t, i), b = made.surface.corner(t, (i + 1) % 3);
            worst = std::max(worst, (a - b).norm() / wanted.at((a + b) / 2));
        }
    CHECK(worst < 1.6);
    CHECK(made.surface.triangles.rows() > 500);
    CHECK(made.surface.triangles.rows() < 1500);
}

TEST_CASE("a position inserted into a triangle becomes a node and its nearest side gets a midpoint node", "[solid][rim]") {
    SurfaceRemesh mesh(make_surface(box(), {"bottom"}, 1e-3), {{0, 0, 0}, 1, 1, 1});
    const Eigen::Vector3d place(0.02, 0.03, 0.05);
    mesh.insert(place);
    const Surface s = mesh.surface();
    REQUIRE(s.nodes.rows() == 10);
    for (const Eigen::Vector3d& node : {place, Eigen::Vector3d(0, 0.05, 0.05)}) CHECK((s.nodes.rowwise() - node.transpose()).rowwise().norm().minCoeff() < 1e-12);
    CHECK(volume(s) == Approx(5e-4).epsilon(1e-12));
}

TEST_CASE("a contact off the surface moves to its nearest point; far off or on the fixed part it is refused", "[solid][rim]") {
    const Surface whole = make_surface(box(), {"bottom"}, 1e-3);
    DiscRim disc = on_top;
    disc.contact_m.z() = 0.056;
    CHECK((with_rim(whole, disc).contact_m - on_top.contact_m).norm() < 1e-12);
    disc.contact_m.z() = 0.065;
    CHECK(refusal<MismatchError>([&] { with_rim(whole, disc); }).find("is 15 mm off the surface, more than two disc radii") != std::string::npos);
    disc.contact_m = {0.05, 0.05, 0};
    CHECK(refusal<MismatchError>([&] { with_rim(whole, disc); }).find("is on a fixed part") != std::string::npos);
    disc.contact_m = {0, 0.05, 0.005};
    CHECK(refusal<MismatchError>([&] { with_rim(whole, disc); }).find("overlaps a fixed part at") != std::string::npos);
    disc = on_top;
    disc.radius_m = 0;
    CHECK(refusal<MismatchError>([&] { with_rim(whole, disc); }).find("must be positive") != std::string::npos);
    disc = on_top;
    disc.far_m = 0.001;
    CHECK(refusal<MismatchError>([&] { with_rim(whole, disc); }).find("at least the size near it") != std::string::npos);
}

TEST_CASE("a disc may lie on an edge of the shape and the edge is kept", "[solid][rim]") {
    const RimmedSurface made = with_rim(make_surface(box(), {"bottom"}, 1e-3), {{0.0, 0.05, 0.05}, 0.007, 0.003, 0.015});
    CHECK(volume(made.surface) == Approx(5e-4).epsilon(1e-9));
    CHECK(rim_of(made.surface).size() >= 10);
    CHECK(made.least_quality > 0.3);
}

TEST_CASE("a surface that is open or meets itself or has no valid fixed part is refused with the cause", "[solid][rim]") {
    const auto said = [](const MshFile& mesh, const std::vector<std::string>& fixed = {"bottom"}) {
        return refusal<FileError>([&] { make_surface(mesh, fixed, 1e-3); });
    };
    MshFile mesh = box();
    mesh.triangles.pop_back();
    CHECK(said(mesh).find("box.msh: the surface is not closed: it has a border at (0.1") == 0);
    mesh = box();  // two tetrahedra on one edge
    mesh.triangles.clear();
    mesh.tetrahedra = {{1, {0, 1, 2, 4}, 10}, {2, {0, 1, 5, 7}, 10}};
    CHECK(said(mesh).find("the surface touches itself at") != std::string::npos);
    mesh = box();
    for (const MshFile::Element& e : box().triangles) mesh.triangles.push_back({e.number + 12, {e.node[0] + 8, e.node[1] + 8, e.node[2] + 8}, 2});
    for (const MshFile::Point& p : box().points) mesh.points.push_back({p.x + 500, p.y, p.z});
    CHECK(said(mesh).find("more than one part") != std::string::npos);
    CHECK(said(box(), {"top"}) == "box.msh: has no surface 'top' to fix; its surfaces: bottom, rest");
    mesh = box();
    for (int k = 0; k < 12; ++k) {
        mesh.triangles[static_cast<std::size_t>(k)].physical = k + 1;
        mesh.triangle_names[k + 1] = fmt::format("part {:02}", k + 1);
    }
    CHECK(said(mesh, {"top"}).find("its surfaces: part 01, part 02, part 03, part 04, part 05, part 06, part 07, part 08, part 09, part 10, part 11, part 12") != std::string::npos);
    mesh.points.push_back({50, 50, 50});  // divides the diagonal of the top
    mesh.triangles[2] = {3, {4, 5, 8}, 3};
    mesh.triangles.push_back({13, {4, 8, 6}, 13});
    mesh.triangles[3] = {4, {5, 7, 8}, 4};
    mesh.triangles.push_back({14, {8, 7, 6}, 13});
    mesh.triangle_names[13] = "part 13";
    CHECK(said(mesh, {"top"}).find("its surfaces: part 01, part 02, ..., part 13") != std::string::npos);
    CHECK(said(box(), {"bottom", "rest"}).find("all of the surface is fixed") != std::string::npos);
    CHECK(said(box(), {}).find("no part of its surface is fixed") != std::string::npos);
    mesh = box();
    mesh.triangles.clear();
    CHECK(said(mesh).find("has neither tetrahedra nor triangles") != std::string::npos);
}

TEST_CASE("parts of a surface without names are numbered by area; triangles may have any orientation", "[solid][rim]") {
    MshFile mesh = box();
    mesh.triangle_names.clear();
    mesh.points[6].z = mesh.points[7].z = 60;  // the wall at y = 100 is higher
    const Surface walls = make_surface(mesh, {"surface-6"}, 1e-3);
    CHECK(volume(walls) == Approx(5.5e-4));
    CHECK(area(walls, Surface::fixed_label) == Approx(0.005));  // the lowest wall is the smallest
    CHECK(refusal<FileError>([&] { make_surface(mesh, {"surface-7"}, 1e-3); }).find("its surfaces: surface-1, surface-2") != std::string::npos);
}

TEST_CASE("the surface of tetrahedra is their outer faces; a shared triangle belongs to the first fixed group", "[solid][rim]") {
    MshFile mesh;
    mesh.file = "two.msh";
    mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    mesh.tetrahedra = {{1, {0, 1, 2, 3}, 10}, {2, {1, 3, 2, 4}, 10}};
    mesh.triangles = {{3, {0, 1, 2}, 1}};
    mesh.triangle_names = {{1, "bed"}};
    const Surface s = make_surface(mesh, {"bed"}, 1);
    CHECK(s.triangles.rows() == 6);
    CHECK(volume(s) == Approx(1.0 / 6 + 1.0 / 3));
    CHECK(area(s, Surface::fixed_label) == Approx(0.5));

    // a triangle of two groups belongs to the first fixed one, with its bed
    mesh.triangles.push_back({4, {0, 1, 2}, 2});
    mesh.triangle_names[2] = "table";
    const int bed_label = fixed_label_of(1);
    CHECK(area(make_surface(mesh, {"bed", "table"}, 1, {}, {1, 1}), bed_label) == Approx(0.5));
    for (const auto& [held, beds] : {std::pair(std::vector<std::string>{"bed", "below z = 0.2"}, std::vector<int>{1, 0}), std::pair(std::vector<std::string>{"table", "below z = 0.2"}, std::vector<int>{1, 0})}) {
        const Surface parts = make_surface(mesh, held, 1, {}, beds);
        CHECK(area(parts, bed_label) == Approx(0.5));
        CHECK(area(parts, Surface::fixed_label) > 0.1);
    }
    CHECK_THAT(refusal<FileError>([&] { make_surface(mesh, {"table", "bed"}, 1, {}, {1, 2}); }), Catch::Contains("two.msh: other fixed parts include all of 'bed', so its bed has no area"));
    CHECK_THAT(refusal<FileError>([&] { make_surface(mesh, {"bed", "table"}, 1, {}, {1, 2}); }), Catch::Contains("two.msh: other fixed parts include all of 'table', so its bed has no area"));
    mesh.triangles.pop_back();
    mesh.triangle_names.erase(2);
    mesh.triangles[0] = {3, {1, 2, 3}, 1};
    CHECK(refusal<FileError>([&] { make_surface(mesh, {"bed"}, 1); }).find("'bed', which is fixed, has triangles that are not on the surface") != std::string::npos);
}

TEST_CASE("short creases of a segmentation near the disc leave triangles of quality above 0.1", "[solid][rim][long]") {
    for (unsigned seed = 0; seed < 24; ++seed) {
        CAPTURE(seed);
        std::mt19937 draw(seed);
        const auto number = [&] { return static_cast<double>(draw()) / 2147483648.0 - 1; };  // -1 to 1
        MshFile organ = ball_surface(Eigen::Vector3d::Zero(), 40, 5);
        std::vector<std::size_t> near;
        for (std::size_t v = 0; v < organ.points.size(); ++v) {
            const MshFile::Point& p = organ.points[v];
            if (const double away = std::hypot(p.x, p.y, p.z - 40); away > 5 && away < 14) near.push_back(v);
        }
        for (int k = 0; k < 6; ++k) {
            MshFile::Point& p = organ.points[near[draw() % near.size()]];
            const double out = 1 + number() * 1.5 / 40;
            p = {out * p.x + 0.6 * number(), out * p.y + 0.6 * number(), out * p.z + 0.6 * number()};
        }
        CHECK(with_rim(make_surface(organ, {"below z = -0.02"}, 1e-3), {{0, 0, 0.04}, 0.007, 0.003, 0.013}).least_quality > 0.1);
    }
}

TEST_CASE("a surface with a rim is read back from MSH with its volume and fixed area", "[solid][rim]") {
    const std::string file = (std::filesystem::temp_directory_path() / "tissue-rim.msh").string();
    const RimmedSurface made = with_rim(make_surface(box(), {"bottom"}, 1e-3), on_top);
    write_file(file, to_msh(made.surface));
    const Surface read = make_surface(read_msh(file, true), {"fixed"}, 1);
    std::filesystem::remove(file);
    CHECK(volume(read) == Approx(volume(made.surface)).epsilon(1e-12));
    CHECK(area(read, Surface::fixed_label) == Approx(area(made.surface, Surface::fixed_label)).epsilon(1e-12));
}
