#include <catch2/catch.hpp>
#include <filesystem>

#include "../example.h"
#include "../refusal.h"
#include "cases/plan.h"
#include "error.h"
#include "study/study.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// The example with measured data in place of all that finite elements need.
std::string measured_text() {
    const std::string& fe = example_study_text();
    const std::size_t from = fe.find("[mesh]"), to = fe.find("[springs]");
    const std::string data = "[data]\nfile = \"../data/d.csv\"\nseed = 8\nvalidation_part = 0.1\nheld_out_part = 0.2\n\n";
    return with(fe.substr(0, from) + data + fe.substr(to), "iterations = 200", "iterations = 200\nobjective = \"reaction\"");
}

std::string said(const std::string& from, const std::string& to) {
    const TemporaryFolder folder;
    const std::string file = folder.file("s.toml", with(measured_text(), from, to));
    return refusal<StudyError>([&] { read_study(file); });
}

}  // namespace

TEST_CASE("a study of measured data names its file from its own folder", "[measured]") {
    const TemporaryFolder folder;
    const Study s = read_study(folder.file("s.toml", measured_text()));
    REQUIRE(s.data);
    CHECK(s.data->file == std::filesystem::path(folder.file("s.toml")).parent_path().parent_path() / "data/d.csv");
    CHECK(s.data->held_out_part == 0.2);
    CHECK(s.data->surface_tolerance_m == 0.0005);
    CHECK_FALSE(s.data->stated_force_noise);
    CHECK(s.loads.paths.empty());
}

TEST_CASE("measured data and finite elements do not mix", "[measured]") {
    CHECK_THAT(said("[springs]", "[mesh]\nrefine = 1\n[springs]"), Contains("key 'mesh'") && Contains("[data]"));
    CHECK_THAT(said("[springs]", "[loads]\nmagnitudes_m = [0.01]\n[springs]"), Contains("key 'loads'"));
    CHECK_THAT(said("objective = \"reaction\"", "objective = \"contact\""), Contains("training.objective") && Contains("'reaction'"));
    CHECK_THAT(said("held_out_part = 0.2", "held_out_part = 0"), Contains("data.held_out_part"));
    CHECK_THAT(said("seed = 8", "seed = 8\nunits = \"mm\""), Contains("data.units") && Contains("not known"));
    const TemporaryFolder folder;
    const std::string fe = folder.file("s.toml", with(example_study_text(), "iterations = 200", "iterations = 200\nreach_m = 0.01"));
    CHECK_THAT(refusal<StudyError>([&] { read_study(fe); }), Contains("training.reach_m") && Contains("'reaction'"));
}

TEST_CASE("measured forces train a law as well as sets, and a law has no word on shapes then", "[measured][law]") {
    const TemporaryFolder folder;
    const std::string text = measured_text();
    const std::string law = text.substr(0, text.find("[springs]")) +
                            "[springs]\ntopology = \"grid8\"\nstiffness = \"law\"\nterms = [\"spring.all\", \"contact.normal\"]\n[training]\n";
    const Study study = read_study(folder.file("s.toml", law + "starts = 3\n"));
    CHECK(study.springs.is_law());
    CHECK(study.training.force_scale == 0.01);
    CHECK(study.training.starts == 3);
    CHECK_THAT(make_plan(study).fragment, Contains("CASES_COMMAND = import") && Contains("FIGURES := held_out\n"));
    const auto refused = [&](const std::string& training, const std::string& terms = "contact.normal") {
        return refusal<StudyError>([&] { make_plan(read_study(folder.file("s.toml", with(law, "contact.normal", terms) + training))); });
    };
    CHECK_THAT(refused("shape_scale = 0.03\n"), Contains("training.shape_scale") && Contains("nothing inside was measured"));
    CHECK_THAT(refused("objective = \"reaction\"\n"), Contains("training.objective") && Contains("sets"));
    CHECK_THAT(refused("reach_m = 0.004\n"), Contains("training.reach_m") && Contains("sets"));
    CHECK_THAT(refused("", "spring.depth"), Contains("springs.terms") && Contains("spring.depth"));
}

TEST_CASE("the plan of measured data imports them, and has neither mesh nor load paths", "[measured]") {
    const TemporaryFolder folder;
    const auto plan_of = [&](const std::string& text) { return make_plan(read_study(folder.file("s.toml", text))); };
    const Plan plan = plan_of(measured_text());
    CHECK(plan.parts.size() == 2);
    CHECK_THAT(plan.fragment, Contains("$(R)/cases.h5: CASES_COMMAND = import ") && Contains("data/d.csv)\n") &&
                                  !Contains("mesh") && !Contains("PATHS +="));
    CHECK(plan_of(with(measured_text(), "seed = 8", "seed = 9")).parts.at("collect") != plan.parts.at("collect"));
    CHECK(plan_of(with(measured_text(), "seed = 8", "seed = 9")).parts.at("train") == plan.parts.at("train"));
    for (const char* key : {"reach_m = 0.01", "one_set_ridge = 0.5"})
        CHECK(plan_of(with(measured_text(), "iterations = 200", std::string("iterations = 200\n") + key)).parts.at("train") !=
              plan.parts.at("train"));
}
