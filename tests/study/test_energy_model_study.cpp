#include <catch2/catch.hpp>
#include <filesystem>

#include "cases/plan.h"
#include "cases/sweep.h"
#include "error.h"
#include "../example.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

std::string energy_model_text(const std::string& springs = "", const std::string& training = "") {
    const std::string& sets = example_study_text();
    return sets.substr(0, sets.find("[springs]")) +
           "[springs]\ntopology = \"grid8\"\nstiffness = \"law\"\nterms = [\"spring.all\", \"contact.normal\"]\n" + springs +
           "[training]\n" + training;
}

std::string said(const std::string& text) {
    return refusal<StudyError>([&] { example_study(text); });
}

/// First line of a study based on `surface-quick`.
std::string quick() {
    return "based_on = \"" + (std::filesystem::current_path() / "fem/studies/surface-quick").string() + "\"\n";
}

}  // namespace

TEST_CASE("a study has spring sets or an energy model with terms and default values", "[law]") {
    CHECK(example_study().springs.stiffness == "sets");
    const Study study = example_study(energy_model_text());
    CHECK(study.springs.is_energy_model());
    CHECK(study.springs.terms == std::vector<std::string>{"spring.all", "contact.normal"});
    CHECK(study.springs.area_cap_E2 == 12);
    CHECK(study.training.force_scale == 0.01);
    CHECK(study.training.shape_scale == 0.03);
    CHECK(study.training.ridge == 0.1);
    CHECK(study.training.starts == 1);
    CHECK(example_study(energy_model_text("area_cap_E2 = 6\n", "starts = 3\nridge = 0\n")).training.starts == 3);
}

TEST_CASE("keys of spring sets are refused with an energy model and the reverse", "[law]") {
    CHECK_THAT(said(energy_model_text("law = \"axial\"\n")), Contains("springs.law"));
    CHECK_THAT(said(energy_model_text("", "optimizer = \"exact\"\n")), Contains("training.optimizer") && Contains("sets"));
    CHECK_THAT(said(energy_model_text("", "k_min_E2 = 0.05\n")), Contains("training.k_min_E2"));
    CHECK_THAT(said(energy_model_text("area_cap_E2 = 0.3\n")), Contains("springs.area_cap_E2"));
    CHECK_THAT(said(energy_model_text("", "force_scale = 0\n")), Contains("training.force_scale"));
    CHECK_THAT(said(energy_model_text("", "starts = 0\n")), Contains("training.starts"));
    CHECK_THAT(said(energy_model_text("", "depth = 1\n")), Contains("depth"));
    CHECK_THAT(said(with(energy_model_text(), "\"contact.normal\"", "\"spring.all\"")), Contains("springs.terms") && Contains("twice"));
    CHECK_THAT(said(with(energy_model_text(), "grid8", "grid4")), Contains("springs.topology"));
    const std::string& sets = example_study_text();
    CHECK_THAT(said(with(sets, "law = \"axial\"", "law = \"axial\"\nterms = [\"spring.all\"]")), Contains("springs.terms"));
    CHECK_THAT(said(with(sets, "seed = 11", "seed = 11\nforce_scale = 0.01")), Contains("training.force_scale"));
}

TEST_CASE("a term that is impossible on the study's mesh is refused in planning", "[law]") {
    const Study study = example_study(with(energy_model_text(), "contact.normal", "contact.twist"));
    CHECK_THAT(refusal<StudyError>([&] { make_plan(study); }), Contains("springs.terms") && Contains("contact.twist"));
    CHECK_THAT(make_plan(example_study(energy_model_text())).parts.at("train"), Contains("terms spring.all contact.normal"));
}

TEST_CASE("an energy model in a derived study drops the keys of spring sets and the reverse", "[law]") {
    const Study quick = read_study("fem/studies/surface-quick.toml");
    CHECK(quick.springs.is_energy_model());
    CHECK(quick.variants.empty());
    const std::vector<PlannedPath> paths = planned_paths(quick);
    int trained = 0;
    for (const PlannedPath& p : paths) trained += p.role == "train";
    CHECK(trained == 5);

    const TemporaryFolder folder;
    folder.file("base.toml", energy_model_text());
    const Study back = read_study(folder.file("sets.toml", "based_on = \"base\"\n[springs]\nstiffness = \"sets\"\nlaw = \"axial\"\n"
                                                           "[training]\noptimizer = \"exact\"\nalso = []\nseed = 1\niterations = 1\nk_min_E2 = 0.05\n"
                                                           "k_max_E2 = 40.0\nweight_near = [1, 1]\nweight_far = [1, 1]\n"));
    CHECK_FALSE(back.springs.is_energy_model());
}

TEST_CASE("drawn contacts keep away from listed contacts and from their mirror images", "[law]") {
    Study study = read_study("fem/studies/surface-quick.toml");
    study.draws[0].count = 400;
    study.draws[0].max_angle_deg = 4;  // within 5 degrees of the normal, so that only the distance counts
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

TEST_CASE("variants of an energy model replace given keys and keep some contacts; sets have no variants", "[law]") {
    const auto said_of = [](const std::string& variant) {
        const TemporaryFolder folder;
        return refusal<StudyError>([&] {
            read_study(folder.file("try.toml", quick() + "[[variants]]\nname = \"try\"\n" + variant));
        });
    };
    const TemporaryFolder folder;
    const Study study = read_study(folder.file(
        "try.toml", quick() + "[[variants]]\nname = \"few\"\n"
                    "first_terms = 1\narcs_m = [0.040, 0.140]\nmagnitudes_m = [0.015]\narea_cap_E2 = 6.0\n"));
    REQUIRE(study.variants.size() == 1);
    const Study::Variant& few = study.variants[0];
    CHECK(few.terms == std::vector<std::string>{"spring.all"});
    CHECK(few.area_cap_E2 == 6);
    CHECK(few.shape_scale == study.training.shape_scale);
    CHECK(few.angles_deg == study.loads.sweep->angles_deg);

    CHECK_THAT(said_of("arcs_m = [0.041]"), Contains("arcs_m") && Contains("one of the study's"));
    CHECK_THAT(said_of("first_terms = 0"), Contains("first_terms"));
    CHECK_THAT(said_of("first_terms = 8"), Contains("first_terms"));
    CHECK_THAT(said_of("area_cap_E2 = 0.1"), Contains("area_cap_E2"));
    CHECK_THAT(said_of("law = \"axial\""), Contains("law"));
    CHECK_THAT(said(example_study_text() + "\n[[variants]]\nname = \"x\"\n"), Contains("variants") && Contains("energy model"));
    CHECK_THAT(said(energy_model_text() + "\n[[variants]]\nname = \"x\"\n"), Contains("variants") && Contains("loads.sweep"));
}

TEST_CASE("the cases of a variant are its training contacts with mirror images and every drawn contact", "[law]") {
    const Study study = read_study("fem/studies/surface-quick.toml");
    Cases cases;
    for (const PlannedPath& p : planned_paths(study)) {
        LoadPath path;
        path.name = p.push.name;
        path.role = p.role;
        path.contact_m = p.push.contact_m;
        path.direction = p.push.direction;
        cases.paths.push_back(path);
        if (p.role == "train") cases.paths.push_back(mirrored(path, NodeField(), study.geometry.width_m));
    }
    const Study::Variant few{"few", {"spring.all"}, 6, 0.03, {0.040, 0.140}, {0}, {0.015}};
    const Cases kept = thinned(study, cases, few);
    CHECK(kept.magnitudes_m == few.magnitudes_m);
    std::size_t trained = 0, drawn = 0;
    for (const LoadPath& p : kept.paths) (p.role == "train" ? trained : drawn) += 1;
    CHECK(trained == 4);
    CHECK(drawn == cases.paths.size() - 10);
    for (const LoadPath& p : kept.paths)
        if (p.role == "train") CHECK((std::abs(p.contact_m.y() - 0.040) < 1e-9 || std::abs(p.contact_m.x() - 0.05) < 0.0101));
}
