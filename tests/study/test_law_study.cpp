#include <catch2/catch.hpp>

#include "cases/plan.h"
#include "cases/sweep.h"
#include "error.h"
#include "../example.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

std::string law_text(const std::string& springs = "", const std::string& training = "") {
    const std::string& sets = example_study_text();
    return sets.substr(0, sets.find("[springs]")) +
           "[springs]\ntopology = \"grid8\"\nstiffness = \"law\"\nterms = [\"spring.all\", \"contact.normal\"]\n" + springs +
           "[training]\n" + training;
}

std::string said(const std::string& text) {
    return refusal<StudyError>([&] { example_study(text); });
}

}  // namespace

TEST_CASE("a study's stiffness is sets, or a law with terms and defaults for all else", "[law]") {
    CHECK(example_study().springs.stiffness == "sets");
    const Study study = example_study(law_text());
    CHECK(study.springs.is_law());
    CHECK(study.springs.terms == std::vector<std::string>{"spring.all", "contact.normal"});
    CHECK(study.springs.area_cap_E2 == 12);
    CHECK(study.training.force_scale == 0.01);
    CHECK(study.training.shape_scale == 0.03);
    CHECK(study.training.ridge == 0.1);
    CHECK(study.training.starts == 1);
    CHECK(example_study(law_text("area_cap_E2 = 6\n", "starts = 3\nridge = 0\n")).training.starts == 3);
}

TEST_CASE("keys of sets are refused beside a law, and a law's beside sets, by name", "[law]") {
    CHECK_THAT(said(law_text("law = \"axial\"\n")), Contains("springs.law"));
    CHECK_THAT(said(law_text("", "optimizer = \"exact\"\n")), Contains("training.optimizer") && Contains("sets"));
    CHECK_THAT(said(law_text("", "k_min_E2 = 0.05\n")), Contains("training.k_min_E2"));
    CHECK_THAT(said(law_text("area_cap_E2 = 0.3\n")), Contains("springs.area_cap_E2"));
    CHECK_THAT(said(law_text("", "force_scale = 0\n")), Contains("training.force_scale"));
    CHECK_THAT(said(law_text("", "starts = 0\n")), Contains("training.starts"));
    CHECK_THAT(said(law_text("", "depth = 1\n")), Contains("depth"));
    CHECK_THAT(said(with(law_text(), "\"contact.normal\"", "\"spring.all\"")), Contains("springs.terms") && Contains("twice"));
    CHECK_THAT(said(with(law_text(), "grid8", "grid4")), Contains("springs.topology"));
    const std::string& sets = example_study_text();
    CHECK_THAT(said(with(sets, "law = \"axial\"", "law = \"axial\"\nterms = [\"spring.all\"]")), Contains("springs.terms"));
    CHECK_THAT(said(with(sets, "seed = 11", "seed = 11\nforce_scale = 0.01")), Contains("training.force_scale"));
}

TEST_CASE("a term that is not possible on the study's mesh is refused when it is planned, before FE", "[law]") {
    const Study study = example_study(with(law_text(), "contact.normal", "contact.twist"));
    CHECK_THAT(refusal<StudyError>([&] { make_plan(study); }), Contains("springs.terms") && Contains("contact.twist"));
    CHECK_THAT(make_plan(example_study(law_text())).parts.at("train"), Contains("terms spring.all contact.normal"));
}

TEST_CASE("a law put over a study of sets takes its keys away, and listed contacts its spacing", "[law]") {
    const Study quick = read_study("fem/studies/surface-quick.toml");
    CHECK(quick.springs.is_law());
    CHECK(quick.variants.empty());
    const std::vector<PlannedPath> paths = planned_paths(quick);
    int trained = 0;
    for (const PlannedPath& p : paths) trained += p.role == "train";
    CHECK(trained == 5);

    const TemporaryFolder folder;
    folder.file("base.toml", law_text());
    const Study back = read_study(folder.file("sets.toml", "based_on = \"base\"\n[springs]\nstiffness = \"sets\"\nlaw = \"axial\"\n"
                                                           "[training]\noptimizer = \"exact\"\nalso = []\nseed = 1\niterations = 1\nk_min_E2 = 0.05\n"
                                                           "k_max_E2 = 40.0\nweight_near = [1, 1]\nweight_far = [1, 1]\n"));
    CHECK_FALSE(back.springs.is_law());
}

TEST_CASE("listed contacts stand for their mirror images: drawn ones keep away from both", "[law]") {
    Study study = read_study("fem/studies/surface-quick.toml");
    study.draws[0].count = 400;
    study.draws[0].max_angle_deg = 4;  // nearer than 5 degrees to straight in: places alone tell them apart
    const double length = 2 * study.geometry.height_m + study.geometry.width_m;
    for (const PlannedPath& p : planned_paths(study)) {
        if (p.role != study.draws[0].role) continue;
        const double arc = p.push.contact_m.x() >= 0.1 ? p.push.contact_m.y()
                           : p.push.contact_m.x() <= 0 ? length - p.push.contact_m.y()
                                                       : 0.1 + (0.1 - p.push.contact_m.x());
        for (double listed : study.loads.sweep->arcs_m)
            for (double place : {listed, length - listed}) CHECK(std::abs(arc - place) > 0.00199);
    }
    study.loads.sweep->arcs_m = {0.01};
    CHECK_THAT(refusal<MismatchError>([&] { planned_paths(study); }), Contains("arcs_m") && Contains("clearance_m"));
}
