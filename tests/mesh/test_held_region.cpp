// Parts of space that hold a solid's surface.
#include "mesh/held_region.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "../refusal.h"
#include "error.h"
#include "mesh/open_faces.h"
#include "mesh/solid_shape.h"
#include "mesh/surface.h"
#include "dome.h"

using namespace tissue;
using Approx = Catch::Detail::Approx;
using Catch::Matchers::Contains;

namespace {

/// The surface of a dome of tetrahedra, as a file of triangles without names, in millimetres.
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

}  // namespace

TEST_CASE("a region that holds is read from text and from its word, and what begins like one but is none is refused", "[solid_shape]") {
    const Eigen::Vector3d at(0.01, 0.02, 0.03);
    for (const auto& [text, word, out_m] : {std::tuple("below z = 0.012", "below_z_0.012", 0.018), {"above x = -3e-2", "above_x_-3e-2", -0.04}, {"above x=0.5", "above_x_0.5", 0.49},
                                            {"ball 0.01 0.02 0.01 radius 0.015", "ball_0.01_0.02_0.01_radius_0.015", 0.005}, {"box 0 0 0 to 0.1 0.05 0.01", "box_0_0_0_to_0.1_0.05_0.01", 0.02},
                                            {"box 0 0 0 to 0.1 0.1 0.1", "box_0_0_0_to_0.1_0.1_0.1", -0.01}}) {
        const auto region = HeldRegion::of(text);
        REQUIRE(region);
        CHECK(region->word() == word);
        CHECK(region->outside_m(at) == Approx(out_m).margin(1e-15));
        const auto again = HeldRegion::of(region->word());
        REQUIRE(again);
        CHECK(again->word() == word);
        CHECK(again->outside_m(at) == region->outside_m(at));
    }
    for (const char* name : {"bed", "surface-1", "below", "belowdeck", "underside"}) CHECK_FALSE(HeldRegion::of(name));
    for (const char* wrong : {"below z", "below w = 1", "below z = 1 2", "above z = high", "above z = nan", "ball 0 0 0 radius 0", "ball 0 0 0 0.1", "ball 0 0 radius 0.1 0", "box 0 0 0 to 1 1", "box 0 0 1 to 1 1 0"})
        CHECK_THAT(refusal<MismatchError>([&] { HeldRegion::of(wrong); }), Contains(wrong) && Contains("below z = 0.01"));
}

TEST_CASE("what of a surface lies in a region is held, to its border, and the surface stays what it was", "[solid_shape]") {
    const MshFile bare = bare_dome(8);
    const Parts whole = parts_of(make_surface(bare, {"surface-1"}, 0.001));
    const double all_m2 = whole.held_m2 + whole.free_m2;
    double shortest_side_m = 1;
    for (const MshFile::Element& e : bare.triangles)
        for (int i = 0; i < 3; ++i) {
            const MshFile::Point &a = bare.points[static_cast<std::size_t>(e.node[i])], &b = bare.points[static_cast<std::size_t>(e.node[(i + 1) % 3])];
            shortest_side_m = std::min(shortest_side_m, 1e-3 * std::hypot(a.x - b.x, a.y - b.y, a.z - b.z));
        }
    for (const auto& texts : std::vector<std::vector<std::string>>{{"below z = 0.0203"}, {"above x = 0.0117"}, {"ball 0.03 0.01 0.03 radius 0.02"}, {"box -0.1 -0.1 0.011 to 0.007 0.1 0.1"}, {"below z = 0.0101", "above z = 0.041"}}) {
        const Surface s = make_surface(bare, texts, 0.001);
        INFO(texts[0]);
        const Parts parts = parts_of(s);
        CHECK(parts.held_m2 > 0.02 * all_m2);
        CHECK(parts.free_m2 > 0.02 * all_m2);
        CHECK(parts.held_m2 + parts.free_m2 == Approx(all_m2).epsilon(1e-9));
        CHECK(parts.six_volumes_m3 == Approx(whole.six_volumes_m3).epsilon(1e-9));
        // every side has two triangles that run it in opposite ways, so it closes as before
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
        CHECK(shortest_m > 0.09 * shortest_side_m);
        // no triangle reaches across the border by more than a tenth of a side
        for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
            double least = 1, most = -1, longest = 0;
            for (int i = 0; i < 3; ++i) {
                double out = 1;
                for (const std::string& text : texts) out = std::min(out, HeldRegion::of(text)->outside_m(s.corner(t, i)));
                least = std::min(least, out);
                most = std::max(most, out);
                longest = std::max(longest, (s.corner(t, i) - s.corner(t, (i + 1) % 3)).norm());
            }
            const bool fixed = s.label[static_cast<std::size_t>(t)] == Surface::fixed_label;
            CHECK((fixed ? most : -least) < 0.25 * longest);
        }
    }
    // a plane's area, from the cut that it makes
    const Parts parts = parts_of(make_surface(bare, {"below z = 1e-6"}, 0.001)), bed = parts_of(make_surface(bare, {"below z = 0.0001"}, 0.001));
    CHECK(parts.held_m2 == Approx(bed.held_m2).epsilon(1e-9));  // nodes within a tenth of a side are on the border
    CHECK_THAT(refusal<FileError>([&] { make_surface(bare, {"below z = -0.1"}, 0.001); }), Contains("dome.stl: 'below_z_-0.1' holds nothing of its surface, which reaches from"));
    CHECK_THAT(refusal<FileError>([&] { make_surface(bare, {"below z = 0.1"}, 0.001); }), Contains("all of the surface is held"));
}

TEST_CASE("facets of a solid's tetrahedra with their middles in a region are held beside those that have a name", "[solid_shape]") {
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
    CHECK_THAT(refusal<FileError>([&] { held({"above z = 1"}); }), Contains("nothing of the surface is in the fixed surfaces"));
}
