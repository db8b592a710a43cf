#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "error.h"
#include "study/solid_push.h"
#include "study/study.h"
#include "../example.h"
#include "../refusal.h"
#include "../solid_example.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// Refusal of the solid example with one change; it must be one line with file and key.
std::string said(const std::string& from, const std::string& to, const std::string& key) {
    const TemporaryFolder folder;
    const std::string text = with(solid_study_text(), from, to), file = folder.file("s.toml", text);
    const std::string words = refusal<StudyError>([&] { read_study(file); });
    INFO(to);
    CHECK_THAT(words, Contains("s.toml:") && Contains("key '" + key + "': "));
    CHECK(words.find('\n') == std::string::npos);
    return words;
}

}  // namespace

TEST_CASE("a study with length_m is an incompressible solid block with modulus E in place of E t") {
    const Study s = example_study(solid_study_text());
    CHECK(s.geometry.is_solid());
    CHECK(s.geometry.is_block());
    CHECK(s.material.formulation == "incompressible");
    CHECK(s.modulus_N_m() == s.material.youngs_modulus_Pa());
    CHECK(s.lattice().cells == std::vector<int>{5, 4, 3});
    CHECK(s.lattice().size_m == std::vector<double>{0.1, 0.08, 0.05});
    CHECK(s.indenter.kind == "disc");
    CHECK(s.indenter.clearance_m() == Approx(0.012).epsilon(tolerance::rounding));
    CHECK(s.sizes_m == std::array<double, 2>{0.005, 0.02});
    CHECK(s.check_sizes_m == std::array<double, 2>{0.004, 0.015});
    CHECK(s.springs.topology == "embedded");
    CHECK_FALSE(s.loads.sweep);
    CHECK_FALSE(example_study().geometry.is_solid());
    CHECK(example_study().lattice().size_m == std::vector<double>{0.1, 0.1});
}

TEST_CASE("springs of a solid follow the material's curve or Hooke's law; second_share is C2's part") {
    const auto with_curve = [](const std::string& curve) { return with(solid_study_text(), "stiffness = \"law\"", "stiffness = \"law\"\ncurve = \"" + curve + "\""); };
    CHECK_FALSE(example_study(solid_study_text()).springs.hookean);
    CHECK_FALSE(example_study(with_curve("material")).springs.hookean);
    CHECK(example_study(with_curve("hooke")).springs.hookean);
    CHECK(example_study().springs.hookean);
    CHECK_THAT(said("stiffness = \"law\"", "stiffness = \"law\"\ncurve = \"ogden\"", "springs.curve"), Contains("allowed: material, hooke"));
    Study::MaterialParameters mooney_rivlin{263, 491, {}, {}};
    CHECK(mooney_rivlin.second_share() == Approx(491.0 / 754));
    // Ogden's law with alpha 2 and -2 is the Mooney-Rivlin law: 2 mu_1 = 4 C1 and -2 mu_2 = 4 C2
    CHECK(Study::MaterialParameters{0, 0, {2 * 263, -2 * 491}, {2, -2}}.second_share() == Approx(491.0 / 754));
    // stiffer in tension than any Mooney-Rivlin solid
    CHECK(Study::MaterialParameters{0, 0, {100}, {14}}.second_share() == 0);
    CHECK(Study::MaterialParameters{0, 0, {-100}, {-8}}.second_share() == 1);
}

TEST_CASE("directions in a solid are tilted from the inward normal towards an azimuth and exact along axes") {
    CHECK(solid_push(0, 77) == Eigen::Vector3d(0, 0, -1));
    CHECK(solid_push(90, 0) == Eigen::Vector3d(1, 0, 0));
    CHECK(solid_push(90, 90) == Eigen::Vector3d(0, 1, 0));
    CHECK(solid_push(90, 180) == Eigen::Vector3d(-1, 0, 0));
    CHECK(solid_push(90, -90) == Eigen::Vector3d(0, -1, 0));
    for (int axis : {0, 1, 2}) CHECK_FALSE((solid_push(90, 270)[axis] == 0 && std::signbit(solid_push(90, 270)[axis])));
    const double half = std::sqrt(0.5);
    CHECK((solid_push(30, 45) - Eigen::Vector3d(half / 2, half / 2, -std::sqrt(0.75))).norm() < tolerance::rounding);
}

TEST_CASE("contacts of a solid give training paths in the order of the study with distinct names") {
    const Study s = example_study(solid_study_text());
    REQUIRE(s.loads.paths.size() == 4);
    CHECK(s.loads.paths[0].name == "x0500-y0400-t00-a000");
    CHECK(s.loads.paths[1].name == "x0500-y0400-t30-a270");
    CHECK(s.loads.paths[2].name == "x0120-y0150-t00-a000");
    CHECK(s.loads.paths[3].name == "x0500-y0400-t90-a090");
    for (const StudyPath& p : s.loads.paths) CHECK(p.contact_m[2] == 0.05);
    CHECK(example_study(with(solid_study_text(), "[[90, 90]]", "[[90, 0]]")).loads.paths[3].name == "x0500-y0400-t90-a000");
    // a normal indentation has no azimuth, whatever the file gives
    CHECK(example_study(with(solid_study_text(), "0.015], pushes_deg = [[0, 0]]", "0.015], pushes_deg = [[0, 45]]")).loads.paths[2].name == "x0120-y0150-t00-a000");
    CHECK(s.loads.paths[0].depth_m == 0.010);
    CHECK(s.loads.paths[3].depth_m == 0.003);
    const Study fine = example_study(with(solid_study_text(), "[[0, 0], [30, -90]]", "[[0, 0], [30, -90], [30.2, -90], [30.2, -90.04]]"));
    CHECK(fine.loads.paths[0].name == "x050000-y040000-t0000-a00000");
    CHECK(fine.loads.paths[3].name == "x050000-y040000-t3020-a26996");
}

TEST_CASE("keys of the plane are refused in a solid and keys of a solid in the plane") {
    CHECK_THAT(said("height_m = 0.05", "height_m = 0.05\nthickness_m = 0.1", "geometry.thickness_m"), Contains("plane"));
    CHECK_THAT(said("height_m = 0.05", "height_m = 0.05\nshape = \"block\"", "geometry.shape"), Contains("plane"));
    said("length_m = 0.08", "length_m = 0", "geometry.length_m");
    CHECK_THAT(said("density_kg_m3 = 1000.0", "density_kg_m3 = 1000.0\nformulation = \"plane-strain\"", "material.formulation"), Contains("plane"));
    CHECK_THAT(said("density_kg_m3 = 1000.0", "density_kg_m3 = 1000.0\nregions = {}", "material.regions"), Contains("nodule"));
    said("cells = [5, 4, 3]", "cells = [5, 4]", "lattice.cells");
    said("cells = [5, 4, 3]", "cells = [5, 4, 2.5]", "lattice.cells");
    CHECK_THAT(said("[mesh]", "[mesh]\nrefine = 2", "mesh.refine"), Contains("sizes_m"));
    CHECK_THAT(said("[mesh]", "[mesh]\ncheck_refine = 2", "mesh.check_refine"), Contains("sizes_m"));
    CHECK_THAT(said("kind = \"disc\"", "kind = \"patch\"", "indenter.kind"), Contains("disc"));
    CHECK_THAT(said("record_step_m = 0.002", "record_step_m = 0.002\npaths = []", "loads.paths"), Contains("contacts"));
    CHECK_THAT(said("record_step_m = 0.002", "record_step_m = 0.002\nsweep = { spacing_m = 1 }", "loads.sweep"), Contains("contacts"));
    CHECK_THAT(said("topology = \"embedded\"", "topology = \"grid8\"", "springs.topology"), Contains("allowed: embedded"));
    CHECK_THAT(said("stiffness = \"law\"\nterms = [\"spring.all\", \"cell.all\"]", "law = \"axial\"", "springs.stiffness"), Contains("\"law\""));
    CHECK_THAT(said("[nodule]", "[data]\nx = 1\n[nodule]", "data"), Contains("plane"));
    CHECK_THAT(said("tilt_deg = [0, 30]\nclearance_m = [0.02, 0.05]\n\n[draws.held_out]",
                    "max_angle_deg = 30\ntilt_deg = [0, 30]\nclearance_m = [0.02, 0.05]\n\n[draws.held_out]", "draws.validation.max_angle_deg"),
               Contains("not known"));

    const auto plane = [](const std::string& from, const std::string& to) {
        return refusal<StudyError>([&] { example_study(with(example_study_text(), from, to)); });
    };
    CHECK_THAT(plane("topology = \"grid8\"", "topology = \"embedded\""), Contains("springs.topology") && Contains("allowed: grid4, grid8, edges"));
    CHECK_THAT(plane("kind = \"point\"", "kind = \"disc\""), Contains("indenter.kind"));
    CHECK_THAT(plane("[mesh]", "[nodule]\nx = 1\n[mesh]"), Contains("key 'nodule'") && Contains("geometry.length_m"));
    CHECK_THAT(plane("refine = 1", "refine = 1\nsizes_m = [1, 2]"), Contains("mesh.sizes_m"));
}

TEST_CASE("invalid contacts and directions and depths of a solid are refused by key") {
    CHECK_THAT(said("at_m = [0.012, 0.015]", "at_m = [0.0119, 0.015]", "loads.contacts[1].at_m"), Contains("11.9 mm") && Contains("needs 12 mm"));
    CHECK_THAT(said("at_m = [0.012, 0.015]", "at_m = [0.03, 0.0681]", "loads.contacts[1].at_m"), Contains("wall"));
    said("at_m = [0.012, 0.015]", "at_m = [0.012, 0.015, 0.05]", "loads.contacts[1].at_m");
    CHECK_THAT(said("[[90, 90]]", "[[181, 90]]", "loads.contacts[2].pushes_deg"), Contains("181"));
    said("[[90, 90]]", "[[-1, 90]]", "loads.contacts[2].pushes_deg");
    said("[[90, 90]]", "[[90, 361]]", "loads.contacts[2].pushes_deg");
    CHECK_THAT(said("[[90, 90]]", "[[90]]", "loads.contacts[2].pushes_deg"), Contains("lists of 2"));
    said("[[90, 90]]", "[90, 90]", "loads.contacts[2].pushes_deg");
    said("[[90, 90]]", "[]", "loads.contacts[2].pushes_deg");
    said("[[90, 90]]", "[[90, nan]]", "loads.contacts[2].pushes_deg");
    CHECK_THAT(said("[[90, 90]]", "[[30, 270]]", "loads.contacts[2].pushes_deg"), Contains("twice"));
    CHECK_THAT(said("[[90, 90]]", "[[0, 45]]", "loads.contacts[2].pushes_deg"), Contains("twice"));
    said("depth_m = 0.003", "depth_m = 0", "loads.contacts[2].depth_m");
    CHECK_THAT(said("depth_m = 0.003", "depth_m = 0.012", "loads.contacts[2].depth_m"), Contains("magnitudes_m"));
    CHECK_THAT(said("depth_m = 0.003", "depth_m = 0.007", "loads.contacts[2].depth_m"), Contains("record_step_m"));
    CHECK(example_study(with(solid_study_text(), "depth_m = 0.003", "depth_m = 0.008")).loads.paths[3].depth_m == 0.008);
    said("depth_m = 0.003,", "depht_m = 0.003,", "loads.contacts[2].depht_m");
    const std::string& text = solid_study_text();
    const std::size_t from = text.find("contacts = ["), to = text.find("[draws");
    CHECK_THAT(refusal<StudyError>([&] { example_study(text.substr(0, from) + "contacts = []\n" + text.substr(to)); }), Contains("loads.contacts"));
    CHECK_THAT(refusal<StudyError>([&] { example_study(text.substr(0, from) + text.substr(to)); }), Contains("'loads.contacts': is missing"));
}

TEST_CASE("a contact may have its own disc radius with depths in proportion; draws may have several radii") {
    const std::string own = "at_m = [0.012, 0.015]";
    const Study s = example_study(with(solid_study_text(), own, "at_m = [0.012, 0.015], radius_m = 0.0035"));
    CHECK(s.loads.paths[0].radius_m == 0.007);
    CHECK(s.loads.paths[2].radius_m == 0.0035);
    CHECK(s.loads.paths[2].depth_m == 0.005);  // half of 10 mm
    CHECK(s.loads.paths[2].name == "x0120-y0150-t00-a000-r035");
    CHECK(s.loads.paths[0].name == "x0500-y0400-t00-a000");
    CHECK(s.indenter.times(0.0035) == 0.5);
    CHECK(example_study(with(solid_study_text(), own, own + ", radius_m = 0.0035, depth_m = 0.004")).loads.paths[2].depth_m == 0.004);
    CHECK_THAT(said(own, own + ", radius_m = 0.0035, depth_m = 0.006", "loads.contacts[1].depth_m"), Contains("times 0.5"));
    CHECK_THAT(said(own, own + ", radius_m = 0.0035, depth_m = 0.0035", "loads.contacts[1].depth_m"), Contains("multiple") && Contains("times 0.5"));
    CHECK_THAT(said(own, own + ", radius_m = 0.0071", "loads.contacts[1].at_m"), Contains("radius 7.1 mm needs 12.1 mm"));
    CHECK_THAT(said(own, own + ", radius_m = 0.002", "loads.contacts[1].radius_m"), Contains("2 mm must be from a third to three times"));
    said(own, own + ", radius_m = 0.022", "loads.contacts[1].radius_m");
    said(own, own + ", radius_m = nan", "loads.contacts[1].radius_m");
    // one contact and one direction with two discs
    const Study both = example_study(with(solid_study_text(), "contacts = [", "contacts = [\n  { at_m = [0.050, 0.040], radius_m = 0.004, pushes_deg = [[0, 0]] },"));
    CHECK(both.loads.paths[0].name == "x0500-y0400-t00-a000-r040");

    const std::string seed = "[draws.validation]";
    const Study drawn = example_study(with(solid_study_text(), seed, seed + "\nradii_m = [0.004, 0.010]"));
    CHECK(drawn.draws[0].radii_m == std::vector<double>{0.004, 0.010});
    CHECK(drawn.draws[1].radii_m == std::vector<double>{0.007});
    CHECK_THAT(said(seed, seed + "\nradii_m = []", "draws.validation.radii_m"), Contains("list of numbers"));
    CHECK_THAT(said(seed, seed + "\nradii_m = [0.004, 0.004]", "draws.validation.radii_m"), Contains("twice"));
    CHECK_THAT(said(seed, seed + "\nradii_m = [0.004, 0.03]", "draws.validation.radii_m"), Contains("30 mm"));
    CHECK_THAT(said(seed, seed + "\nradii_m = [0.004, 0.020]", "draws.validation.clearance_m"), Contains("radius 20 mm needs 25 mm"));
}

TEST_CASE("draws with apart_m are pairs of discs and need a role of their own") {
    const std::string role = "[draws.held_out_near_a_wall]", pairs = role + "\napart_m = [0.015, 0.060]";
    const Study s = example_study(with(solid_study_text(), role, pairs));
    CHECK(s.draws[2].of_pairs());
    CHECK(s.draws[2].pair_apart_m[0] == 0.015);
    CHECK(s.draws[2].pair_apart_m[1] == 0.060);
    for (int d : {0, 1}) CHECK_FALSE(s.draws[static_cast<std::size_t>(d)].of_pairs());
    const auto wrong = [&](const std::string& apart) { return said(role, role + "\napart_m = " + apart, "draws.held_out_near_a_wall.apart_m"); };
    CHECK_THAT(wrong("[0.014, 0.060]"), Contains("two discs of radius 7 mm must be at least 14.7 mm apart, 2.1 radii"));
    CHECK_THAT(wrong("[0.060, 0.015]"), Contains("[smallest, largest]"));
    CHECK_THAT(wrong("[0.030, 0.030]"), Contains("[smallest, largest]"));
    wrong("[0.030]");
    wrong("0.030");
    CHECK_THAT(said(role, role + "\napart_m = [0.015, 0.060]\nradii_m = [0.004, 0.0075]", "draws.held_out_near_a_wall.clearance_m"), Contains("7.5 mm"));
    for (const char* own : {"[draws.validation]", "[draws.held_out]"}) {
        const std::string key = std::string(own).substr(1, std::string(own).size() - 2) + ".apart_m";
        CHECK_THAT(said(own, std::string(own) + "\napart_m = [0.015, 0.060]", key), Contains("their own role held_out_WORD"));
    }
}

TEST_CASE("mesh sizes of a solid too coarse for the disc or for the check are refused") {
    CHECK_THAT(said("sizes_m = [0.005, 0.02]", "sizes_m = [0.0071, 0.02]", "mesh.sizes_m"), Contains("indenter.radius_m"));
    CHECK_THAT(said("sizes_m = [0.005, 0.02]", "sizes_m = [0.005, 0.004]", "mesh.sizes_m"), Contains("[near, far]"));
    said("sizes_m = [0.005, 0.02]", "sizes_m = [0.005]", "mesh.sizes_m");
    CHECK_THAT(said("check_sizes_m = [0.004, 0.015]", "check_sizes_m = [0.005, 0.015]", "mesh.check_sizes_m"), Contains("smaller"));
    said("check_sizes_m = [0.004, 0.015]", "check_sizes_m = [0.004, 0.02]", "mesh.check_sizes_m");
    said("radius_m = 0.007", "radius_m = -0.007", "indenter.radius_m");
    said("check_fraction = 0.5", "check_fraction = 1.5", "mesh.check_fraction");
}

TEST_CASE("a nodule outside its block or near a wall is refused by key") {
    const Study s = example_study(solid_study_text());
    REQUIRE(s.nodule);
    CHECK(s.nodule->inclusion.centre_m() == Eigen::Vector3d(0.06, 0.04, 0.025));
    CHECK(s.nodule->youngs_modulus_Pa() == 6 * 3000.0);
    const std::string& text = solid_study_text();
    CHECK_FALSE(example_study(text.substr(0, text.find("[nodule]"))).nodule);
    for (const char* centre : {"[0.06, 0.04, 0.01]", "[0.06, 0.04, 0.04]", "[0.01, 0.04, 0.025]", "[0.09, 0.04, 0.025]", "[0.06, 0.01, 0.025]",
                               "[0.06, 0.07, 0.025]", "[0.06, 0.04, -1]"})
        CHECK_THAT(said("centre_m = [0.06, 0.04, 0.025]", std::string("centre_m = ") + centre, "nodule.radius_m"), Contains("from a wall"));
    said("radius_m = 0.008", "radius_m = 0", "nodule.radius_m");
    said("C1_Pa = 1000.0", "C1_Pa = -1", "nodule.C1_Pa");
    said("C2_Pa = 2000.0", "C2_Pa = 2000.0\nmu_Pa = [1]", "nodule.mu_Pa");
}

TEST_CASE("an Ogden solid has E of its initial shear modulus and its nodule needs as many terms") {
    const auto replaced = [](const std::string& nodule) {
        return with(with(solid_study_text(), "law = \"mooney-rivlin\"\nC1_Pa = 263.0\nC2_Pa = 491.0", "law = \"ogden\"\nmu_Pa = [900, -300]\nalpha = [3.7, -9.3]"),
                    "C1_Pa = 1000.0\nC2_Pa = 2000.0", nodule);
    };
    const Study s = example_study(replaced("mu_Pa = [9000, -3000]\nalpha = [3.7, -9.3]"));
    CHECK(s.material.youngs_modulus_Pa() == Approx(3 * (900 * 3.7 + 300 * 9.3) / 2));
    CHECK(s.nodule->youngs_modulus_Pa() == Approx(10 * s.material.youngs_modulus_Pa()));
    CHECK(s.modulus_N_m() == s.material.youngs_modulus_Pa());
    CHECK_THAT(refusal<StudyError>([&] { example_study(replaced("mu_Pa = [9000]\nalpha = [3.7]")); }),
               Contains("key 'nodule.alpha'") && Contains("as many entries as the base material's"));
    CHECK_THAT(refusal<StudyError>([&] { example_study(replaced("C1_Pa = 1000.0\nC2_Pa = 2000.0")); }), Contains("key 'nodule.mu_Pa'"));
}

TEST_CASE("a map has positions x and y on a block with a nodule or is refused by key") {
    const std::string map = "\n[map]\ndepth_m = 0.005\nx_m = [0.012, 0.06, 0.088]\ny_m = [0.04, 0.068]\n", last = "C2_Pa = 2000.0\n";
    const Study s = example_study(solid_study_text() + map);
    REQUIRE(s.map);
    CHECK(s.map->depth_m == 0.005);
    CHECK(s.map->x_m == std::vector<double>{0.012, 0.06, 0.088});
    CHECK(s.map->y_m == std::vector<double>{0.04, 0.068});
    CHECK_FALSE(example_study(solid_study_text()).map);
    const auto wrong = [&](const std::string& from, const std::string& to, const std::string& key) { return said(last, last + with(map, from, to), key); };
    CHECK_THAT(wrong("0.005", "0.0101", "map.depth_m"), Contains("magnitudes_m"));
    wrong("0.005", "0", "map.depth_m");
    CHECK_THAT(wrong("0.012, ", "0.0119, ", "map.x_m"), Contains("12 mm"));
    CHECK_THAT(wrong("0.068", "0.0681", "map.y_m"), Contains("12 mm"));
    CHECK_THAT(wrong("0.06, 0.088", "0.06, 0.06", "map.x_m"), Contains("ascending"));
    CHECK_THAT(wrong("[0.04, 0.068]", "[0.04]", "map.y_m"), Contains("two entries"));
    wrong("y_m = [0.04, 0.068]", "", "map.y_m");
    wrong("y_m", "z_m = 1\ny_m", "map.z_m");
    const std::string& text = solid_study_text();
    CHECK_THAT(refusal<StudyError>([&] { example_study(text.substr(0, text.find("[nodule]")) + map); }), Contains("key 'map'") && Contains("nodule"));
    CHECK_THAT(refusal<StudyError>([&] { example_study(example_study_text() + map); }), Contains("key 'map'") && Contains("geometry.length_m"));
}

TEST_CASE("draws of a solid may have several held_out_WORD roles with their own seeds and ranges") {
    const Study s = example_study(solid_study_text());
    std::vector<std::string> roles;
    for (const Study::Draws& d : s.draws) roles.push_back(d.role);
    CHECK(roles == std::vector<std::string>{"validation", "held_out", "held_out_near_a_wall"});
    CHECK(s.draws[2].clearance_m[1] == 0.02);
    CHECK(s.draws[2].tilt_deg[0] == 90);
    for (const char* role : {"held_out_", "held_out_2", "held_out_Near", "held_outnear", "held_out__a", "held_out_a_", "proof"})
        CHECK_THAT(said("[draws.held_out_near_a_wall]", "[draws." + std::string(role) + "]", "draws." + std::string(role)), Contains("held_out_WORD"));
    CHECK_THAT(said("seed = 3", "seed = 1", "draws.held_out_near_a_wall.seed"), Contains("validation"));
    said("depth_m = [0.001, 0.003]", "depth_m = [0.001, 0.011]", "draws.held_out_near_a_wall.depth_m");
    said("tilt_deg = [90, 90]", "tilt_deg = [90, 181]", "draws.held_out_near_a_wall.tilt_deg");
    said("tilt_deg = [90, 90]", "tilt_deg = [90, 80]", "draws.held_out_near_a_wall.tilt_deg");
    said("tilt_deg = [90, 90]\n", "", "draws.held_out_near_a_wall.tilt_deg");
    CHECK_THAT(said("clearance_m = [0.012, 0.02]", "clearance_m = [0.0115, 0.02]", "draws.held_out_near_a_wall.clearance_m"), Contains("12 mm"));
    CHECK_THAT(said("clearance_m = [0.012, 0.02]", "clearance_m = [0.02, 0.02]", "draws.held_out_near_a_wall.clearance_m"), Contains("[smallest"));
    CHECK_THAT(said("clearance_m = [0.012, 0.02]", "clearance_m = [0.04, 0.05]", "draws.held_out_near_a_wall.clearance_m"), Contains("no place"));
}

TEST_CASE("variants of a solid keep the first terms and paths and have no arc lengths") {
    const auto varied = [](const std::string& more) { return example_study(solid_study_text() + "\n[[variants]]\nname = \"few\"\n" + more); };
    const Study s = varied("first_terms = 1\nfirst_paths = 2\nmagnitudes_m = [0.004]\narea_cap_E2 = 6\nshape_scale = 0.1\n");
    REQUIRE(s.variants.size() == 1);
    CHECK(s.variants[0].first_paths == 2);
    CHECK(s.variants[0].terms == std::vector<std::string>{"spring.all"});
    CHECK(s.variants[0].magnitudes_m == std::vector<double>{0.004});
    CHECK(varied("").variants[0].first_paths == 0);
    CHECK(varied("").variants[0].magnitudes_m == s.loads.magnitudes_m);
    for (const char* wrong : {"first_paths = 0", "first_paths = 5", "arcs_m = [0.1]", "angles_deg = [0]", "magnitudes_m = [0.005]"})
        CHECK_THAT(refusal<StudyError>([&] { varied(wrong); }), Contains("key 'variants[0]."));
    const TemporaryFolder folder;
    const std::string plane = folder.file("p.toml", "based_on = \"" + (std::filesystem::current_path() / "fem/studies/surface-quick").string() +
                                                        "\"\n[[variants]]\nname = \"few\"\nfirst_paths = 2\n");
    CHECK_THAT(refusal<StudyError>([&] { read_study(plane); }), Contains("first_paths"));
}

TEST_CASE("block3 has thirty training indentations that start with four normal ones and include six tangential ones") {
    const Study s = read_study("fem/studies/block3.toml");
    REQUIRE(s.loads.paths.size() == 30);
    CHECK(!s.variants.empty());
    CHECK(read_study("fem/studies/block3-quick.toml").variants.empty());  // variants refer to the contacts of the base
    for (int i = 0; i < 4; ++i) CHECK(s.loads.paths[static_cast<std::size_t>(i)].direction == Eigen::Vector3d(0, 0, -1));
    int along = 0;
    for (const StudyPath& p : s.loads.paths) along += p.direction[2] == 0 && p.depth_m == 0.003;
    CHECK(along == 6);
    CHECK(read_study("fem/studies/block3-quick.toml").loads.paths.size() == 7);
    CHECK(read_study("fem/studies/block3-mini.toml").loads.paths.size() == 4);
}
