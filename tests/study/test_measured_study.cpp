#include <catch2/catch.hpp>
#include <filesystem>

#include "../measured_example.h"
#include "../refusal.h"
#include "cases/plan.h"
#include "error.h"
#include "study/study.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

std::string said(const std::string& from, const std::string& to) {
    return refusal<StudyError>([&] { make_plan(example_study(with(measured_study_text(), from, to))); });
}

}  // namespace

TEST_CASE("the data file of a measured study is relative to the study's folder", "[measured]") {
    const TemporaryFolder folder;
    const Study s = read_study(folder.file("s.toml", measured_study_text()));
    REQUIRE(s.data);
    CHECK(s.data->file == std::filesystem::path(folder.file("s.toml")).parent_path().parent_path() / "data/d.csv");
    CHECK(s.data->held_out_part == 0.2);
    CHECK(s.data->surface_tolerance_m == 0.0005);
    CHECK_FALSE(s.data->stated_force_noise);
    CHECK(s.loads.paths.empty());
}

TEST_CASE("keys of finite elements are refused in a study with measured data", "[measured]") {
    CHECK_THAT(said("[springs]", "[mesh]\nrefine = 1\n[springs]"), Contains("key 'mesh'") && Contains("[data]"));
    CHECK_THAT(said("[springs]", "[loads]\nmagnitudes_m = [0.01]\n[springs]"), Contains("key 'loads'"));
    CHECK_THAT(said("held_out_part = 0.2", "held_out_part = 0"), Contains("data.held_out_part"));
    CHECK_THAT(said("seed = 8", "seed = 8\nunits = \"mm\""), Contains("data.units") && Contains("not known"));
}

TEST_CASE("measured forces train an energy model and keys of displacement errors are refused", "[measured][law]") {
    const Study study = example_study(with(measured_study_text(), "ridge = 1e-6", "starts = 3"));
    CHECK(study.springs.is_energy_model());
    CHECK(study.training.force_scale == 0.01);
    CHECK(study.training.starts == 3);
    CHECK_THAT(said("ridge = 1e-6", "shape_scale = 0.03"), Contains("training.shape_scale") && Contains("displacements inside are not measured"));
    CHECK_THAT(said("ridge = 1e-6", "objective = \"contact\""), Contains("training.objective") && Contains("sets"));
    CHECK_THAT(said("\"spring.surface\"", "\"spring.depth\""), Contains("springs.terms") && Contains("spring.depth"));
}

TEST_CASE("spring sets with measured data are refused in one line with key and cause", "[measured]") {
    const auto check = [](const std::string& line) {
        CHECK_THAT(line, Contains("key 'springs.stiffness'") && Contains("\"law\" with [data]") && Contains("is not measured"));
        CHECK(line.find('\n') == std::string::npos);
    };
    check(said("stiffness = \"law\"", "stiffness = \"sets\""));
    check(said("stiffness = \"law\"", "law = \"axial\""));  // spring sets are the default

    const TemporaryFolder folder;
    folder.file("base.toml", measured_study_text());
    const std::string based = folder.file("s.toml", "based_on = \"base\"\n[springs]\nstiffness = \"sets\"\nlaw = \"axial\"\n");
    check(refusal<StudyError>([&] { read_study(based); }));
}

TEST_CASE("the plan of measured data imports them and has neither mesh nor load paths", "[measured]") {
    const TemporaryFolder folder;
    const auto plan_of = [&](const std::string& text) { return make_plan(read_study(folder.file("s.toml", text))); };
    const Plan plan = plan_of(measured_study_text());
    CHECK(plan.parts.size() == 2);
    CHECK_THAT(plan.fragment, Contains("$(R)/cases.h5: CASES_COMMAND = import ") && Contains("data/d.csv)\n") &&
                                  Contains("FIGURES := held_out\n") && !Contains("mesh") && Contains("PATHS :=\n"));
    const Plan other = plan_of(with(measured_study_text(), "seed = 8", "seed = 9"));
    CHECK(other.parts.at("collect") != plan.parts.at("collect"));
    CHECK(other.parts.at("train") == plan.parts.at("train"));
}
