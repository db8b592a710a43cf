// Studies with a user's shape and material: reading, planning and contacts.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "../example.h"
#include "../mesh/disc.h"
#include "../refusal.h"
#include "../tolerances.h"
#include "cases/plan.h"
#include "cases/study_mesh.h"
#include "cases/sweep.h"
#include "error.h"
#include "mesh/outline.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// The example study on a shape, with contacts all round its free surface.
std::string shape_text() {
    std::string text = with(example_study_text(), "width_m = 0.1\nheight_m = 0.1\n",
                            "shape = \"bean.geo\"\ntrust_geo = true\nunit_m = 0.001\nfixed = [\"table\"]\n");
    text = with(text, "cells = [4, 4]", "size_m = 0.01");
    text = with(text, "topology = \"grid8\"", "topology = \"edges\"");
    const std::size_t from = text.find("paths = ["), to = text.find("[springs]");
    return text.substr(0, from) +
           "[loads.sweep]\nspacing_m = 0.02\nclearance_m = 0.02\nangles_deg = [-40, 0, 30]\n\n"
           "[draws]\nheld_out = { seed = 5, count = 20, depth_m = [0.002, 0.008], max_angle_deg = 30 }\n\n" +
           text.substr(to);
}

/// Reads a study from a folder with empty outline files and its own material.
Study read(const std::string& text) {
    const TemporaryFolder folder;
    folder.file("bean.geo", "");
    folder.file("bean.msh", "");
    std::filesystem::create_directories(folder.file("materials"));
    std::filesystem::create_directories(folder.file("studies"));
    folder.file("materials/jelly.toml",
                "law = \"ogden\"\nmu_Pa = [600, -50]\nalpha = [3, -4]\ndensity_kg_m3 = 1000\n");
    std::string moved = text;
    for (const char* file : {"\"bean.geo\"", "\"bean.msh\""})
        if (const std::size_t at = moved.find(file); at != std::string::npos) moved.insert(at + 1, "../");
    return read_study(folder.file("studies/own.toml", moved));
}

std::string said(const std::string& from, const std::string& to) {
    return refusal<StudyError>([&] { read(with(shape_text(), from, to)); });
}

}  // namespace

TEST_CASE("a study of a shape has the path of its file and its unit and fixed curves") {
    const Study s = read(shape_text());
    CHECK_FALSE(s.geometry.is_block());
    CHECK_THAT(s.geometry.shape, Catch::Matchers::EndsWith("/bean.geo") && !Contains(".."));
    CHECK(s.geometry.unit_m == 0.001);
    CHECK(s.geometry.fixed == std::vector<std::string>{"table"});
    CHECK(s.spring_size_m == 0.01);
    CHECK(s.springs.topology == "edges");
}

TEST_CASE("Ogden parameters equivalent to Mooney-Rivlin constants give the same Young modulus") {
    const std::string ogden = with(example_study_text(), "law = \"mooney-rivlin\"\nC1_Pa = 263.0\nC2_Pa = 491.0",
                                   "law = \"ogden\"\nmu_Pa = [526, -982]\nalpha = [2, -2]");
    CHECK(example_study(ogden).material.youngs_modulus_Pa() ==
          Approx(example_study().material.youngs_modulus_Pa()).epsilon(tolerance::rounding));
    CHECK(example_study(ogden).second_modulus_N_m() ==
          Approx(example_study().second_modulus_N_m()).epsilon(tolerance::rounding));
    CHECK_THAT(make_plan(example_study(ogden)).parts.at("path-left"),
               Contains("-law ogden -terms 2 -mu1 526 -alpha1 2 -mu2 -982 -alpha2 -2"));
}

TEST_CASE("a material preset gives law and parameters and density and replaces the base study's material") {
    const Study s = read(with(shape_text(), "law = \"mooney-rivlin\"\nC1_Pa = 263.0\nC2_Pa = 491.0\ndensity_kg_m3 = 1040.0",
                              "preset = \"jelly\""));
    CHECK(s.material.law == "ogden");
    CHECK(s.material.mu_Pa == std::vector<double>{600, -50});
    CHECK(s.material.density_kg_m3 == 1000);
    CHECK(s.material.formulation == "plane-stress");
    const Study heavy = read(with(shape_text(), "law = \"mooney-rivlin\"\nC1_Pa = 263.0\nC2_Pa = 491.0", "preset = \"jelly\""));
    CHECK(heavy.material.density_kg_m3 == 1040);

    const TemporaryFolder folder;
    std::filesystem::create_directories(folder.file("materials"));
    std::filesystem::create_directories(folder.file("studies"));
    folder.file("materials/soft.toml", "law = \"neo-Hookean\"\nC1_Pa = 7\ndensity_kg_m3 = 900\n");
    folder.file("studies/base.toml", example_study_text());
    const Study derived = read_study(folder.file("studies/derived.toml", "based_on = \"base\"\n[material]\npreset = \"soft\"\n"));
    CHECK(derived.material.C1_Pa == 7);
    CHECK(derived.material.C2_Pa == 0);
    CHECK(derived.material.density_kg_m3 == 900);
}

TEST_CASE("regions have their own parameters and FE receives them by label") {
    const Study s = read(with(shape_text(), "[mesh]",
                              "[material.regions]\nstone = { C1_Pa = 5000, C2_Pa = 1 }\nfat = { C1_Pa = 20, C2_Pa = 0 }\n\n[mesh]"));
    REQUIRE(s.material.region_names() == std::vector<std::string>{"fat", "stone"});
    CHECK(s.material.regions[1].youngs_modulus_Pa() == 6 * 5001);
    const Plan plan = make_plan(s, disc(44));
    bool seen = false;
    for (const auto& [name, text] : plan.parts)
        if (name.rfind("path-", 0) == 0) {
            seen = true;
            CHECK_THAT(text, Contains("-C1 263 -C2 491 -C1_11 20 -C2_11 0 -C1_12 5000 -C2_12 1 -refine 1"));
        }
    CHECK(seen);
    CHECK_THAT(plan.parts.at("shape"), Contains("regions fat,stone"));
    CHECK(plan.parts.at("train") != make_plan(read(shape_text()), disc(44)).parts.at("train"));
}

TEST_CASE("without its mesh the plan of a shape only makes the mesh") {
    const Study s = read(shape_text());
    const Plan first = make_plan(s), whole = make_plan(s, disc(44));
    CHECK(first.parts.size() == 1);
    CHECK_THAT(first.fragment, Contains("SHAPE := ") && Contains("SHAPE_ARGUMENTS := -2 -clmin 10 -clmax 10") &&
                                   Contains("$(R)/plan.mk: $(R)/mesh.msh") && !Contains("PATHS"));
    CHECK(whole.parts.at("shape") == first.parts.at("shape"));
    CHECK_THAT(whole.fragment, Contains(" held-out-0001 ") && Contains("$(R)/cases/held-out-0001.csv: $(R)/plan/path-held-out-0001 "));
    CHECK_THAT(make_plan(read(with(with(shape_text(), "bean.geo", "bean.msh"), "[lattice]\nsize_m = 0.01\n", ""))).fragment,
               Contains("SHAPE_ARGUMENTS := -save"));
}

TEST_CASE("training contacts cover the free surface of a shape at whole degrees from its normal") {
    const Study s = read(shape_text());
    const Shape shape = disc(44);
    const Outline outline(edge_mesh(shape));
    int trained = 0;
    for (const PlannedPath& p : planned_paths(s, shape)) {
        const double arc = outline.arc_of(p.push.contact_m);
        CHECK((outline.position(arc) - p.push.contact_m).norm() < tolerance::rounding);
        CHECK(arc >= 0.02 - 1e-12);
        CHECK(arc <= outline.length() - 0.02 + 1e-12);
        if (p.role != "train") continue;
        ++trained;
        const double angle = std::atan2(1, 0) / 90 * std::round(outline.angle(arc, p.push.direction) / std::atan2(1, 0) * 90);
        CHECK(outline.angle(arc, p.push.direction) == Approx(angle).margin(1e-9));  // whole degrees
    }
    const int places = 1 + static_cast<int>(std::floor((outline.length() - 0.04) / 0.02));
    CHECK(trained == 3 * places);  // three angles each; the disc has no corners
}

TEST_CASE("topology edges has a spring on each edge of a block's triangulated lattice") {
    Study s = example_study();
    const SpringMesh mesh = study_mesh(s, {}, "edges");
    CHECK(mesh.nodes == study_mesh(s, {}, "grid8").nodes);
    CHECK(mesh.spring_count() == 25 + 32 - 1);
    CHECK(mesh.fixed == study_mesh(s, {}, "grid4").fixed);
    CHECK_THROWS_AS(study_mesh(read(shape_text()), {}, "edges"), MismatchError);
    CHECK_THROWS_AS(study_mesh(read(shape_text()), disc(44), "grid8"), MismatchError);
}

TEST_CASE("invalid keys of a study with a shape are refused by key") {
    CHECK_THAT(said("\"bean.geo\"", "\"bean.stl\""), Contains("key 'geometry.shape'") && Contains(".geo or .msh"));
    CHECK_THAT(said("\"bean.geo\"", "\"pea.geo\""), Contains("key 'geometry.shape'") && Contains("there is no file"));
    CHECK_THAT(said("fixed = [\"table\"]", "fixed = []"), Contains("key 'geometry.fixed'") && Contains("at least one"));
    CHECK_THAT(said("unit_m = 0.001", "unit_m = 0"), Contains("key 'geometry.unit_m'"));
    CHECK_THAT(said("unit_m = 0.001", "width_m = 0.1"), Contains("key 'geometry.width_m': is not known"));
    CHECK_THAT(said("\"bean.geo\"", "\"bean.msh\""), Contains("key 'lattice'") && Contains(".msh already has triangles"));
    CHECK_THAT(said("topology = \"edges\"", "topology = \"grid4\""), Contains("allowed: edges"));
    CHECK_THAT(said("law = \"mooney-rivlin\"", "preset = \"jelly\""), Contains("key 'material.C1_Pa'") && Contains("preset"));
    CHECK_THAT(said("law = \"mooney-rivlin\"\nC1_Pa = 263.0\nC2_Pa = 491.0", "preset = \"glass\""),
               Contains("'glass' is not a material; there are: jelly"));
    CHECK_THAT(said("law = \"mooney-rivlin\"", "law = \"ogden\""), Contains("key 'material.mu_Pa': is missing"));
    const auto ogden = [](const std::string& parameters) {
        return said("law = \"mooney-rivlin\"\nC1_Pa = 263.0\nC2_Pa = 491.0", "law = \"ogden\"\n" + parameters);
    };
    CHECK_THAT(ogden("mu_Pa = [1, 2]\nalpha = [2]"), Contains("key 'material.alpha': must have as many"));
    CHECK_THAT(ogden("mu_Pa = [1]\nalpha = [0]"), Contains("no entry may be 0"));
    CHECK_THAT(ogden("mu_Pa = [1]\nalpha = [51]"), Contains("key 'material.alpha'") && Contains("50"));
    CHECK_THAT(ogden("mu_Pa = [1]\nalpha = [-2]"), Contains("key 'material.mu_Pa'") && Contains("> 0"));
    CHECK_THAT(ogden("mu_Pa = [1]\nalpha = [2]\nregions = { a = { mu_Pa = [1, 1], alpha = [2, 2] } }"),
               Contains("regions.a.alpha") && Contains("base material"));
    CHECK_THAT(refusal<StudyError>([&] {
                   example_study(with(example_study_text(), "[lattice]", "[material.regions]\na = { C1_Pa = 1, C2_Pa = 1 }\n\n[lattice]"));
               }),
               Contains("key 'material.regions'") && Contains("geometry.shape"));
    const std::string patch = with(with(shape_text(), "kind = \"point\"", "kind = \"patch\"\nhalf_width_m = 0.005"), "refine = 1", "refine = 1");
    CHECK_THAT(refusal<StudyError>([&] { read(patch); }), Contains("key 'mesh.refine'") && Contains("half_width_m"));
}
