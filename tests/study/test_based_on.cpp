#include <fmt/format.h>
#include <fmt/ranges.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "../example.h"
#include "../refusal.h"
#include "error.h"
#include "study/based_on.h"
#include "study/study.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

std::string over(const std::string& study) {
    return "based_on = \"" + (std::filesystem::current_path() / "fem/studies" / study).string() + "\"\n";
}

std::string contents(const std::string& file) {
    std::ifstream in(file);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

}  // namespace

TEST_CASE("FORMATS lists the rules by which a derived study drops keys of its base", "[based_on]") {
    std::string rows = "<!-- begin based_on -->\n| where a study gives | these keys of its base do not count | because |\n|---|---|---|\n";
    for (const BaseRule& rule : base_rules())
        rows += fmt::format("| {} | `{}` | {} |\n", rule.given, fmt::join(rule.dropped, "`, `"), rule.why);
    rows += "<!-- end based_on -->\n";
    INFO("results/FORMATS.md must contain:\n" << rows);
    CHECK(contents("results/FORMATS.md").find(rows) != std::string::npos);
}

TEST_CASE("another material law in a derived study drops the parameters of the base", "[based_on]") {
    const TemporaryFolder folder;
    const Study soft = read_study(folder.file("soft.toml", over("surface-quick") + "[material]\nlaw = \"neo-Hookean\"\nC1_Pa = 2000\n"));
    CHECK(soft.material.C1_Pa == 2000);
    CHECK(soft.material.C2_Pa == 0);
    CHECK(soft.material.density_kg_m3 == 1040);  // keys without a rule are those of the base
    const Study ogden = read_study(folder.file("ogden.toml", "based_on = \"soft\"\n[material]\nlaw = \"ogden\"\nmu_Pa = [93.0]\nalpha = [18.0]\n"));
    CHECK(ogden.material.C1_Pa == 0);
    const Study back = read_study(folder.file("back.toml", "based_on = \"ogden\"\n[material]\nlaw = \"mooney-rivlin\"\nC1_Pa = 1\nC2_Pa = 2\n"));
    CHECK(back.material.mu_Pa.empty());
}

TEST_CASE("a derived study with a point drops the half width of its base", "[based_on]") {
    const TemporaryFolder folder;
    const Study point = read_study(folder.file("point.toml", over("surface-quick") + "[indenter]\nkind = \"point\"\n"));
    CHECK(point.indenter.kind == "point");
    CHECK(point.indenter.half_width_m == 0);
}

TEST_CASE("a derived study in space drops the plane tables of its base and the reverse", "[based_on]") {
    const TemporaryFolder folder;
    const auto said = [&](const std::string& text) { return refusal<StudyError>([&] { read_study(folder.file("s.toml", text)); }); };
    const std::string in_space = said(over("organ") + "[geometry]\nsolid = true\nfixed = [\"bed\"]\nshape = \"s.toml.msh\"\n");
    CHECK_THAT(in_space, Contains("s.toml:5: key 'geometry.shape'") && Contains("there is no file"));
    // the first table that a solid needs and that the base of the plane does not provide
    folder.file("s.toml.msh", "");
    CHECK_THAT(said(over("organ") + "[geometry]\nsolid = true\nfixed = [\"bed\"]\nshape = \"s.toml.msh\"\n"), Contains("s.toml:1: key 'indenter': is missing"));
    CHECK_THAT(said(over("block3") + "[geometry]\nthickness_m = 0.1\n[material]\nformulation = \"plane-strain\"\n[lattice]\ncells = [4, 4]\n"),
               Contains("s.toml:1: key 'mesh': is missing"));
}

TEST_CASE("measured data and a sweep and listed paths drop the other contacts of the base", "[based_on]") {
    const TemporaryFolder folder;
    const Study measured = read_study(folder.file("m.toml", over("surface") + "[data]\nfile = \"x.csv\"\nseed = 1\nvalidation_part = 0\nheld_out_part = 0.2\n"));
    CHECK(measured.data);
    CHECK(measured.draws.empty());
    CHECK(measured.variants.empty());
    const Study listed = read_study(folder.file("l.toml", over("surface") + "[loads]\npaths = [{ name = \"top\", contact_m = [0.05, 0.1], push = [0, -1] }]\n"));
    CHECK_FALSE(listed.loads.sweep);
    CHECK(listed.draws.empty());
    const Study swept = read_study(folder.file("w.toml", "based_on = \"l\"\n[loads.sweep]\nspacing_m = 0.02\nclearance_m = 0.015\nangles_deg = [0]\n"));
    CHECK(swept.loads.paths.empty());
}

TEST_CASE("a refusal names the file that has the key or the study if no file has it", "[based_on]") {
    const TemporaryFolder folder;
    folder.file("base.toml", with(example_study_text(), "C1_Pa = 263.0", "C1_Pa = -263.0"));
    const auto said = [&](const std::string& text) { return refusal<StudyError>([&] { read_study(folder.file("study.toml", text)); }); };
    CHECK_THAT(said("based_on = \"base\"\n"), Contains("base.toml:8: key 'material.C1_Pa'") && Contains("(base of "));
    // The base has no keys of spring sets. The study must give them, and has its own [training].
    CHECK_THAT(said(over("surface-quick") + "[springs]\nstiffness = \"sets\"\nlaw = \"axial\"\n[training]\nseed = 3\n"),
               Contains("study.toml:5: key 'training.optimizer': is missing"));
    // Without its own [training], the file with the rest of that table is named too.
    CHECK_THAT(said(over("surface-quick") + "[springs]\nstiffness = \"sets\"\nlaw = \"axial\"\n"),
               Contains("study.toml:1: key 'training.optimizer': is missing") && Contains("the other keys of 'training' are from"));
    CHECK_THAT(said(over("organ") + "[material]\npreset = \"gold\"\n"), Contains("study.toml:3: key 'material.preset': 'gold'"));
    // A study without a base must give every table.
    CHECK_THAT(said("[geometry]\nthickness_m = 1\nwidth_m = 1\nheight_m = 1\n"), Contains("study.toml:1: key 'material': is missing; give it, or base the study on one"));
}
