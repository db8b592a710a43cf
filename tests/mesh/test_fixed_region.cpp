// Regions of space in which a solid's surface is fixed.
#include "mesh/fixed_region.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "../refusal.h"
#include "error.h"
#include "mesh/disc_rim.h"
#include "mesh/open_faces.h"
#include "mesh/solid_block.h"
#include "mesh/solid_shape.h"
#include "mesh/surface.h"
#include "mesh/surface_remesh.h"
#include "dome.h"

using namespace tissue;
using Approx = Catch::Detail::Approx;
using Catch::Matchers::Contains;

namespace {

/// The surface of a dome, as a file of triangles without names, in millimetres.
MshFile bare_dome(int along) {
    const Shape shape = dome(along);
    const Cells facets = open_faces(shape.simplices);
    MshFile mesh;
    mesh.file = "dome.stl";
    for (Eigen::Index n = 0; n < shape.nodes.rows(); ++n) mesh.points.push_back({1e3 * shape.nodes(n, 0), 1e3 * shape.nodes(n, 1), 1e3 * shape.nodes(n, 2)});
    for (Eigen::Index f = 0; f < facets.rows(); ++f) mesh.triangles.push_back({f + 1, {facets(f, 0), facets(f, 1), facets(f, 2)}, 0});
    return mesh;
}

struct Parts {
    double held_m2 = 0, free_m2 = 0, six_volumes_m3 = 0;
};

Parts parts_of(const Surface& s) {
    Parts parts;
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
        const Eigen::Vector3d a = s.corner(t, 0), b = s.corner(t, 1), c = s.corner(t, 2);
        const double area = (b - a).cross(c - a).norm() / 2;
        (s.label[static_cast<std::size_t>(t)] == Surface::fixed_label ? parts.held_m2 : parts.free_m2) += area;
        parts.six_volumes_m3 += a.cross(b).dot(c);
    }
    return parts;
}

/// Area of the triangles at z = 0 [m^2].
double bed_m2(const MshFile& mesh) {
    double sum = 0;
    for (const MshFile::Element& e : mesh.triangles) {
        const auto at = [&](int i) {
            const MshFile::Point& p = mesh.points[static_cast<std::size_t>(e.node[i])];
            return Eigen::Vector3d(1e-3 * p.x, 1e-3 * p.y, 1e-3 * p.z);
        };
        if (at(0).z() == 0 && at(1).z() == 0 && at(2).z() == 0) sum += (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
    }
    return sum;
}

}  // namespace

TEST_CASE("a fixed region is parsed from its text and from its word; malformed texts are refused", "[solid_shape]") {
    const Eigen::Vector3d at(0.01, 0.02, 0.03);
    for (const auto& [text, word, out_m] : {std::tuple("below z = 0.012", "below_z_0.012", 0.018), {"above x = -3e-2", "above_x_-3e-2", -0.04}, {"above x=0.5", "above_x_0.5", 0.49}, {"below\tz 1", "below_z_1", -0.97},
                                            {"ball 0.01 0.02 0.01 radius 0.015", "ball_0.01_0.02_0.01_radius_0.015", 0.005}, {"box 0 0 0 to 0.1 0.05 0.01", "box_0_0_0_to_0.1_0.05_0.01", 0.02},
                                            {"box 0 0 0 to 0.1 0.1 0.1", "box_0_0_0_to_0.1_0.1_0.1", -0.01}}) {
        const auto region = FixedRegion::of(text);
        REQUIRE(region);
        CHECK(region->word() == word);
        CHECK(region->outside_m(at) == Approx(out_m).margin(1e-15));
        const auto again = FixedRegion::of(region->word());
        REQUIRE(again);
        CHECK(again->word() == word);
        CHECK(again->outside_m(at) == region->outside_m(at));
    }
    CHECK(FixedRegion::of("above x=+0.5")->outside_m(at) == Approx(0.49));
    CHECK(FixedRegion::of("below_z_0.012")->text() == "below z = 0.012");
    for (const char* name : {"bed", "surface-1", "below", "belowdeck", "underside", "box", "box_bottom", "ball_joint", "above_all"}) CHECK_FALSE(FixedRegion::of(name));
    for (const char* wrong : {"below z", "below_z", "below 0.02 z", "below z = 0,004", "box top", "below w = 1", "below z = 1 2", "above z = high", "above z = nan", "ball 0 0 0 radius 0", "ball 0 0 0 0.1", "ball 0 0 radius 0.1 0", "box 0 0 0 to 1 1", "box 0 0 1 to 1 1 0"})
        CHECK_THAT(refusal<MismatchError>([&] { FixedRegion::of(wrong); }), Contains(wrong) && Contains("below z = 0.01"));
}

TEST_CASE("a within region extends the given distance to both sides of another surface and needs a reader", "[solid_shape]") {
    MshFile table;  // 200 mm by 200 mm at z = 10 mm, in millimetres, and an unused point
    table.file = "table.stl";
    for (const auto& [x, y] : {std::pair(-100, -100), {100, -100}, {100, 100}, {-100, 100}}) table.points.push_back({static_cast<double>(x), static_cast<double>(y), 10});
    table.points.push_back({0, 0, 0});
    table.triangles = {{1, {0, 1, 2}, 0}, {2, {0, 2, 3}, 0}};
    std::vector<std::string> asked;
    const FixedRegion::Reader read = [&](const std::string& file) { return asked.push_back(file), table; };
    const auto region = FixedRegion::of("within 0.003 of my_own/table__1.stl ", read, 0.001);
    REQUIRE(region);
    CHECK(region->word() == "within_0.003_of_my_own/table__1.stl");
    CHECK(region->text() == "within 0.003 of my_own/table__1.stl");
    CHECK(region->narrowest_m() == Approx(0.006));
    for (const auto& [x, y, z, out_m] : {std::tuple(0.01, 0.02, 0.010, -0.003), {0.01, 0.02, 0.014, 0.001}, {0.01, 0.02, 0.006, 0.001}, {0.103, 0.02, 0.014, 0.002}, {0.103, 0.104, 0.022, 0.010}})
        CHECK(region->outside_m({x, y, z}) == Approx(out_m).margin(1e-12));
    REQUIRE(FixedRegion::of(region->word(), read, 0.001));
    CHECK(FixedRegion::of(region->word(), read, 0.001)->outside_m({0, 0, 0}) == Approx(0.007));
    CHECK(asked == std::vector<std::string>(3, "my_own/table__1.stl"));
    CHECK(FixedRegion::within("within 0.003 of _b.stl")->file == "_b.stl");
    CHECK(FixedRegion::within("within_0.003_of__b.stl")->file == "_b.stl");
    CHECK(FixedRegion::within("\twithin  3e-3  of\ta b.stl\t")->word() == "within_3e-3_of_a b.stl");

    const Parts held = parts_of(make_surface(bare_dome(8), {"within 0.003 of table.stl"}, 0.001, read)),
                half_spaces = parts_of(make_surface(bare_dome(8), {"below z = 0.013"}, 0.001)), less = parts_of(make_surface(bare_dome(8), {"below z = 0.007"}, 0.001));
    CHECK(held.held_m2 == Approx(half_spaces.held_m2 - less.held_m2).epsilon(0.01));

    for (const char* name : {"within", "within_reach", "within_reach_of_it"}) CHECK_FALSE(FixedRegion::of(name, read));
    for (const char* wrong : {"within 0.003", "within 0.003 of", "within 0 of table.stl", "within -1 of table.stl", "within reach of table.stl", "within_0.003_table.stl"})
        CHECK_THAT(refusal<MismatchError>([&] { FixedRegion::of(wrong, read); }), Contains(wrong) && Contains("within 0.003 of spine.stl"));
    CHECK_THAT(refusal<MismatchError>([&] { FixedRegion::of("within 0.003 of table.stl"); }), Contains("is not possible here"));
    table.triangles = {{1, {0, 1, 1}, 0}};
    CHECK_THAT(refusal<FileError>([&] { FixedRegion::of("within 0.003 of table.stl", read); }), Contains("table.stl: has no triangle with an area"));
}

TEST_CASE("the part of a surface in a region is fixed; area, volume and closedness of the surface are unchanged", "[solid_shape]") {
    const MshFile bare = bare_dome(8);
    const Parts whole = parts_of(make_surface(bare, {"surface-1"}, 0.001));
    const double all_m2 = whole.held_m2 + whole.free_m2;
    for (const auto& texts : std::vector<std::vector<std::string>>{{"below z = 0.0203"}, {"above x = 0.0117"}, {"ball 0.03 0.01 0.03 radius 0.02"}, {"box -0.1 -0.1 0.011 to 0.007 0.1 0.1"}, {"below z = 0.0101", "above z = 0.041"}}) {
        const Surface s = make_surface(bare, texts, 0.001);
        INFO(texts[0]);
        const Parts parts = parts_of(s);
        CHECK(parts.held_m2 > 0.02 * all_m2);
        CHECK(parts.free_m2 > 0.02 * all_m2);
        CHECK(parts.held_m2 + parts.free_m2 == Approx(all_m2).epsilon(1e-9));
        CHECK(parts.six_volumes_m3 == Approx(whole.six_volumes_m3).epsilon(1e-9));
        // closed: every side has two triangles with opposite directions
        std::map<std::pair<int, int>, int> sides;
        for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
            for (int i = 0; i < 3; ++i) ++sides[{s.triangles(t, i), s.triangles(t, (i + 1) % 3)}];
        for (const auto& [side, count] : sides) {
            CHECK(count == 1);
            CHECK(sides.count({side.second, side.first}) == 1);
        }
        CHECK(s.nodes.rows() - s.triangles.rows() / 2 == 2);
        double shortest_m = 1;
        for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
            for (int i = 0; i < 3; ++i) shortest_m = std::min(shortest_m, (s.corner(t, i) - s.corner(t, (i + 1) % 3)).norm());
        // a side of more than 1/40 of 0.1 m is halved, and cut no nearer than a tenth to its end
        CHECK(shortest_m > 0.9 * 0.1 * 0.1 / 80);
        // no triangle crosses the border by more than a tenth of a side; a side there is 1/40 of the surface's extent
        const double far_m = 0.1 * 0.1 / 40 * 1.001;
        for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
            double least = 1, most = -1;
            for (int i = 0; i < 3; ++i) {
                double out = 1;
                for (const std::string& text : texts) out = std::min(out, FixedRegion::of(text)->outside_m(s.corner(t, i)));
                least = std::min(least, out);
                most = std::max(most, out);
            }
            const bool fixed = s.label[static_cast<std::size_t>(t)] == Surface::fixed_label;
            CHECK((fixed ? most : -least) < far_m);
        }
    }
    // the border belongs to the region also with rounded coordinates: the whole flat bed is fixed
    MshFile rounded = bare;
    for (std::size_t n = 0; n < rounded.points.size(); ++n) rounded.points[n].z += rounded.points[n].z != 0 ? 0 : n % 3 == 0 ? -1e-13 : 1e-13;
    for (const char* text : {"below z = 0", "below z = 1e-9"}) {
        const Parts bed = parts_of(make_surface(rounded, {text}, 0.001));
        CHECK(bed.held_m2 == Approx(bed_m2(bare)).epsilon(1e-6));
    }
    CHECK_THAT(refusal<FileError>([&] { make_surface(bare, {"below z = -0.1"}, 0.001); }), Contains("dome.stl: 'below z = -0.1' fixes no part of its surface, which extends from"));
    CHECK_THAT(refusal<FileError>([&] { make_surface(bare, {"below z = 0.1"}, 0.001); }), Contains("all of the surface is fixed: it extends from"));
    CHECK_THAT(refusal<FileError>([&] { make_surface(bare, {"below z"}, 0.001); }), Contains("dome.stl: 'below z' begins like a region"));
}

TEST_CASE("on large triangles the fixed area of a region is right to 3 per cent", "[solid_shape]") {
    // a box of 80 x 60 x 50 mm in twelve triangles
    const Shape corners = solid_block(Lattice{{1, 1, 1}, {0.08, 0.06, 0.05}});
    const Cells facets = open_faces(corners.simplices);
    MshFile box;
    box.file = "box.stl";
    for (Eigen::Index n = 0; n < 8; ++n) box.points.push_back({corners.nodes(n, 0), corners.nodes(n, 1), corners.nodes(n, 2)});
    for (Eigen::Index f = 0; f < facets.rows(); ++f) box.triangles.push_back({f + 1, {facets(f, 0), facets(f, 1), facets(f, 2)}, 0});
    constexpr double pi = 3.14159265358979;
    for (const auto& [text, wanted_m2] : {std::pair("below z = 0.004", 4.8e-3 + 0.28 * 0.004), {"below z = 0.046", 4.8e-3 + 0.28 * 0.046}, {"above z = 0.046", 4.8e-3 + 0.28 * 0.004}, {"below z = 0", 4.8e-3},
                                          {"ball 0.04 0.03 0 radius 0.02", pi * 4e-4}, {"box -1 -1 -1 to 0.04 0.03 0.02", 0.04 * 0.03 + 0.04 * 0.02 + 0.03 * 0.02}}) {
        const Surface s = make_surface(box, {text}, 1);
        const Parts parts = parts_of(s);
        INFO(text);
        CHECK(parts.held_m2 == Approx(wanted_m2).epsilon(0.03));
        CHECK(parts.held_m2 + parts.free_m2 == Approx(2 * (4.8e-3 + 4e-3 + 3e-3)).epsilon(1e-9));
        CHECK(s.nodes.rows() - s.triangles.rows() / 2 == 2);
    }
}

TEST_CASE("a thin slab is fixed all around; a too narrow region is refused; a plane divides few triangles", "[solid_shape][long]") {
    const auto box_of = [](const std::vector<int>& cells) {
        const Shape corners = solid_block(Lattice{cells, {0.1, 0.08, 0.05}});
        const Cells facets = open_faces(corners.simplices);
        MshFile box;
        box.file = "box.stl";
        for (Eigen::Index n = 0; n < corners.nodes.rows(); ++n) box.points.push_back({corners.nodes(n, 0), corners.nodes(n, 1), corners.nodes(n, 2)});
        for (Eigen::Index f = 0; f < facets.rows(); ++f) box.triangles.push_back({f + 1, {facets(f, 0), facets(f, 1), facets(f, 2)}, 0});
        return box;
    };
    for (const auto& cells : {std::vector<int>{1, 1, 1}, {10, 8, 5}}) {
        for (const char* slab : {"box -1 -1 0.020 to 1 1 0.021", "box -1 -1 0.0203 to 1 1 0.0213"}) {
            const Parts parts = parts_of(make_surface(box_of(cells), {slab}, 1));
            CHECK(parts.held_m2 == Approx(0.36 * 0.001).epsilon(0.1));
        }
        CHECK_THAT(refusal<FileError>([&] { make_surface(box_of(cells), {"box -1 -1 0.02 to 1 1 0.0205"}, 1); }), Contains("box.stl: 'box -1 -1 0.02 to 1 1 0.0205' is 0.5 mm wide, less than 1/130"));
        const Surface flat = make_surface(box_of(cells), {"below z = 0"}, 1);
        CHECK(flat.triangles.rows() == static_cast<Eigen::Index>(box_of(cells).triangles.size()));
    }
    // a cylinder as CAD programs write it: two ends, and triangles as long as the cylinder
    const auto cylinder_of = [](int n) {
        MshFile cylinder;
        cylinder.file = "cylinder.stl";
        for (int k = 0; k < n; ++k)
            for (const double z : {0.0, 0.1}) cylinder.points.push_back({0.03 * std::cos(2 * 3.14159265358979 * k / n), 0.03 * std::sin(2 * 3.14159265358979 * k / n), z});
        for (int k = 0; k < n; ++k) {
            const int a = 2 * k, b = 2 * ((k + 1) % n);
            cylinder.triangles.push_back({1, {a, b, b + 1}, 0});
            cylinder.triangles.push_back({1, {a, b + 1, a + 1}, 0});
            if (k == 0 || k == n - 1) continue;
            cylinder.triangles.push_back({1, {0, b, a}, 0});
            cylinder.triangles.push_back({1, {1, a + 1, b + 1}, 0});
        }
        return cylinder;
    };
    const MshFile cylinder = cylinder_of(500);
    const Surface half = make_surface(cylinder, {"below z = 0.05"}, 1);
    CHECK(half.triangles.rows() < 4 * static_cast<Eigen::Index>(cylinder.triangles.size()));
    CHECK(parts_of(half).held_m2 == Approx(3.14159 * 0.0009 + 2 * 3.14159 * 0.03 * 0.05).epsilon(0.01));
    CHECK_THAT(refusal<FileError>([&] { make_surface(cylinder_of(2000), {"ball 0 0 0.05 radius 0.0301"}, 1); }), Contains("more than 500000 new triangles near its border"));
}

TEST_CASE("a small fixed part keeps its area when the surface is remeshed; a loss of area is refused", "[solid_shape][long]") {
    const Shape corners = solid_block(Lattice{{50, 40, 25}, {0.1, 0.08, 0.05}});
    const Cells facets = open_faces(corners.simplices);
    MshFile box;
    box.file = "box.stl";
    for (Eigen::Index k = 0; k < corners.nodes.rows(); ++k) box.points.push_back({corners.nodes(k, 0), corners.nodes(k, 1), corners.nodes(k, 2)});
    for (Eigen::Index f = 0; f < facets.rows(); ++f) box.triangles.push_back({f + 1, {facets(f, 0), facets(f, 1), facets(f, 2)}, 0});
    for (const double radius : {0.004, 0.006, 0.01}) {
        const Surface s = make_surface(box, {fmt::format("ball 0.05 0.04 0.05 radius {}", radius)}, 1);
        const RimmedSurface made = with_rim(s, {{0.1, 0.04, 0.03}, 0.005, 0.002, 0.008});
        INFO(radius);
        CHECK(fixed_area_m2(made.surface) == Approx(3.14159 * radius * radius).epsilon(0.08));
        SurfaceRemesh even(s, {Eigen::Vector3d::Zero(), 0, 0.008, 0.008});
        even.remesh(8);
        CHECK_NOTHROW(check_fixed_area(s, even.surface()));
    }
    // a pad beside a much larger bed: the loss of the pad is refused
    const Surface both = make_surface(box, {"below z = 0", "ball 0.05 0.04 0.05 radius 0.006"}, 1);
    SurfaceRemesh coarse(both, {Eigen::Vector3d::Zero(), 0, 0.016, 0.016});
    coarse.remesh(8);
    CHECK_NOTHROW(check_fixed_area(both, coarse.surface()));
    Surface bed = coarse.surface();
    for (Eigen::Index t = 0; t < bed.triangles.rows(); ++t)
        if (bed.corner(t, 0).z() > 0.049) bed.label[static_cast<std::size_t>(t)] = Surface::free_label;
    CHECK_THAT(refusal<MismatchError>([&] { check_fixed_area(both, bed); }), Contains("mm2 of fixed surface at (") && Contains("only 0 mm2 remain"));
    Surface lost = make_surface(box, {"ball 0.05 0.04 0.05 radius 0.01"}, 1);
    const Surface whole = lost;
    lost.label.assign(lost.label.size(), Surface::free_label);
    CHECK_THAT(refusal<MismatchError>([&] { check_fixed_area(whole, lost); }), Contains("mm2 of fixed surface at ("));
}

TEST_CASE("facets of tetrahedra with their centroid in a region are fixed in addition to named ones", "[solid_shape]") {
    const Shape shape = dome(8);
    MshFile mesh;
    mesh.file = "dome.msh";
    for (Eigen::Index n = 0; n < shape.nodes.rows(); ++n) mesh.points.push_back({shape.nodes(n, 0), shape.nodes(n, 1), shape.nodes(n, 2)});
    for (Eigen::Index t = 0; t < shape.simplices.rows(); ++t)
        mesh.tetrahedra.push_back({t + 1, {shape.simplices(t, 0), shape.simplices(t, 1), shape.simplices(t, 2), shape.simplices(t, 3)}, 0});
    for (const auto& f : shape.fixed_facets) mesh.triangles.push_back({1, {f[0], f[1], f[2]}, 1});
    mesh.triangle_names[1] = "bed";
    const auto held = [&](const std::vector<std::string>& texts) { return make_solid_shape(mesh, texts, {}, 1).fixed_facets.size(); };
    const std::size_t bed = held({"bed"});
    CHECK(held({"below z = 1e-6"}) == bed);
    CHECK(held({"bed", "below z = 1e-6"}) == bed);
    CHECK(held({"bed", "above z = 0.04"}) > bed);
    CHECK(held({"below z = 0"}) == bed);
    for (const auto& texts : std::vector<std::vector<std::string>>{{"above z = 1"}, {"bed", "above z = 1"}})
        CHECK_THAT(refusal<FileError>([&] { held(texts); }), Contains("dome.msh: 'above z = 1' fixes no facet of its surface, which extends from"));
}
