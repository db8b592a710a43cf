#include "cases/plan.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <set>
#include <sstream>

#include "../example.h"
#include "../solid_example.h"
#include "../refusal.h"
#include "error.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// Parts of the plan that differ between the example and the example with one change.
std::set<std::string> changed(const std::string& from, const std::string& to) {
    const Plan before = make_plan(example_study()), after = make_plan(example_study(with(example_study_text(), from, to)));
    std::set<std::string> names;
    for (const auto& [name, text] : before.parts)
        if (!after.parts.count(name) || after.parts.at(name) != text) names.insert(name);
    for (const auto& [name, text] : after.parts)
        if (!before.parts.count(name)) names.insert(name);
    return names;
}

using Names = std::set<std::string>;

/// The number that follows "-NAME" in a part.
double argument(const std::string& part, const std::string& name) {
    std::istringstream words(part);
    for (std::string word; words >> word;)
        if (word == "-" + name) {
            words >> word;
            char* end = nullptr;
            const double value = std::strtod(word.c_str(), &end);
            REQUIRE(*end == '\0');
            return value;
        }
    FAIL("no argument -" << name);
    return 0;
}

bool same_bits(double a, double b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

TEST_CASE("the plan has parts for mesh and collect and train and one part per load path") {
    const Plan plan = make_plan(example_study());
    Names names;
    for (const auto& part : plan.parts) names.insert(part.first);
    CHECK(names == Names{"collect", "mesh", "path-corner", "path-left", "train"});
    for (const char* path : {"left", "corner"})
        CHECK_THAT(plan.fragment, Contains(std::string("$(R)/cases/") + path + ".csv: $(R)/plan/path-" + path));
    for (const char* line : {"PATHS := left corner\n", "$(R)/mesh.msh: $(R)/plan/mesh\n", "$(R)/cases.h5: $(R)/plan/collect\n",
                             "$(R)/model.h5: $(R)/plan/train\n"})
        CHECK_THAT(plan.fragment, Contains(line));
}

TEST_CASE("a first model has eight paths spread over the training paths or all of fewer") {
    CHECK_THAT(make_plan(example_study()).fragment, Contains("TRAINED := left corner\nFIRST_TRAINED := left corner\nTRAINED_MADE_OF := $(R)/mesh.msh\n"));
    const std::string corner = "  { name = \"corner\", contact_m = [0.1, 0.1], push = [-3, -1] },\n";
    std::string more = corner;
    for (int k = 0; k < 18; ++k) more += fmt::format("  {{ name = \"p{:02}\", contact_m = [0.0, 0.05], push = [1, {}] }},\n", k, 0.01 * (k + 1));
    const Plan plan = make_plan(example_study(with(example_study_text(), corner, more)));
    CHECK_THAT(plan.fragment, Contains("FIRST_TRAINED := left p00 p03 p05 p08 p10 p13 p15\n"));
}

TEST_CASE("names with characters that make or the shell would interpret are refused by key") {
    Study s = example_study();
    for (const char* name : {"a b", "$(shell touch pwned)", "a;b", "a'b", "a\"b", "a`b`", "a#b", "a:b", "a%b", "a\nb", "-n", ""}) {
        CAPTURE(name);
        Study named = s;
        named.name = name;
        CHECK_THAT(refusal<StudyError>([&] { make_plan(named); }), Contains("make does not support"));
        Study shaped = s;
        shaped.geometry.shape = std::string("fem/") + (*name ? name : " ") + ".geo";
        if (*name != '-') CHECK_THAT(refusal<StudyError>([&] { make_plan(shaped); }), Contains("key 'geometry.shape'"));
    }
}

TEST_CASE("the same study gives the same plan") {
    const Plan a = make_plan(example_study()), b = make_plan(example_study());
    CHECK(a.fragment == b.fragment);
    CHECK(a.parts == b.parts);
}

TEST_CASE("changing the curve of springs in space changes the part train only") {
    const auto parts = [](const std::string& curve) { return make_plan(example_study(with(solid_study_text(), "stiffness = \"law\"", "stiffness = \"law\"\ncurve = \"" + curve + "\""))).parts; };
    auto hooke = parts("hooke");
    const auto material = parts("material");
    CHECK(hooke.at("train") != material.at("train"));
    hooke["train"] = material.at("train");
    CHECK(hooke == material);
}

TEST_CASE("changing training or spring settings or density changes the part train only") {
    CHECK(changed("seed = 11", "seed = 12") == Names{"train"});
    CHECK(changed("iterations = 200", "iterations = 201") == Names{"train"});
    CHECK(changed("iterations = 200", "iterations = 200\nmax_seconds = 3") == Names{"train"});
    CHECK(changed("iterations = 200", "iterations = 200\ntarget_rel_loss = 0.1") == Names{"train"});
    CHECK(changed("optimizer = \"spsa\"", "optimizer = \"spsa-2008\"") == Names{"train"});
    CHECK(changed("also = [\"spsa-2008\"]", "also = []") == Names{"train"});
    CHECK(changed("k_min_E2 = 0.05", "k_min_E2 = 0.06") == Names{"train"});
    CHECK(changed("k_max_E2 = 40.0", "k_max_E2 = 41.0") == Names{"train"});
    CHECK(changed("weight_near = [0.95, 0.99]", "weight_near = [0.95, 0.98]") == Names{"train"});
    CHECK(changed("weight_far = [0.80, 0.90]", "weight_far = [0.81, 0.90]") == Names{"train"});
    CHECK(changed("law = \"axial\"", "law = \"geometric\"") == Names{"train"});
    CHECK(changed("topology = \"grid8\"", "topology = \"grid4\"") == Names{"train"});
    CHECK(changed("density_kg_m3 = 1040.0", "density_kg_m3 = 1000.0") == Names{"train"});
}

TEST_CASE("changing direction or contact of one path changes the part of that path only") {
    CHECK(changed("push = [1, 0]", "push = [1, 0.5]") == Names{"path-left"});
    CHECK(changed("contact_m = [0.0, 0.05]", "contact_m = [0.0, 0.075]") == Names{"path-left"});
    CHECK(changed("push = [1, 0]", "push = [2, 0]").empty());  // only its direction counts
}

TEST_CASE("a new path or name or magnitude changes the parts that depend on it") {
    CHECK(changed("  { name = \"left\"", "  { name = \"top\", contact_m = [0.05, 0.1], push = [0, -1] },\n"
                                         "  { name = \"left\"") == Names{"collect", "path-top"});
    CHECK(changed("name = \"left\"", "name = \"west\"") == Names{"collect", "path-left", "path-west"});
    CHECK(changed("[0.004, 0.008]", "[0.006, 0.008]") == Names{"collect"});  // both are records already
    CHECK(changed("[0.004, 0.008]", "[0.004, 0.006]") == Names{"collect", "path-corner", "path-left"});
}

TEST_CASE("changing tissue or solver changes all paths and changing the refinement changes the mesh part") {
    const Names paths = {"path-corner", "path-left"};
    const auto and_also = [&](Names more) {
        more.insert(paths.begin(), paths.end());
        return more;
    };
    CHECK(changed("tolerance = 1e-10", "tolerance = 1e-9") == paths);
    CHECK(changed("max_newton = 12", "max_newton = 13") == paths);
    CHECK(changed("record_step_m = 0.002", "record_step_m = 0.001") == paths);
    CHECK(changed("C1_Pa = 263.0", "C1_Pa = 264.0") == and_also({"train"}));
    CHECK(changed("thickness_m = 0.0003", "thickness_m = 0.0004") == and_also({"train"}));
    CHECK(changed("refine = 1", "refine = 2") == Names{"mesh"});  // all paths depend on the mesh
    CHECK(changed("name = \"corner\"", "name =\"corner\"").empty());
    CHECK(changed("width_m = 0.1", "width_m = 0.1000").empty());  // the same number
}

TEST_CASE("the mesh of a block has the number of elements per cell of the study along both axes") {
    const std::string tall = with(example_study_text(), "cells = [4, 4]", "cells = [4, 6]");
    for (const int refine : {1, 3}) {
        const Study s = example_study(with(tall, "refine = 1", "refine = " + std::to_string(refine)));
        const std::string part = make_plan(s).parts.at("mesh");
        CHECK_THAT(part, Contains("-setnumber width 0.1 -setnumber height 0.1 "));
        CHECK_THAT(part, Contains(" -setnumber cells_x " + std::to_string(s.cells[0] * refine) + " -setnumber cells_y " + std::to_string(s.cells[1] * refine)));
    }
}

TEST_CASE("numbers in FreeFEM's arguments give the same bits when read back") {
    const std::string odd = with(with(example_study_text(), "thickness_m = 0.0003", "thickness_m = 0.00016666666666666667"),
                                 "C1_Pa = 263.0", "C1_Pa = 263.00000000000006");
    const Study s = example_study(odd);
    const Plan plan = make_plan(s);
    const std::string& part = plan.parts.at("path-corner");
    CHECK(same_bits(argument(part, "thickness"), s.geometry.thickness_m));
    CHECK(same_bits(argument(part, "width"), s.geometry.width_m));
    CHECK(same_bits(argument(part, "height"), s.geometry.height_m));
    CHECK(same_bits(argument(part, "C1"), s.material.C1_Pa));
    CHECK(same_bits(argument(part, "C2"), s.material.C2_Pa));
    CHECK(same_bits(argument(part, "contact_x"), s.loads.paths[1].contact_m.x()));
    CHECK(same_bits(argument(part, "contact_y"), s.loads.paths[1].contact_m.y()));
    CHECK(same_bits(argument(part, "direction_x"), s.loads.paths[1].direction.x()));  // -3/sqrt(10)
    CHECK(same_bits(argument(part, "direction_y"), s.loads.paths[1].direction.y()));
    CHECK(same_bits(argument(part, "depth"), s.loads.depth_m()));
    CHECK(same_bits(argument(part, "tolerance"), s.solver.tolerance));
    CHECK(argument(part, "records") == s.loads.records());
    CHECK(argument(part, "cells_x") == 4);
    CHECK_THAT(plan.fragment, Contains(part.substr(0, part.size() - 1)));  // make passes the arguments of the part
}
