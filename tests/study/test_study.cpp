#include "study/study.h"

#include <catch2/catch.hpp>
#include <algorithm>
#include <filesystem>

#include "error.h"
#include "../example.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;

namespace {

const std::string& text() {
    return example_study_text();
}

int line_of(const std::string& study, const std::string& what) {
    return 1 + static_cast<int>(std::count(study.begin(), study.begin() + static_cast<long>(study.find(what)), '\n'));
}

/// Refusal of the example study with one change.
std::string said(const std::string& from, const std::string& to) {
    const TemporaryFolder folder;
    const std::string file = folder.file("s.toml", with(text(), from, to));
    return refusal<StudyError>([&] { read_study(file); });
}

/// "s.toml:LINE: key 'KEY'", the place in a refusal; LINE is the line of `from`.
std::string place(const std::string& from, const std::string& key) {
    return "s.toml:" + std::to_string(line_of(text(), from)) + ": key '" + key + "'";
}

}  // namespace

TEST_CASE("a study has the values of its file") {
    const Study s = example_study();
    CHECK(s.name == "example");
    CHECK(s.geometry.thickness_m == 0.0003);
    CHECK(s.material.C2_Pa == 491.0);
    CHECK(s.cells[0] == 4);
    CHECK(s.solver.max_newton == 12);
    CHECK(s.loads.magnitudes_m == std::vector<double>{0.004, 0.008});
    CHECK(s.loads.records() == 4);
    CHECK(s.loads.depth_m() == 0.008);
    CHECK(s.loads.paths.at(1).name == "corner");
    CHECK(s.springs.topology == "grid8");
    CHECK(s.training.also == std::vector<std::string>{"spsa-2008"});
    CHECK(s.training.seed == 11);
    CHECK_FALSE(s.training.max_seconds);
    CHECK(s.training.weight_far[1] == 0.90);
}

TEST_CASE("small-strain moduli of the study are E = 6 (C1 + C2) and E2 = E t") {
    const Study s = example_study();
    CHECK(s.material.youngs_modulus_Pa() == Approx(4524).epsilon(tolerance::rounding));
    CHECK(s.modulus_N_m() == Approx(4524 * 0.0003).epsilon(tolerance::rounding));
}

TEST_CASE("the direction of a path is normalised when a study is read") {
    const Study s = example_study();
    CHECK(s.loads.paths.at(1).direction.norm() == Approx(1).epsilon(tolerance::rounding));
    CHECK(s.loads.paths.at(1).direction.x() == Approx(-3 / std::sqrt(10.0)).epsilon(tolerance::rounding));
}

TEST_CASE("stop criteria of Fig. 5 are optional keys") {
    const Study s =
        example_study(with(text(), "iterations = 200", "iterations = 7\nmax_seconds = 2.5\ntarget_rel_loss = 0.01"));
    CHECK(s.training.iterations == 7);
    CHECK(s.training.max_seconds == 2.5);
    CHECK(s.training.target_rel_loss == 0.01);
}

TEST_CASE("a derived study replaces the keys it gives and whole lists and keeps the rest") {
    const TemporaryFolder folder;
    folder.file("base.toml", text());
    const Study base = read_study(folder.file("base.toml"));
    const Study s = read_study(folder.file("derived.toml", "based_on = \"base\"\n[springs]\nlaw = \"isotropic\"\n"
                                                           "[loads]\nmagnitudes_m = [0.006]\n"));
    CHECK(s.name == "derived");
    CHECK(s.springs.law == "isotropic");
    CHECK(s.springs.topology == base.springs.topology);
    CHECK(s.loads.magnitudes_m == std::vector<double>{0.006});
    CHECK(s.loads.paths.size() == base.loads.paths.size());
    const Study third = read_study(folder.file("third.toml", "based_on = \"derived\"\n"));
    CHECK(third.springs.law == "isotropic");
}

TEST_CASE("the committed studies are valid and the study of the paper has 18 cases and 0.754 N/m") {
    const std::vector<std::string> organs{"brain", "kidney", "liver", "spleen"};
    int studies = 0;
    for (const auto& entry : std::filesystem::directory_iterator("fem/studies")) {
        if (entry.path().extension() != ".toml") continue;
        // provided by the user (fem/organs/README.md)
        const std::filesystem::path brought = std::filesystem::path("fem/organs") / (entry.path().stem().string() + ".stl");
        if (std::find(organs.begin(), organs.end(), entry.path().stem()) != organs.end() && !std::filesystem::exists(brought)) {
            CHECK_THAT(refusal<StudyError>([&] { read_study(entry.path().string()); }),
                       Contains("key 'geometry.shape': there is no file " + brought.string() + "; fem/organs/README.md states where to get it"));
            continue;
        }
        const Study s = read_study(entry.path().string());
        CHECK(s.name == entry.path().stem());
        ++studies;
    }
    CHECK(studies >= 2);
    const Study paper = read_study("fem/studies/paper.toml");
    CHECK(paper.loads.paths.size() * paper.loads.magnitudes_m.size() == 18);
    CHECK(paper.modulus_N_m() == Approx(0.754).epsilon(tolerance::rounding));
}

TEST_CASE("an unknown key in any table is refused with its place and the allowed keys") {
    CHECK_THAT(said("height_m = 0.1", "height_m = 0.1\nheigth_m = 0.1"),
               Contains("s.toml:4: key 'geometry.heigth_m'") && Contains("allowed: height_m, thickness_m, width_m"));
    CHECK_THAT(said("[mesh]", "[mehs]\nx = 1\n[mesh]"), Contains("key 'mehs'") && Contains("allowed: "));
    CHECK_THAT(said("push = [1, 0] }", "push = [1, 0], speed = 3 }"),
               Contains(place("\"left\"", "loads.paths[0].speed")) && Contains("allowed: contact_m, name, push"));
    for (const char* table : {"material", "lattice", "mesh", "indenter", "solver", "loads", "springs", "training"}) {
        const std::string head = "[" + std::string(table) + "]";
        CHECK_THAT(said(head, head + "\nbogus = 1"), Contains(table + std::string(".bogus")) && Contains("allowed: "));
    }
}

TEST_CASE("a missing key or table is refused by name") {
    CHECK_THAT(said("C1_Pa = 263.0\n", ""), Contains("s.toml:") && Contains("key 'material.C1_Pa': is missing"));
    CHECK_THAT(said("[indenter]\nkind = \"point\"\n", ""), Contains("s.toml:") && Contains("key 'indenter': is missing"));
    CHECK_THAT(said("name = \"left\", ", ""), Contains("key 'loads.paths[0].name': is missing"));
}

TEST_CASE("values out of range are refused with their place and the allowed values") {
    const auto refused = [](const std::string& from, const std::string& to, const std::string& key,
                            const std::string& allowed) {
        INFO(to);
        CHECK_THAT(said(from, to), Contains(place(from, key)) && Contains(allowed));
    };
    refused("thickness_m = 0.0003", "thickness_m = -0.0003", "geometry.thickness_m", "a number > 0");
    refused("thickness_m = 0.0003", "thickness_m = 0", "geometry.thickness_m", "a number > 0");
    refused("thickness_m = 0.0003", "thickness_m = nan", "geometry.thickness_m", "a number > 0");
    refused("width_m = 0.1", "width_m = inf", "geometry.width_m", "a number > 0");
    refused("C2_Pa = 491.0", "C2_Pa = -1.0", "material.C2_Pa", "a number >= 0");
    refused("law = \"mooney-rivlin\"", "law = \"rubber\"", "material.law", "mooney-rivlin");
    refused("law = \"axial\"", "law = \"elastic\"", "springs.law", "isotropic, axial, geometric");
    refused("topology = \"grid8\"", "topology = \"grid9\"", "springs.topology", "grid4, grid8");
    refused("kind = \"point\"", "kind = \"ball\"", "indenter.kind", "point");
    refused("formulation = \"plane-stress\"", "formulation = \"shell\"", "material.formulation", "plane-stress");
    refused("cells = [4, 4]", "cells = [4, 0]", "lattice.cells", "a number >= 1");
    refused("cells = [4, 4]", "cells = [4, 4.5]", "lattice.cells", "whole numbers");
    refused("cells = [4, 4]", "cells = [4, 4, 4]", "lattice.cells", "2 numbers");
    refused("cells = [4, 4]", "cells = [400, 400]", "lattice.cells", "at most 100000");
    refused("record_step_m = 0.002", "record_step_m = 2e-10", "loads.record_step_m", "at most 10000");
    refused("[0.004, 0.008]", "[0.004, 0.102]", "loads.magnitudes_m", "the block's length of 100 mm");
    refused("refine = 1", "refine = 0", "mesh.refine", "an integer from 1");
    refused("tolerance = 1e-10", "tolerance = 1", "solver.tolerance", "a number >= ");
    refused("seed = 11", "seed = -1", "training.seed", "an integer from 0");
    refused("iterations = 200", "iterations = 0", "training.iterations", "an integer from 1");
    refused("k_min_E2 = 0.05", "k_min_E2 = 0.6", "training.k_min_E2", "at most 0.5");
    refused("k_max_E2 = 40.0", "k_max_E2 = 0.9", "training.k_max_E2", "at least 1");
    refused("weight_near = [0.95, 0.99]", "weight_near = [0.95, 1.2]", "training.weight_near", "<= 1");
    refused("weight_far = [0.80, 0.90]", "weight_far = [0.90, 0.80]", "training.weight_far", "[smallest, largest]");
}

TEST_CASE("one Mooney-Rivlin constant may be zero but not both") {
    const std::string soft = with(text(), "C1_Pa = 263.0", "C1_Pa = 0.0");
    CHECK(example_study(soft).material.C1_Pa == 0);
    const TemporaryFolder folder;
    const std::string file = folder.file("s.toml", with(soft, "C2_Pa = 491.0", "C2_Pa = 0.0"));
    CHECK_THAT(refusal<StudyError>([&] { read_study(file); }), Contains("material.C1_Pa") && Contains("> 0"));
    CHECK(example_study(with(text(), "C2_Pa = 491.0", "C2_Pa = 0.0")).material.C2_Pa == 0);
}

TEST_CASE("the neo-Hookean law accepts no C2 but zero") {
    const std::string law = with(text(), "law = \"mooney-rivlin\"", "law = \"neo-Hookean\"");
    CHECK(example_study(with(law, "C2_Pa = 491.0", "C2_Pa = 0.0")).material.law == "neo-Hookean");
    CHECK_THAT(said("law = \"mooney-rivlin\"", "law = \"neo-Hookean\""), Contains("key 'material.C2_Pa'"));
}

TEST_CASE("a patch keeps its clearance from the fixed edge and a point has no half width") {
    const std::string patch = with(text(), "kind = \"point\"", "kind = \"patch\"\nhalf_width_m = 0.005");
    CHECK(example_study(patch).indenter.half_width_m == 0.005);
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& study) {
        const std::string file = folder.file("s.toml", study);
        return refusal<StudyError>([&] { read_study(file); });
    };
    const std::string low = with(patch, "contact_m = [0.0, 0.05]", "contact_m = [0.0, 0.0149]");
    CHECK_THAT(refused(low), Contains("loads.paths[0].contact_m") && Contains("fixed edge") && Contains("15 mm"));
    CHECK(example_study(with(patch, "contact_m = [0.0, 0.05]", "contact_m = [0.0, 0.015]")).loads.paths.size() == 2);
    const auto at = [&](const std::string& half_width_m, const std::string& y_m) {
        return with(with(with(text(), "kind = \"point\"", "kind = \"patch\"\nhalf_width_m = " + half_width_m), "refine = 1", "refine = 20"),
                    "contact_m = [0.0, 0.05]", "contact_m = [0.0, " + y_m + "]");
    };
    CHECK(example_study(at("0.003", "0.009")).loads.paths.size() == 2);
    CHECK_THAT(refused(at("0.003", "0.0089")), Contains("a patch of half width 3 mm needs 9 mm"));
    CHECK(example_study(at("0.010", "0.015")).loads.paths.size() == 2);
    CHECK_THAT(refused(at("0.018", "0.0179")), Contains("a patch of half width 18 mm needs 18 mm"));
    CHECK_THAT(refused(with(text(), "kind = \"point\"", "kind = \"patch\"")), Contains("indenter.half_width_m"));
    CHECK_THAT(refused(with(text(), "kind = \"point\"", "kind = \"patch\"\nhalf_width_m = -1")),
               Contains("indenter.half_width_m") && Contains("> 0"));
    CHECK_THAT(refused(with(text(), "kind = \"point\"", "kind = \"point\"\nhalf_width_m = 0.005")),
               Contains("indenter.half_width_m") && Contains("not known"));
}

TEST_CASE("an odd number of elements along x is refused because its mesh is not symmetric") {
    CHECK_THAT(said("cells = [4, 4]", "cells = [5, 4]"), Contains("mesh.refine") && Contains("even"));
    CHECK(example_study(with(with(text(), "cells = [4, 4]", "cells = [5, 4]"), "refine = 1", "refine = 2")).refine == 2);
}

TEST_CASE("a value of the wrong type is refused with its line and key") {
    CHECK_THAT(said("width_m = 0.1", "width_m = \"wide\""), Contains(place("width_m", "geometry.width_m")));
    CHECK_THAT(said("seed = 11", "seed = 1.5"), Contains(place("seed", "training.seed")) && Contains("integer"));
    CHECK_THAT(said("kind = \"point\"", "kind = 3"), Contains(place("kind", "indenter.kind")) && Contains("text"));
    CHECK_THAT(said("also = [\"spsa-2008\"]", "also = \"spsa-2008\""),
               Contains(place("also", "training.also")) && Contains("list of texts"));
    CHECK_THAT(said("also = [\"spsa-2008\"]", "also = [1]"), Contains("list of texts"));
    CHECK_THAT(said("magnitudes_m = [0.004, 0.008]", "magnitudes_m = 0.004"),
               Contains(place("magnitudes_m", "loads.magnitudes_m")) && Contains("list of numbers"));
    CHECK_THAT(said("magnitudes_m = [0.004, 0.008]", "magnitudes_m = []"), Contains("list of numbers"));
    CHECK_THAT(said("magnitudes_m = [0.004, 0.008]", "magnitudes_m = [0.004, \"deep\"]"), Contains("every entry"));
    CHECK_THAT(said("[indenter]\nkind = \"point\"", "[[indenter]]\nkind = \"point\""), Contains("must be a table"));
    CHECK_THAT(said("contact_m = [0.0, 0.05]", "contact_m = [0.0]"), Contains("loads.paths[0].contact_m"));
}

TEST_CASE("load paths with an invalid contact or direction or name or magnitude are refused by key") {
    CHECK_THAT(said("contact_m = [0.0, 0.05]", "contact_m = [0.01, 0.05]"),
               Contains(place("\"left\"", "loads.paths[0].contact_m")) && Contains("not on the free surface"));
    CHECK_THAT(said("contact_m = [0.0, 0.05]", "contact_m = [0.05, 0.0]"), Contains("not on the free surface"));
    CHECK_THAT(said("contact_m = [0.0, 0.05]", "contact_m = [0.0, 0.0]"), Contains("not on the free surface"));
    CHECK_THAT(said("contact_m = [0.0, 0.05]", "contact_m = [0.05, 0.11]"), Contains("not on the free surface"));
    CHECK_THAT(said("push = [1, 0]", "push = [0, 0]"), Contains("loads.paths[0].push") && Contains("zero"));
    CHECK_THAT(said("name = \"corner\"", "name = \"left\""), Contains("loads.paths[1].name") && Contains("twice"));
    CHECK_THAT(said("name = \"left\"", "name = \"../left\""), Contains("loads.paths[0].name") && Contains("lower-case"));
    CHECK_THAT(said("name = \"left\"", "name = \"\""), Contains("loads.paths[0].name"));
    CHECK_THAT(said("[0.004, 0.008]", "[0.008, 0.004]"), Contains("loads.magnitudes_m") && Contains("ascending"));
    CHECK_THAT(said("[0.004, 0.008]", "[0.004, 0.0085]"), Contains("loads.magnitudes_m") && Contains("record_step_m"));
    CHECK_THAT(said("[0.004, 0.008]", "[-0.004, 0.008]"), Contains("loads.magnitudes_m") && Contains("> 0"));
}

TEST_CASE("invalid values of a sweep and of its draws are refused by key") {
    const std::size_t from = text().find("paths = ["), to = text().find("[springs]");
    const std::string swept = text().substr(0, from) +
                              "[loads.sweep]\nspacing_m = 0.025\nclearance_m = 0.02\nangles_deg = [-30, 0, 30]\n\n[draws]\n"
                              "held_out = { seed = 5, count = 4, depth_m = [0.002, 0.008], max_angle_deg = 30 }\n"
                              "validation = { seed = 6, count = 4, depth_m = [0.002, 0.008], max_angle_deg = 30 }\n\n" +
                              text().substr(to);
    CHECK(example_study(swept).draws.size() == 2);
    const auto refused = [&](const std::string& what, const std::string& now, const std::string& key) {
        const TemporaryFolder folder;
        const std::string file = folder.file("s.toml", with(swept, what, now));
        INFO(now);
        CHECK_THAT(refusal<StudyError>([&] { read_study(file); }), Contains("s.toml:") && Contains("key '" + key + "'"));
    };
    refused("clearance_m = 0.02", "clearance_m = 0.01", "loads.sweep.clearance_m");
    refused("spacing_m = 0.025", "spacing_m = 0", "loads.sweep.spacing_m");
    refused("angles_deg = [-30, 0, 30]", "angles_deg = [-30, 0, 20]", "loads.sweep.angles_deg");
    refused("angles_deg = [-30, 0, 30]", "angles_deg = [30, 0, -30]", "loads.sweep.angles_deg");
    refused("angles_deg = [-30, 0, 30]", "angles_deg = [-80, 80]", "loads.sweep.angles_deg");
    refused("seed = 6", "seed = 5", "draws.held_out.seed");
    refused("held_out = { seed = 5, count = 4, depth_m = [0.002, 0.008]",
            "held_out = { seed = 5, count = 4, depth_m = [0.002, 0.009]", "draws.held_out.depth_m");
    refused("held_out = { seed = 5, count = 4,", "held_out = { seed = 5, count = 0,", "draws.held_out.count");
    refused("held_out = {", "proof = {", "draws.proof");
}

TEST_CASE("malformed TOML is refused in one line with file and line number") {
    const std::string broken = with(text(), "height_m = 0.1", "height_m = = 0.1");
    const TemporaryFolder folder;
    const std::string file = folder.file("s.toml", broken);
    CHECK_THAT(refusal<StudyError>([&] { read_study(file); }), Contains("s.toml:3"));
    CHECK_THAT(refusal<StudyError>([&] { read_study(folder.file("t.toml", "[geometry\nwidth_m = 1")); }),
               Contains("t.toml:1"));
    CHECK_THAT(refusal<StudyError>([&] { read_study(folder.file("u.toml", "a = 1\na = 2\n")); }), Contains("u.toml:2"));
    CHECK_THAT(refusal<StudyError>([&] { read_study(folder.file("b.toml", std::string("\x00\xff\xfe\x7f", 4))); }),
               Contains("b.toml:1"));
}

TEST_CASE("a missing study file and a folder are refused") {
    const TemporaryFolder folder;
    CHECK_THAT(refusal<FileError>([&] { read_study(folder.file("none.toml")); }), Contains("none.toml"));
    CHECK_THROWS_AS(read_study(folder.file("")), FileError);
    CHECK_THAT(refusal<FileError>([&] { read_study(folder.file("d.toml", "based_on = \"gone\"\n")); }),
               Contains("gone.toml"));
}

TEST_CASE("studies based on each other in a circle or on a number are refused by key") {
    const TemporaryFolder folder;
    folder.file("a.toml", "# first\nbased_on = \"b\"\n");
    folder.file("b.toml", "based_on = \"a\"\n");
    CHECK_THAT(refusal<StudyError>([&] { read_study(folder.file("a.toml")); }),
               Contains(".toml:") && Contains("based_on") && Contains("circle"));
    CHECK_THAT(refusal<StudyError>([&] { read_study(folder.file("c.toml", "based_on = 3\n")); }),
               Contains("c.toml:1: key 'based_on'"));
}

TEST_CASE("an invalid key of a derived study or its base is refused with its own file and line") {
    const TemporaryFolder folder;
    folder.file("base.toml", text());
    const auto derived = [&](const std::string& change) {
        const std::string file = folder.file("derived.toml", "based_on = \"base\"\n\n" + change);
        return refusal<StudyError>([&] { read_study(file); });
    };
    CHECK_THAT(derived("[springs]\nlaw = \"elastic\"\n"), Contains("derived.toml:4: key 'springs.law'"));
    CHECK_THAT(derived("[springs]\nlow = \"axial\"\n"), Contains("derived.toml:4: key 'springs.low'"));
    CHECK_THAT(derived("[haptics]\nx = 1\n"), Contains("derived.toml:3: key 'haptics'"));
    CHECK_THAT(derived("[loads]\npaths = [\n{ name = \"x\", contact_m = [9, 9], push = [1, 0] }]\n"),
               Contains("derived.toml:5: key 'loads.paths[0].contact_m'"));
    folder.file("base.toml", with(text(), "C1_Pa = 263.0", "C1_Pa = -263.0"));
    CHECK_THAT(derived("[springs]\nlaw = \"axial\"\n"), Contains("base.toml:8: key 'material.C1_Pa'"));
}

TEST_CASE("an unknown optimiser is refused when the study is read") {
    CHECK_THAT(said("optimizer = \"spsa\"", "optimizer = \"adam\""), Contains("training.optimizer") && Contains("adam"));
    CHECK_THAT(said("also = [\"spsa-2008\"]", "also = [\"adam\"]"), Contains("training.also") && Contains("adam"));
}
