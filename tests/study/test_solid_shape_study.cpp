#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "error.h"
#include "study/solid_push.h"
#include "study/study.h"
#include "../refusal.h"
#include "../solid_shape_study.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// Refusal of the example with one change; it must be one line with file and key.
std::string said(const std::string& from, const std::string& to, const std::string& key) {
    const std::string words = refusal<StudyError>([&] { shape_study(with(shape_study_text(), from, to)); });
    INFO(to);
    CHECK_THAT(words, Contains("example.toml:") && Contains("key '" + key + "': "));
    CHECK(words.find('\n') == std::string::npos);
    return words;
}

constexpr const char* spread = "[loads.spread]\ncount = 5\nclearance_m = 0.015\npushes_deg = [[0, 0], [30, 0]]\n";

/// The example with spread contacts.
std::string spread_text() {
    const std::string& text = shape_study_text();
    const std::size_t from = text.find("contacts = ["), to = text.find("[draws");
    return text.substr(0, from) + spread + text.substr(to);
}

}  // namespace

TEST_CASE("a study with geometry.solid is an incompressible solid shape with listed or spread contacts", "[solid_shape]") {
    const Study s = shape_study();
    CHECK(s.geometry.is_solid());
    CHECK_FALSE(s.geometry.is_block());
    CHECK(s.geometry.unit_m == 0.001);
    CHECK(s.geometry.fixed == std::vector<std::string>{"bed"});
    CHECK(s.material.formulation == "incompressible");
    CHECK(s.modulus_N_m() == s.material.youngs_modulus_Pa());
    CHECK(s.spring_size_m == 0.01);
    CHECK(s.springs.topology == "embedded");
    CHECK(s.sizes_m == std::array<double, 2>{0.005, 0.02});
    REQUIRE(s.loads.contacts.size() == 2);
    CHECK(s.loads.paths.empty());
    CHECK(s.loads.path_count() == 5);
    CHECK(s.loads.contacts[0].depth_m == 0.008);
    CHECK(s.loads.contacts[1].depth_m == 0.003);
    const Study spread_out = shape_study(spread_text());
    REQUIRE(spread_out.loads.spread);
    CHECK(spread_out.loads.path_count() == 10);
    CHECK(shape_study(with(spread_text(), "count = 5", "count = 5\npushes_each = 1")).loads.path_count() == 5);
    CHECK(spread_out.loads.spread->clearance_m == 0.015);
}

TEST_CASE("tilt and azimuth give a direction about the inward normal with azimuth 0 towards x", "[solid_shape]") {
    const Eigen::Vector3d down(0, 0, -1);
    for (double tilt : {0.0, 30.0, 90.0})
        for (double azimuth : {0.0, 45.0, 90.0, 270.0}) CHECK((surface_push(down, tilt, azimuth) - solid_push(tilt, azimuth)).norm() < tolerance::rounding);
    const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.5, -0.7).normalized();
    CHECK((surface_push(n, 0, 33) - n).norm() < tolerance::rounding);
    for (double azimuth : {0.0, 77.0, 200.0}) {
        const Point d = surface_push(n, 30, azimuth);
        CHECK(d.dot(n) == Approx(std::sqrt(0.75)).epsilon(tolerance::rounding));
        CHECK(d.norm() == Approx(1).epsilon(tolerance::rounding));
    }
    CHECK(surface_push(n, 90, 0)[0] > 0);                                                         // towards x
    CHECK(std::abs(surface_push(n, 90, 90)[0]) < tolerance::rounding);                            // perpendicular to x
    // towards y where n is along x
    CHECK((surface_push(Eigen::Vector3d(1, 0, 0), 90, 0) - Eigen::Vector3d(0, 1, 0)).norm() < tolerance::rounding);
    CHECK((surface_push(Eigen::Vector3d(-1, 0, 0), 90, 90) - Eigen::Vector3d(0, 1, 0).cross(Eigen::Vector3d(-1, 0, 0))).norm() < tolerance::rounding);
}

TEST_CASE("invalid and missing keys of a solid shape are refused by key", "[solid_shape]") {
    CHECK_THAT(said("solid = true", "solid = false", "geometry.solid"), Contains("must be true"));
    CHECK_THAT(said("solid = true", "solid = 1", "geometry.solid"), Contains("true or false"));
    CHECK_THAT(said("solid = true", "solid = true\nthickness_m = 0.1", "geometry.thickness_m"), Contains("plane"));
    CHECK_THAT(said("solid = true", "solid = true\nlength_m = 0.1", "geometry.solid"), Contains("block"));
    CHECK_THAT(said("solid = true", "solid = true\nwidth_m = 0.1", "geometry.width_m"), Contains("not known"));
    CHECK_THAT(said("shape = \"dome.geo\"\n", "", "geometry.solid"), Contains("geometry.shape"));
    CHECK_THAT(said("dome.geo", "dome.step", "geometry.shape"), Contains(".geo, .msh, .stl, .obj"));
    CHECK_THAT(said("dome.geo", "block", "geometry.shape"), Contains(".geo, .msh, .stl, .obj"));
    CHECK_THAT(said("dome.geo", "cone.geo", "geometry.shape"), Contains("there is no file"));
    CHECK_THAT(said("trust_geo = true\n", "", "geometry.shape"), Contains("a program") && Contains("trust_geo = true"));
    CHECK_THAT(said("trust_geo = true\n", "trust_geo = false\n", "geometry.shape"), Contains("trust_geo = true"));
    CHECK_THAT(said("fixed = [\"bed\"]", "fixed = []", "geometry.fixed"), Contains("physical surface"));
    CHECK_THAT(said("[\"bed\"]", "[\"bed,two\"]", "geometry.fixed"), Contains("comma"));
    for (const char* stiffness : {"9.9", "1.1e9", "-1.0", "inf", "\"soft\""}) said("[\"bed\"]\n", "[\"bed\"]\nbed_Pa_m = " + std::string(stiffness) + "\n", "geometry.bed_Pa_m");
    CHECK(shape_study(with(shape_study_text(), "[\"bed\"]\n", "[\"bed\"]\nbed_Pa_m = 2e5\n")).geometry.bed_Pa_m == std::vector<double>{2e5});
    CHECK(shape_study(with(shape_study_text(), "[\"bed\"]\n", "[\"bed\"]\nbed_Pa_m = 0\n")).geometry.bed_Pa_m.empty());
    const Study::Geometry three = shape_study(with(shape_study_text(), "[\"bed\"]\n", "[\"bed\", \"wall\", \"roof\", \"side\"]\nbed_Pa_m = [1e5, 0.0, 2e5, 1e5]\n")).geometry;
    CHECK(three.beds() == std::vector<int>{1, 0, 2, 1});
    CHECK(three.beds_Pa_m() == std::vector<double>{1e5, 2e5});
    CHECK_THAT(said("[\"bed\"]\n", "[\"bed\"]\nbed_Pa_m = [1e5, 0.0]\n", "geometry.bed_Pa_m"), Contains("has 2 numbers for the 1 names of 'fixed'"));
    CHECK_THAT(said("solid = true", "bed_Pa_m = 2e5", "geometry.bed_Pa_m"), Contains("geometry.solid"));
    CHECK_THAT(said("[draws.held_out]", "[draws.held_out_two]\napart_m = [0.015, 0.06]", "draws.held_out_two.apart_m"), Contains("on a block only"));
    said("fixed = [\"bed\"]\n", "", "geometry.fixed");
    said("[lattice]\nsize_m = 0.01\n", "", "lattice");
    said("size_m = 0.01", "cells = [5, 4, 3]", "lattice.size_m");
    said("size_m = 0.01", "size_m = -1", "lattice.size_m");
    CHECK_THAT(said("\"embedded\"", "\"grid8\"", "springs.topology"), Contains("allowed: embedded"));
    CHECK_THAT(said("\"embedded\"", "\"edges\"", "springs.topology"), Contains("allowed: embedded"));
    CHECK_THAT(said("stiffness = \"law\"\nterms = [\"spring.all\", \"cell.all\"]", "law = \"axial\"", "springs.stiffness"), Contains("solid shape"));
    CHECK_THAT(said("kind = \"disc\"", "kind = \"patch\"", "indenter.kind"), Contains("solid shape"));
    CHECK_THAT(said("law = \"mooney-rivlin\"\nC1_Pa = 263.0\nC2_Pa = 491.0", "law = \"gent\"", "material.law"), Contains("ogden"));
    CHECK_THAT(said("density_kg_m3 = 1000.0", "density_kg_m3 = 1000.0\nformulation = \"plane-strain\"", "material.formulation"), Contains("plane"));
    CHECK_THAT(said("[springs]", "[nodule]\nradius_m = 0.01\n[springs]", "nodule.centre_m"), Contains("missing"));
    CHECK_THAT(said("[springs]", "[nodule]\ncentre_m = [0, 0, 0.03]\nradius_m = 0.01\nC1_Pa = 1\nC2_Pa = 1\nat_m = 1\n[springs]", "nodule.at_m"), Contains("not known"));
    CHECK_THAT(said("[springs]", "[map]\ndepth_m = 0.004\n[springs]", "map"), Contains("geometry.length_m"));
    CHECK_THAT(said("[springs]", "[data]\nfile = \"x.csv\"\n[springs]", "data"), Contains("finite elements"));
    CHECK_THAT(said("sizes_m = [0.005, 0.02]", "sizes_m = [0.0071, 0.02]", "mesh.sizes_m"), Contains("indenter.radius_m"));
    const std::string stone = "density_kg_m3 = 1000.0\nregions.stone = { C1_Pa = 1, C2_Pa = 2 }";
    CHECK(shape_study(with(shape_study_text(), "density_kg_m3 = 1000.0", stone)).material.region_names() == std::vector<std::string>{"stone"});
    CHECK_THAT(refusal<StudyError>([&] {
                   shape_study(with(with(shape_study_text(), "density_kg_m3 = 1000.0", stone), "[springs]",
                                    "[nodule]\ncentre_m = [0, 0, 0.03]\nradius_m = 0.01\nC1_Pa = 1\nC2_Pa = 1\n[springs]"));
               }),
               Contains("key 'nodule': is not possible with material.regions"));
    const TemporaryFolder folder;
    const auto none_said = [&] { return refusal<StudyError>([&] { read_study(folder.file("b.toml", shape_study_text())); }); };
    folder.file("README.md", "| `home.geo` |");
    CHECK_THAT(none_said(), Contains("there is no file") && !Contains("README.md"));
    folder.file("README.md", "| `dome.geo` | from there |");
    CHECK_THAT(none_said(), Contains("there is no file") && Contains("README.md states where to get it"));
    folder.file("dome.stl", "");
    CHECK_THAT(refusal<StudyError>([&] {
                   read_study(folder.file("a.toml", with(with(shape_study_text(), "density_kg_m3 = 1000.0", stone), "dome.geo", "dome.stl")));
               }),
               Contains("key 'material.regions': are physical volumes"));
}

TEST_CASE("contacts of a solid shape are either listed or spread and invalid ones are refused by key", "[solid_shape]") {
    CHECK_THAT(said("record_step_m = 0.002", "record_step_m = 0.002\nspread = { count = 1 }", "loads.spread"), Contains("listed or spread"));
    CHECK_THAT(said("record_step_m = 0.002", "record_step_m = 0.002\nsweep = { spacing_m = 1 }", "loads.sweep"), Contains("contacts or spread"));
    const std::string& text = shape_study_text();
    const std::size_t from = text.find("contacts = ["), to = text.find("[draws");
    CHECK_THAT(refusal<StudyError>([&] { shape_study(text.substr(0, from) + text.substr(to)); }), Contains("'loads.contacts': is missing: a solid shape needs contacts or spread"));
    CHECK_THAT(refusal<StudyError>([&] { shape_study(text.substr(0, from) + "contacts = []\n" + text.substr(to)); }), Contains("loads.contacts"));
    said("at_m = [0.0, 0.0, 0.051]", "at_m = [0.0, 0.051]", "loads.contacts[0].at_m");
    CHECK_THAT(said("[[0, 0], [30, -90]]", "[[0, 0], [0, 45]]", "loads.contacts[0].pushes_deg"), Contains("twice"));
    said("[[0, 0], [30, -90]]", "[[181, 0]]", "loads.contacts[0].pushes_deg");
    said("[[0, 0], [30, -90]]", "[[30, 361]]", "loads.contacts[0].pushes_deg");
    CHECK_THAT(said("depth_m = 0.003,", "depth_m = 0.009,", "loads.contacts[1].depth_m"), Contains("magnitudes_m"));
    said("depth_m = 0.003,", "depht_m = 0.003,", "loads.contacts[1].depht_m");
    CHECK_THAT(said("clearance_m = [0.012, 0.03]", "clearance_m = [0.011, 0.03]", "draws.held_out.clearance_m"), Contains("12 mm to where the surface ends or turns"));
    const auto spread_said = [](const std::string& before, const std::string& after) {
        return refusal<StudyError>([&] { shape_study(with(spread_text(), before, after)); });
    };
    CHECK_THAT(spread_said("count = 5", "count = 0"), Contains("key 'loads.spread.count'"));
    CHECK_THAT(spread_said("clearance_m = 0.015\npushes", "clearance_m = 0.011\npushes"), Contains("key 'loads.spread.clearance_m'") && Contains("12 mm"));
    CHECK_THAT(spread_said("[[0, 0], [30, 0]]", "[]"), Contains("key 'loads.spread.pushes_deg'"));
    for (const char* each : {"0", "3"}) CHECK_THAT(spread_said("count = 5", std::string("count = 5\npushes_each = ") + each), Contains("key 'loads.spread.pushes_each'"));
    CHECK_THAT(spread_said("count = 5", "count = 5\ndepth_m = 0.001"), Contains("key 'loads.spread.depth_m'"));
    const auto nodule = [](const std::string& rows) { return refusal<StudyError>([&] { shape_study(shape_study_text() + "\n[nodule]\nC1_Pa = 4000\nC2_Pa = 0\n" + rows); }); };
    CHECK_THAT(nodule("shape = \"none.stl\"\n"), Contains("key 'nodule.shape': there is no file ") && Contains("none.stl"));
    CHECK_THAT(nodule("shape = \"ball.geo\"\n"), Contains("key 'nodule.shape': 'ball.geo' must be a file that ends in .stl"));
    CHECK_THAT(nodule("shape = \"none.stl\"\nradius_m = 0.01\n"), Contains("key 'nodule.shape': is not possible with centre_m and radius_m"));
    CHECK_THAT(nodule("shape = \"none.stl\"\nradius_m = 0.01\nunit_m = 1\n"), Contains("is not possible with"));
    CHECK_THAT(nodule("centre_m = [0, 0, 0.03]\nradius_m = 0.01\nunit_m = 1\n"), Contains("key 'nodule.unit_m': is not known"));
}

TEST_CASE("a derived study of a solid shape replaces the contacts and the geometry of its base", "[solid_shape]") {
    const TemporaryFolder folder;
    folder.file("dome.geo", "");
    folder.file("base.toml", shape_study_text());
    CHECK(read_study(folder.file("a.toml", std::string("based_on = \"base\"\n") + spread)).loads.contacts.empty());
    CHECK(read_study(folder.file("a.toml", std::string("based_on = \"base\"\n") + spread)).geometry.shape == folder.file("dome.geo", ""));
    folder.file("other.geo", "");
    // trust in the base's file does not extend to another file
    for (const char* trust : {"", "trust_geo = false\n", "trust_geo = true\n"}) {
        const std::string file = folder.file("d.toml", std::string("based_on = \"base\"\n[geometry]\nshape = \"other.geo\"\n") + trust + "[lattice]\nsize_m = 0.01\n[springs]\nspacing_m = 0.01\n" + spread);
        CAPTURE(trust);
        if (std::string(trust).find("= true") != std::string::npos) CHECK_NOTHROW(read_study(file));
        else CHECK_THAT(refusal<StudyError>([&] { read_study(file); }), Contains("d.toml:3: key 'geometry.shape'") && Contains("trust_geo = true"));
    }
    folder.file("spread.toml", spread_text());
    CHECK_FALSE(read_study(folder.file("b.toml", "based_on = \"spread\"\n[loads]\ncontacts = [{ at_m = [0, 0, 0.05], pushes_deg = [[0, 0]] }]\n")).loads.spread);
    const std::string on_block = "based_on = \"" + (std::filesystem::current_path() / "fem/studies/block3-quick").string() +
                                 "\"\n[geometry]\nsolid = true\nshape = \"dome.geo\"\ntrust_geo = true\nfixed = [\"bed\"]\n[lattice]\nsize_m = 0.01\n[springs]\ntopology = \"embedded\"\nspacing_m = 0.01\nterms = [\"spring.all\"]\n";
    CHECK(read_study(folder.file("c.toml", on_block + spread)).geometry.is_solid());
}

TEST_CASE("variants of a solid shape keep at most as many paths as it has indentations", "[solid_shape]") {
    const auto varied = [](const std::string& more) { return shape_study(shape_study_text() + "\n[[variants]]\nname = \"few\"\n" + more); };
    CHECK(varied("first_paths = 5").variants[0].first_paths == 5);
    CHECK_THAT(refusal<StudyError>([&] { varied("first_paths = 6"); }), Contains("key 'variants[0].first_paths'"));
}
