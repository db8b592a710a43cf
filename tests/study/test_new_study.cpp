#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>

#include "../example.h"
#include "../refusal.h"
#include "error.h"
#include "mesh/msh_file.h"
#include "study/new_study.h"
#include "study/shape_extent.h"
#include "study/study.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const char* const outline = "Point(1) = {0, 0, 0};\nPoint(2) = {80, 0, 0}; Point(3) = {80, 40.5, 0};  // Point(9) = {900, 0, 0};\nPoint(4) = {-1e1, 40, 0};\n"
                            "Line(1) = {1, 2};\nPhysical Curve(\"bed\") = {1};\nPhysical Line(\"wall\", 7) = {2};\nPhysical Surface(\"tissue\") = {1};\n"
                            "Physical Surface(\"lump\") = {2};\n";

const char* const tetrahedron = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 1 \"bed\"\n3 2 \"liver\"\n1 5 \"rim\"\n$EndPhysicalNames\n"
                                "$Nodes\n4\n1 0 0 0\n2 30 0 0\n3 0 40 0\n4 0 0 50\n$EndNodes\n"
                                "$Elements\n2\n1 2 2 1 1 1 2 3\n2 4 2 2 2 1 2 3 4\n$EndElements\n";

std::string binary_stl(std::uint32_t facets) {
    std::string text(84 + 50 * static_cast<std::size_t>(facets), '\0');
    std::memcpy(&text[80], &facets, 4);
    const float corners[9] = {0, 0, 0, 2, 0, 0, 0, 3, 5};
    for (std::size_t f = 0; f < facets; ++f) std::memcpy(&text[84 + 50 * f + 12], corners, sizeof corners);
    return text;
}

std::string ascii_stl(const std::string& first, const std::string& second) {
    const std::string a = " vertex 0 0 0\n", b = " VERTEX 60 0 0\n", c = " vertex 0 50 40\n", d = " vertex 0 50 0\n";
    const auto facet = [](const std::string& corners) { return " facet normal 0 0 1\n outer loop\n" + corners + " endloop\n endfacet\n"; };
    return "solid " + first + "\n" + facet(a + b + c) + "endsolid\nSolid " + second + "\r\n" + facet(b + a + d) + facet(c + b + d) + facet(a + c + d) + "endsolid\n";
}

std::string why_not(const TemporaryFolder& folder, const std::string& name, const std::string& text) {
    return refusal<FileError>([&] { shape_extent(folder.file(name, text)); });
}

}  // namespace

TEST_CASE("size and part names of a shape are read from .geo and .msh and .stl files", "[new]") {
    const TemporaryFolder folder;
    const ShapeExtent plane = shape_extent(folder.file("a.geo", outline));
    CHECK_FALSE(plane.solid);
    CHECK(plane.boundaries == std::vector<std::string>{"bed", "wall"});
    CHECK(plane.regions == std::vector<std::string>{"tissue", "lump"});
    REQUIRE(plane.low);
    CHECK((*plane.low)[0] == -10);
    CHECK((*plane.high)[1] == 40.5);  // the comment is ignored
    const ShapeExtent arc = shape_extent(folder.file("arc.geo", std::string(outline) + "Point( 5 ) = {0, -20000, 0};\nCircle(3) = {3, 5, 4};\n"));
    CHECK((*arc.low)[1] == 0);  // the centre of an arc is ignored
    CHECK_FALSE(shape_extent(folder.file("b.geo", std::string(outline) + "Point(5) = {w, 0, 0};\n")).low);
    CHECK_FALSE(shape_extent(folder.file("c.geo", "SetFactory(\"OpenCASCADE\");\n" + std::string(outline))).low);
    CHECK(shape_extent(folder.file("d.geo", "Physical Volume(\"flesh\") = {1};\nPhysical Surface(\"bed\") = {2};\n")).boundaries == std::vector<std::string>{"bed"});

    // groups without a name are named by their number
    CHECK(shape_extent(folder.file("e.geo", "Physical Volume(7) = {1};\nPhysical Surface(\"bed\", 2) = {2};\nPhysical Surface( 3 ) = {3};\n")).boundaries == std::vector<std::string>{"bed", "3"});
    const std::string whole = tetrahedron, nameless = whole.substr(0, whole.find("$Physical")) + whole.substr(whole.find("$Nodes"));
    CHECK(shape_extent(folder.file("n.msh", nameless)).boundaries == std::vector<std::string>{"1"});
    CHECK(shape_extent(folder.file("n.msh", nameless)).regions == std::vector<std::string>{"2"});
    const std::string clash = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 4 \"1\"\n$EndPhysicalNames\n" + whole.substr(whole.find("$Nodes"));
    CHECK_THAT(why_not(folder, "clash.msh", clash), Contains("its group 1 has no name, and another group has the name '1': give every group a name"));
    CHECK_THAT(refusal<FileError>([&] { read_msh(folder.file("clash.msh", clash), true); }), Contains("its group 1 has no name"));
    std::string second = nameless;
    second.replace(second.find("2 4 2 2 2"), 9, "2 11 2 2 2");
    CHECK_THAT(why_not(folder, "second.msh", second), Contains("elements of second order; save it with first order"));
    const ShapeExtent solid = shape_extent(folder.file("a.msh", tetrahedron));
    CHECK(solid.solid);
    CHECK(solid.boundaries == std::vector<std::string>{"bed"});
    CHECK(solid.regions == std::vector<std::string>{"liver"});
    CHECK(solid.nodes == 4);
    CHECK((*solid.high)[2] == 50);
    const ShapeExtent newer = shape_extent(folder.file("b.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n2 3 1 3\n0 1 0 1\n1\n0 0 0\n2 1 0 2\n2\n3\n7 0 0\n0 8 0\n"
                                                                "$EndNodes\n$Elements\n2 2 1 2\n1 1 1 1\n1 1 2\n2 1 2 1\n2 1 2 3\n$EndElements\n"));
    CHECK_FALSE(newer.solid);
    CHECK((*newer.high)[1] == 8);
    const ShapeExtent parametric = shape_extent(folder.file("c.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n2 3 1 3\n0 1 0 1\n1\n0 0 0\n2 1 1 2\n2\n3\n"
                                                                     "7 0 0 90 90\n0 8 0 90 90\n$EndNodes\n$Elements\n1 1 1 1\n2 1 2 1\n2 1 2 3\n$EndElements\n"));
    CHECK((*parametric.high)[0] == 7);

    CHECK((*shape_extent(folder.file("a.stl", binary_stl(2))).high)[2] == 5);
    const ShapeExtent named = shape_extent(folder.file("b.stl", ascii_stl("the bed", "skin")));
    CHECK(named.boundaries == std::vector<std::string>{"the bed", "skin"});
    CHECK((*named.high)[0] == 60);
}

TEST_CASE("an invalid shape file is refused by name and cause", "[new]") {
    const TemporaryFolder folder;
    CHECK_THAT(why_not(folder, "a.msh", "Point(1) = {0, 0, 0};"), Contains("a.msh: has no complete $MeshFormat section"));
    CHECK_THAT(why_not(folder, "b.msh", "$MeshFormat\n2.2 1 8\n$EndMeshFormat\n"), Contains("is binary; save it as text"));
    CHECK_THAT(why_not(folder, "c.msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n"), Contains("has MSH format 4; formats 2.2 and 4.1"));
    CHECK_THAT(why_not(folder, "d.msh", with(tetrahedron, "1 0 0 0\n", "1 0 zero 0\n")), Contains("cannot read $Nodes"));
    CHECK_THAT(why_not(folder, "e.msh", with(tetrahedron, "$Nodes\n4", "$Nodes\n900000000")), Contains("cannot read $Nodes"));
    CHECK_THAT(why_not(folder, "f.msh", with(tetrahedron, "2 4 2 2 2 1 2 3 4", "2 2 2 1 1 1 2 4")), Contains("no tetrahedra; save its surface as .stl"));
    CHECK_THAT(why_not(folder, "a.stl", "solid\nendsolid\n"), Contains("a.stl: has no facets"));
    CHECK_THAT(why_not(folder, "b.stl", "solid\n vertex 60 nan 0\nendsolid\n"), Contains("b.stl:2: "));
    CHECK_THAT(why_not(folder, "huge.geo", "Point(1) = {1e999, 0, 0};\n"), Contains("a coordinate is not a finite number"));
    CHECK_THAT(why_not(folder, "a.step", "v 0 0 0"), Contains("a shape must be a .geo, .msh, .stl, .obj"));
    CHECK_NOTHROW(shape_extent(folder.file("long.geo", "Point(1) = {" + std::string(3'000'000, ' ') + "0, 0, 0};")));
    // the time is not quadratic in the length of a line: seconds, not minutes
    for (const char* repeated : {"1", "Point(", "Circle(1) = {", " "}) {
        std::string text;
        for (int k = 0; k < 200; ++k) {
            text += "Point(1) = {";
            while (text.size() % 2000 < 1900) text += repeated;
            text += '\n' + std::string(2000 - text.size() % 2000 - 1, '\n');
        }
        CHECK_FALSE(shape_extent(folder.file("lines.geo", text)).low);
    }
}

TEST_CASE("a new study in the plane or in space is valid and its sizes scale with the tissue", "[new]") {
    const TemporaryFolder folder;
    for (const char* name : {"studies", "materials"}) std::filesystem::create_directory(folder.file(name));
    folder.file("materials/jelly.toml", "law = \"neo-Hookean\"\nC1_Pa = 500\ndensity_kg_m3 = 1000\n");
    NewStudy wanted;
    wanted.preset = "jelly";
    wanted.trust_geo = true;
    wanted.fixed = {"bed"};
    wanted.unit_m = 0.001;
    for (const double factor : {0.5, 1.0, 4.0}) {
        wanted.unit_m = 0.001 * factor;
        wanted.shape = folder.file("studies/a.geo", outline);
        wanted.shape_in_study = "a.geo";
        const WrittenStudy plane = new_study(wanted);
        const Study study = read_study(folder.file("studies/plane.toml", plane.toml));
        CHECK(study.springs.is_energy_model());
        CHECK(study.geometry.fixed == wanted.fixed);
        CHECK(study.spring_size_m > 0.05 * factor * 0.06);
        CHECK(study.spring_size_m <= factor * 0.06 / 8);
        CHECK(study.loads.depth_m() <= factor * 0.0405 / 10 * 1.001);
        CHECK(study.loads.sweep->clearance_m == Approx(study.indenter.clearance_m()));
        // a small tissue has room for contacts
        CHECK(study.loads.sweep->clearance_m <= std::min(0.015, factor * 0.0405 / 3));
        CHECK(study.draws.size() == 2);
        wanted.shape = folder.file("studies/b.stl", ascii_stl("bed", "skin"));
        wanted.shape_in_study = "b.stl";
        const Study solid = read_study(folder.file("studies/solid.toml", new_study(wanted).toml));
        CHECK(solid.geometry.is_solid());
        CHECK(solid.loads.path_count() == 24);
        CHECK(solid.indenter.radius_m <= 0.007);
        CHECK(solid.springs.topology == "embedded");
        CHECK(solid.springs.spacing_m == solid.spring_size_m);
        CHECK(solid.springs.spacing_m <= factor * 0.0061);
    }
    wanted.shape = folder.file("studies/a.msh", tetrahedron);
    wanted.shape_in_study = "a.msh";
    const auto of_mesh = [&] { return read_study(folder.file("studies/mesh.toml", new_study(wanted).toml)); };
    CHECK(of_mesh().spring_size_m == 0);  // displacements are compared at its nodes
    CHECK(of_mesh().springs.spacing_m > 0.001);
    wanted.size_m = 0.0123;
    CHECK(of_mesh().springs.spacing_m == 0.0123);
    wanted.fixed = {"below z = 0.01"};
    CHECK(of_mesh().geometry.fixed == std::vector<std::string>{"below_z_0.01"});
    wanted.bed_Pa_m = 2e5;
    CHECK(of_mesh().geometry.bed_Pa_m == std::vector<double>{2e5});
    wanted.fixed = {"below z"};
    CHECK_THAT(refusal<MismatchError>([&] { new_study(wanted); }), Contains("'below z' begins like a region"));
}

TEST_CASE("a new study without valid fixed parts or with an implausible unit or size is refused", "[new]") {
    const TemporaryFolder folder;
    NewStudy wanted;
    wanted.shape = folder.file("a.geo", outline);
    wanted.shape_in_study = "a.geo";
    wanted.unit_m = 0.001;
    const auto said = [&] { return refusal<MismatchError>([&] { new_study(wanted); }); };
    CHECK_THAT(said(), Contains("a.geo: --held must name the curves that are fixed; its names: bed, wall"));
    wanted.fixed = {"bad"};
    CHECK_THAT(said(), Contains("has no curve 'bad' to fix; its names: bed, wall"));
    wanted.fixed = {"bed"};
    wanted.bed_Pa_m = 2e5;
    CHECK_THAT(said(), Contains("a.geo: --bed needs a tissue in space"));
    wanted.bed_Pa_m = 0;
    wanted.unit_m = 1;
    CHECK_THAT(said(), Contains("is 90 m long; is this in millimetres?"));
    wanted.unit_m = 1e-4;
    CHECK_THAT(said(), Contains("a.geo: is 4.05 mm wide"));
    wanted.unit_m = 0.001;
    wanted.shape = folder.file("b.geo", std::string("SetFactory(\"OpenCASCADE\");\n") + outline);
    CHECK_THAT(said(), Contains("its size is unknown before gmsh meshes it; give the length of the springs"));
    wanted.size_m = 0.01;
    CHECK_THAT(new_study(wanted).toml, Contains("size_m = 0.01 "));
    wanted.shape = folder.file("a.geo", outline);
    wanted.size_m = 0.03;
    CHECK_THAT(said(), Contains("a.geo: --size 0.03 m is more than half of its shortest side, 40.5 mm"));
    wanted.size_m = 0.0001;
    CHECK_THAT(said(), Contains("a.geo: --size 0.0001 m is less than a hundredth of its longest side, 90 mm"));
    wanted.shape = folder.file("b.geo", std::string("SetFactory(\"OpenCASCADE\");\n") + outline);
    wanted.size_m.reset();
    wanted.shape = folder.file("c.stl", ascii_stl("", ""));
    wanted.fixed = {};
    CHECK_THAT(said(), Contains("surface-1 (the largest)"));
    wanted.shape = folder.file("d.stl", binary_stl(1));
    CHECK_THAT(said(), Contains("d.stl: cannot be filled: 1 hole, perimeter 14 mm; at (0.666667, 1, 1.66667)") && Contains("--repair OUT.stl"));
}
