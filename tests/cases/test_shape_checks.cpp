#include <catch2/catch.hpp>

#include "../mesh/embedded_block.h"
#include "../example.h"
#include "../refusal.h"
#include "../solid_example.h"
#include "cases/plan.h"
#include "cases/shape_checks.h"
#include "error.h"
#include "mesh/topology.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

MshFile box(double x, double y, double z, double at = 0) {
    MshFile mesh;
    for (int i = 0; i < 8; ++i) mesh.points.push_back({at + (i & 1 ? x : 0), i & 2 ? y : 0, i & 4 ? z : 0});
    mesh.lines = {{1, {0, 7, 0}, 0}};  // its diagonal
    return mesh;
}

Study shaped(double unit_m, double size_m) {
    Study s = example_study();
    s.geometry.shape = "lobe.stl";
    s.geometry.unit_m = unit_m;
    s.spring_size_m = size_m;
    return s;
}

}  // namespace

TEST_CASE("a shape or block with an implausible unit of length is refused by key", "[shape_checks]") {
    const auto said = [](double unit_m, double size_m, const MshFile& mesh) { return refusal<StudyError>([&] { refuse_wrong_unit(shaped(unit_m, size_m), mesh); }); };
    CHECK_NOTHROW(refuse_wrong_unit(shaped(0.001, 0.01), box(120, 90, 55)));
    CHECK_NOTHROW(refuse_wrong_unit(shaped(0.001, 0.001), box(120, 40, 0)));
    CHECK_NOTHROW(refuse_wrong_unit(shaped(0.001, 0.01), box(120, 90, 55, 90'000)));  // 90 m from the origin
    CHECK_THAT(said(1, 0.01, box(120, 90, 55)), Contains("key 'geometry.unit_m': lobe.stl is 120 m long") && Contains("in millimetres?"));
    CHECK_THAT(said(1, 0.01, box(120, 0, 0)), Contains("in millimetres?"));  // only a curve
    CHECK_THAT(said(0.001, 0.0001, box(120, 90, 0)), Contains("at most 100000"));
    CHECK_THAT(said(1e-6, 0.01, box(120, 90, 55)), Contains("lobe.stl is 0.12 mm long") && Contains("less than two springs"));
    CHECK_THAT(said(0.001, 0.01, box(120, 90, 55, 2'000'000)), Contains("key 'geometry.shape'") && Contains("2e+03 m from the origin") &&
               Contains("Subtract (2.00006e+06, 45, 27.5) from the coordinates in that file, and (2000.06, 0.045, 0.0275) m from every contact_m"));
    MshFile arc = box(120, 90, 55);
    arc.points.push_back({50, -2'000'000, 0});  // the centre of an arc
    CHECK_NOTHROW(refuse_wrong_unit(shaped(0.001, 0.01), arc));
    CHECK_NOTHROW(refuse_wrong_unit(shaped(0.001, 0.01), MshFile()));
    Study mesh = shaped(1, 0);  // the surface of a .msh in space is remeshed with finite elements of this size
    mesh.sizes_m = {0.003, 0.013};
    CHECK_THAT(refusal<StudyError>([&] { refuse_wrong_unit(mesh, box(120, 90, 55)); }), Contains("mesh.sizes_m = 0.013 m"));
    CHECK_THAT(said(0.001, 0.0001, box(120, 90, 0)), !Contains("millimetres"));  // the unit is millimetres already
    Study plane = shaped(1, 0);  // a .msh in the plane has no element size: the size of the tool is used
    plane.sizes_m = {0, 0};
    plane.indenter.half_width_m = 0.010;
    CHECK_THAT(refusal<StudyError>([&] { refuse_wrong_unit(plane, box(120, 90, 0)); }), Contains("more than 1000 times indenter.half_width_m = 0.01 m") && Contains("in millimetres?"));
    plane.geometry.unit_m = 0.001;
    CHECK_NOTHROW(refuse_wrong_unit(plane, box(120, 90, 0)));
    Study block;
    block.file = "block.toml";
    block.geometry.width_m = 100, block.geometry.height_m = 80;
    block.loads.magnitudes_m = {0.004, 0.01};
    CHECK_THAT(refusal<StudyError>([&] { refuse_wrong_unit(block); }), Contains("block.toml: key 'geometry.width_m'") && Contains("in millimetres?"));
    block.geometry.width_m = 0.1, block.geometry.height_m = 0.08;
    CHECK_NOTHROW(refuse_wrong_unit(block));
}

TEST_CASE("a contour much finer than the requested spring length causes a warning", "[shape_checks]") {
    const Shape fine = shape_of(make_lattice("grid4", 20, 20, 0.1, 0.1));  // springs of 5 mm and their diagonals
    CHECK(finer_than_asked(shaped(1, 0.005), fine).empty());
    CHECK(finer_than_asked(shaped(1, 0.010), fine).empty());
    CHECK_THAT(finer_than_asked(shaped(1, 0.020), fine), Contains("lobe.stl has an outline much finer than lattice.size_m = 0.02 m: 441 nodes"));
    CHECK(finer_than_asked(shaped(1, 0), fine).empty());
}

TEST_CASE("a patch not narrower than the tissue's shorter side is refused by key", "[shape_checks]") {
    Study s = example_study();
    s.indenter.kind = "patch";
    const SpringMesh mesh = make_lattice("grid8", 10, 4, 0.1, 0.04);
    for (const double fits : {0.005, 0.0199}) {
        s.indenter.half_width_m = fits;
        CHECK_NOTHROW(refuse_tool(s, mesh));
    }
    s.indenter.half_width_m = 0.02;
    CHECK_THAT(refusal<StudyError>([&] { refuse_tool(s, mesh); }), Contains("key 'indenter.half_width_m': 20 mm must be less than half of the tissue's shorter side, 40 mm"));
}

TEST_CASE("an indentation through the tissue is refused with path and depth and thickness", "[shape_checks]") {
    const Study s = example_study();
    const auto path = [](Point at, Point direction, double depth_m, const std::string& role) {
        PlannedPath p;
        p.push = {"through", at, direction};
        p.role = role;
        p.depth_m = depth_m;
        return std::vector<PlannedPath>{p};
    };
    const SpringMesh plane = make_lattice("grid8", 10, 2, 0.1, 0.01), plate = embedded_block(Lattice{{10, 10, 1}, {0.1, 0.1, 0.01}});
    const Point top = Eigen::Vector2d(0.05, 0.01), corner = Eigen::Vector2d(0.1, 0.01), down = Eigen::Vector2d(0, -1), tilted = Eigen::Vector2d(0.6, -0.8);
    CHECK_NOTHROW(refuse_push_through(s, plane, path(top, down, 0.0099, "train")));
    CHECK_NOTHROW(refuse_push_through(s, plane, path(top, tilted, 0.012, "train")));
    // leaves at the side, which is free to move
    CHECK_NOTHROW(refuse_push_through(s, plane, path(Eigen::Vector2d(0.098, 0.01), tilted, 0.009, "train")));
    CHECK_NOTHROW(refuse_push_through(s, plane, path(corner, Eigen::Vector2d(-1, 0), 0.05, "train")));
    CHECK_THAT(refusal<StudyError>([&] { refuse_push_through(s, plane, path(top, down, 0.01, "train")); }),
               Contains("key 'loads.magnitudes_m': load path 'through' has an indentation of 10 mm at (0.05, 0.01) m, where the tissue is 10 mm thick"));
    CHECK_THAT(refusal<StudyError>([&] { refuse_push_through(s, plane, path(top, tilted, 0.0126, "held_out")); }), Contains("key 'draws.held_out.depth_m'"));
    const Point on_plate = Eigen::Vector3d(0.043, 0.05, 0.01), in = Eigen::Vector3d(0, 0, -1);
    CHECK_NOTHROW(refuse_push_through(s, plate, path(on_plate, in, 0.008, "train")));
    CHECK_THAT(refusal<StudyError>([&] { refuse_push_through(s, plate, path(on_plate, in, 0.012, "train")); }), Contains("10 mm thick"));
    Study swept = s;
    swept.loads.sweep = Study::Loads::Sweep{0.01, 0.015, {0}};
    std::vector<PlannedPath> many(10, path(top, down, 0.005, "train")[0]);
    many.push_back(path(top, down, 0.02, "held_out")[0]);
    CHECK_NOTHROW(refuse_push_through(swept, plane, many));  // one of eleven paths
    many.push_back(path(top, down, 0.02, "train")[0]);
    CHECK_THAT(refusal<StudyError>([&] { refuse_push_through(swept, plane, many); }), Contains("key 'draws.held_out.depth_m'") && Contains("2 of 12 load paths pass through"));
    many.erase(many.begin() + 10);
    CHECK_NOTHROW(refuse_push_through(swept, plane, many));
    CHECK_THROWS_AS(refuse_push_through(s, plane, many), StudyError);  // a listed path without FE reference is an error
}
