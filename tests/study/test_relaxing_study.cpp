#include <catch2/catch.hpp>
#include <filesystem>

#include "error.h"
#include "study/study.h"
#include "../example.h"
#include "../refusal.h"
#include "../solid_example.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// A study based on `surface-quick`, whose moduli are C1 = 263 Pa, C2 = 491 Pa; its tables begin at line 2.
std::string over_quick(const std::string& tables) {
    return "based_on = \"" + (std::filesystem::current_path() / "fem/studies/surface-quick").string() + "\"\n" + tables;
}

const std::string& branches() {
    static const std::string text = "[material]\nviscosity = [{ g = 0.3, tau_s = 1.0 }, { g = 0.25, tau_s = 0.05 }]\nmoduli = \"instantaneous\"\n";
    return text;
}

const std::string& groups() {
    static const std::string text = R"([[histories]]
name = "ramp"
kind = "ramp"
seed = 1
count = 2
depth_m = [0.002, 0.01]
max_angle_deg = 30
rise_s = [0.05, 1.0]
hold_s = 0.5
[[histories]]
name = "release"
kind = "release"
role = "validation"
seed = 2
count = 3
depth_m = [0.002, 0.01]
max_angle_deg = 30
rise_s = [0.06, 1.0]
hold_s = 0.6
[[histories]]
name = "sine"
kind = "sine"
role = "train"
seed = 3
count = 1
depth_m = [0.002, 0.01]
max_angle_deg = 30
frequency_Hz = [0.2, 5]
duration_s = 2
[[histories]]
name = "poke"
kind = "poke"
seed = 4
count = 1
depth_m = [0.002, 0.01]
max_angle_deg = 40
rise_s = [0.07, 1.0]
duration_s = 3
wander_deg = 20
[[histories]]
name = "again"
kind = "again"
seed = 5
count = 1
depth_m = [0.002, 0.01]
max_angle_deg = 30
rise_s = [0.08, 1.0]
hold_s = 0.7
apart_m = 0.02
)";
    return text;
}

/// Refusal of a study's text; it must name the file, the line at which `from` ends, and the key.
std::string said(const std::string& text, const std::string& from, const std::string& key) {
    INFO(text);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(text.find(from) + from.size() - 1), '\n');
    const TemporaryFolder folder;
    const std::string words = refusal<StudyError>([&] { read_study(folder.file("s.toml", text)); });
    CHECK_THAT(words, Contains("s.toml:" + std::to_string(line) + ": key '" + key + "': "));
    return words;
}

/// Refusal of the groups of histories with one change.
std::string changed(const std::string& from, const std::string& to, const std::string& key) {
    return said(over_quick(branches() + with(groups(), from, to)), to, key);
}

std::string solid_with(const std::string& material, const std::string& nodule = "") {
    return with(solid_study_text(), "C2_Pa = 491.0", "C2_Pa = 491.0\n" + material) + nodule;
}

}  // namespace

TEST_CASE("Maxwell branches are sorted by relaxation time and a material without them is elastic", "[histories]") {
    const Study elastic = example_study(over_quick("")), study = example_study(over_quick(branches()));
    CHECK_FALSE(elastic.material.relaxes());
    CHECK(elastic.material.share.empty());
    REQUIRE(study.material.relaxes());
    REQUIRE(study.material.viscosity.size() == 2);
    CHECK(study.material.viscosity[0].tau_s == 0.05);
    CHECK(study.material.viscosity[0].share == 0.25);
    CHECK(study.material.viscosity[1].tau_s == 1);
    CHECK(study.material.share == std::vector<double>{0.25, 0.3});
    CHECK(study.material.C1_Pa == 263);
}

TEST_CASE("long-term moduli are converted to instantaneous ones and so is the modulus of the springs", "[histories]") {
    const Study study = example_study(over_quick(with(branches(), "instantaneous", "long-term")));
    CHECK(study.material.C1_Pa == Approx(263 / 0.45).epsilon(tolerance::rounding));
    CHECK(study.material.C2_Pa == Approx(491 / 0.45).epsilon(tolerance::rounding));
    CHECK(study.modulus_N_m() == Approx(example_study(over_quick("")).modulus_N_m() / 0.45).epsilon(tolerance::rounding));
    const std::string ogden = "law = \"ogden\"\nmu_Pa = [900, -300]\nalpha = [3.7, -9.3]\n";
    const Study other = example_study(over_quick(with(with(branches(), "[material]\n", "[material]\n" + ogden), "instantaneous", "long-term")));
    CHECK(other.material.mu_Pa[0] == Approx(900 / 0.45).epsilon(tolerance::rounding));
    CHECK(other.material.mu_Pa[1] == Approx(-300 / 0.45).epsilon(tolerance::rounding));
    CHECK(other.material.alpha == std::vector<double>{3.7, -9.3});
}

TEST_CASE("a nodule or region has the base's relative moduli or its own and converts its moduli accordingly", "[histories]") {
    const std::string material = "viscosity = [{ g = 0.3, tau_s = 1.0 }, { g = 0.25, tau_s = 0.05 }]\nmoduli = \"long-term\"";
    const Study alike = example_study(solid_with(material));
    REQUIRE(alike.nodule);
    CHECK(alike.nodule->share == std::vector<double>{0.25, 0.3});
    CHECK(alike.nodule->C1_Pa == Approx(1000 / 0.45).epsilon(tolerance::rounding));
    const Study own = example_study(solid_with(material, "viscosity = [{ g = 0, tau_s = 1.0 }, { g = 0.5, tau_s = 0.05 }]\n"));
    CHECK(own.nodule->share == std::vector<double>{0.5, 0});
    CHECK(own.nodule->C1_Pa == Approx(2000).epsilon(tolerance::rounding));
    CHECK(own.material.C1_Pa == Approx(263 / 0.45).epsilon(tolerance::rounding));

    const std::string organ = "based_on = \"" + (std::filesystem::current_path() / "fem/studies/organ-lump").string() + "\"\n";
    const Study before = example_study(organ);
    REQUIRE(before.material.regions.size() == 1);
    const std::string name = before.material.regions[0].name;
    const std::string relaxing = organ + with(branches(), "instantaneous", "long-term") + "formulation = \"plane-strain\"\n[springs]\nstiffness = \"law\"\nterms = [\"spring.all\"]\n";
    const Study same = example_study(relaxing), other = example_study(relaxing + "[material.regions." + name + "]\nviscosity = [{ g = 0.1, tau_s = 0.05 }, { g = 0.1, tau_s = 1 }]\n");
    CHECK(same.material.regions[0].share == same.material.share);
    CHECK(same.material.regions[0].C1_Pa == Approx(before.material.regions[0].C1_Pa / 0.45).epsilon(tolerance::rounding));
    CHECK(other.material.regions[0].share == std::vector<double>{0.1, 0.1});
    CHECK(other.material.regions[0].C1_Pa == Approx(before.material.regions[0].C1_Pa / 0.8).epsilon(tolerance::rounding));
}

TEST_CASE("invalid Maxwell branches are refused with line and key", "[histories]") {
    const auto refused = [](const std::string& from, const std::string& to, const std::string& key, const std::string& where) {
        return said(over_quick(with(branches(), from, to)), where, key);
    };
    CHECK_THAT(refused("g = 0.3", "g = 0", "material.viscosity[0].g", "viscosity"), Contains("a number > 0"));
    CHECK_THAT(refused("g = 0.3", "g = 0.75", "material.viscosity", "viscosity"), Contains("less than 1"));
    CHECK_THAT(refused("tau_s = 0.05", "tau_s = 0", "material.viscosity[1].tau_s", "viscosity"), Contains("a number > 0"));
    CHECK_THAT(refused("tau_s = 0.05", "tau_s = 1", "material.viscosity", "viscosity"), Contains("twice"));
    CHECK_THAT(refused("g = 0.3", "share = 0.3", "material.viscosity[0].g", "viscosity"), Contains("is missing"));
    CHECK_THAT(refused("g = 0.3", "g = 0.3, x = 1", "material.viscosity[0].x", "viscosity"), Contains("not known"));
    CHECK_THAT(refused("\"instantaneous\"", "\"long\"", "material.moduli", "moduli"), Contains("instantaneous, long-term"));
    CHECK_THAT(refused("moduli = \"instantaneous\"", "", "material.viscosity", "viscosity"), Contains("needs material.moduli"));
    CHECK_THAT(said(over_quick("[material]\nmoduli = \"instantaneous\"\n"), "moduli", "material.moduli"), Contains("needs material.viscosity"));
    std::string nine = "[material]\nmoduli = \"instantaneous\"\nviscosity = [";
    for (int k = 1; k <= 9; ++k) nine += "{ g = 0.1, tau_s = " + std::to_string(k) + " }, ";
    CHECK_THAT(said(over_quick(nine + "]\n"), "viscosity", "material.viscosity"), Contains("at most 8"));
}

TEST_CASE("FE relaxation is refused in plane stress and with spring sets and for Ogden's law in space", "[histories]") {
    CHECK_THAT(said(over_quick(branches() + "formulation = \"plane-stress\"\n"), "viscosity", "material.viscosity"), Contains("plane stress"));
    const std::string sets = "[springs]\nstiffness = \"sets\"\nlaw = \"axial\"\n[training]\noptimizer = \"exact\"\nalso = []\nseed = 1\niterations = 1\n"
                             "k_min_E2 = 0.05\nk_max_E2 = 40.0\nweight_near = [1, 1]\nweight_far = [1, 1]\n";
    CHECK_THAT(said(over_quick(branches() + sets), "viscosity", "material.viscosity"), Contains("stiffness = \"law\""));
    const std::string measured = "based_on = \"" + (std::filesystem::current_path() / "fem/studies/measured").string() + "\"\n" + branches();
    CHECK(example_study(measured + "formulation = \"plane-stress\"\n").material.relaxes());
    const std::string mooney = "law = \"mooney-rivlin\"\nC1_Pa = 263.0\nC2_Pa = 491.0", own = "C1_Pa = 1000.0\nC2_Pa = 2000.0";
    const std::string ogden = with(with(solid_study_text(), mooney, "law = \"ogden\"\nmu_Pa = [900]\nalpha = [3.7]\nviscosity = [{ g = 0.3, tau_s = 1 }]\nmoduli = \"instantaneous\""),
                                   own, "mu_Pa = [900]\nalpha = [3.7]");
    CHECK_THAT(said(ogden, "viscosity", "material.viscosity"), Contains("Ogden"));
}

TEST_CASE("Maxwell branches of a nodule need those of the base with the same relaxation times", "[histories]") {
    const std::string material = "viscosity = [{ g = 0.3, tau_s = 1.0 }]\nmoduli = \"instantaneous\"", own = "viscosity = [{ g = 0.2, tau_s = 2.0 }] # own\n";
    CHECK_THAT(said(solid_with(material, own), own, "nodule.viscosity"), Contains("the tau_s of material.viscosity"));
    CHECK_THAT(said(solid_with(material, "viscosity = [] # own\n"), "viscosity = [] # own", "nodule.viscosity"), Contains("the tau_s"));
    CHECK_THAT(said(solid_with("", own), own, "nodule.viscosity"), Contains("needs material.viscosity"));
}

TEST_CASE("a preset or law or empty list in a derived study drops the relaxation of the base", "[histories]") {
    const TemporaryFolder folder;
    folder.file("base.toml", over_quick(branches()));
    const auto derived = [&](const std::string& tables) { return read_study(folder.file("derived.toml", "based_on = \"base\"\n" + tables)); };
    CHECK(derived("").material.relaxes());
    CHECK_FALSE(derived("[material]\nlaw = \"neo-Hookean\"\nC2_Pa = 0\n").material.relaxes());
    const Study elastic = derived("[material]\nviscosity = []\n");
    CHECK_FALSE(elastic.material.relaxes());
    CHECK(elastic.material.C1_Pa == 263);
    // the key moduli is still that of the base
    const Study other = derived("[material]\nviscosity = [{ g = 0.5, tau_s = 3 }]\n");
    CHECK(other.material.share == std::vector<double>{0.5});

    std::filesystem::create_directory(folder.file("studies"));
    std::filesystem::create_directory(folder.file("materials"));
    const std::string jelly = "law = \"neo-Hookean\"\nC1_Pa = 10\ndensity_kg_m3 = 1000\n";
    folder.file("materials/jelly.toml", jelly);
    folder.file("materials/slow.toml", jelly + "viscosity = [{ g = 0.5, tau_s = 2 }]\nmoduli = \"long-term\"\n");
    const auto preset = [&](const std::string& tables) {
        return read_study(folder.file("studies/derived.toml", "based_on = \"../base\"\n[material]\n" + tables));
    };
    CHECK_FALSE(preset("preset = \"jelly\"\n").material.relaxes());
    const Study slow = preset("preset = \"slow\"\n");
    REQUIRE(slow.material.viscosity.size() == 1);
    CHECK(slow.material.viscosity[0].tau_s == 2);
    CHECK(slow.material.C1_Pa == 20);
    CHECK_FALSE(preset("preset = \"slow\"\nviscosity = []\n").material.relaxes());
}

TEST_CASE("groups of histories have the values of their tables and the role held_out by default", "[histories]") {
    const Study study = example_study(over_quick(branches() + groups()));
    REQUIRE(study.histories.size() == 5);
    const Study::Histories &ramp = study.histories[0], &release = study.histories[1], &sine = study.histories[2], &poke = study.histories[3], &again = study.histories[4];
    CHECK(ramp.name == "ramp");
    CHECK(ramp.kind == "ramp");
    CHECK(ramp.role == "held_out");
    CHECK(ramp.seed == 1);
    CHECK(ramp.count == 2);
    CHECK(ramp.depth_m[1] == 0.01);
    CHECK(ramp.max_angle_deg == 30);
    CHECK(ramp.rise_s[0] == 0.05);
    CHECK(ramp.rise_s[1] == 1);
    CHECK(ramp.hold_s == 0.5);
    CHECK(release.role == "validation");
    CHECK(release.hold_s == 0.6);
    CHECK(sine.role == "train");
    CHECK(sine.frequency_Hz[0] == 0.2);
    CHECK(sine.frequency_Hz[1] == 5);
    CHECK(sine.duration_s == 2);
    CHECK(poke.wander_deg == 20);
    CHECK(poke.duration_s == 3);
    CHECK(again.apart_m == 0.02);
    CHECK(example_study(over_quick(branches() + with(groups(), "apart_m = 0.02\n", ""))).histories[4].apart_m == 0);
    CHECK(example_study(over_quick(groups())).histories.size() == 5);  // elastic tissue may have histories too
}

TEST_CASE("invalid groups of histories are refused with line and key", "[histories]") {
    CHECK_THAT(changed("name = \"release\"", "name = \"Release\"", "histories[1].name"), Contains("lower-case"));
    CHECK_THAT(said(over_quick(branches() + with(groups(), "name = \"release\"", "name = \"ramp\"  #")), "name = \"ramp\"  #", "histories[1].name"), Contains("twice"));
    CHECK_THAT(changed("kind = \"poke\"", "kind = \"prod\"", "histories[3].kind"), Contains("ramp, release, sine, poke, again, file"));
    CHECK_THAT(changed("role = \"train\"", "role = \"trained\"", "histories[2].role"), Contains("held_out, validation, train"));
    CHECK_THAT(changed("seed = 2", "seed = 1 #", "histories[1].seed"), Contains("'ramp'"));
    CHECK_THAT(changed("seed = 2", "seed = 4102", "histories[1].seed"), Contains("draws.held_out"));
    CHECK_THAT(changed("count = 3", "count = 0", "histories[1].count"), Contains("an integer from 1"));
    CHECK_THAT(changed("rise_s = [0.06, 1.0]", "rise_s = [0.001, 1.0]", "histories[1].rise_s"), Contains("a number >= 0.005"));
    CHECK_THAT(changed("rise_s = [0.06, 1.0]", "rise_s = [2, 1.0]", "histories[1].rise_s"), Contains("[smallest, largest]"));
    CHECK_THAT(changed("hold_s = 0.6", "hold_s = -1", "histories[1].hold_s"), Contains("a number >= 0"));
    CHECK_THAT(changed("frequency_Hz = [0.2, 5]", "frequency_Hz = [0, 5]", "histories[2].frequency_Hz"), Contains("a number >= 0.01"));
    CHECK_THAT(changed("duration_s = 2", "duration_s = 0", "histories[2].duration_s"), Contains("a number >="));
    CHECK_THAT(changed("wander_deg = 20", "wander_deg = 40", "histories[3].wander_deg"), Contains("at most 35"));
    CHECK_THAT(changed("apart_m = 0.02", "apart_m = -0.02", "histories[4].apart_m"), Contains("a number >= 0"));
    CHECK_THAT(changed("duration_s = 2", "duration_s = 2\nhold_s = 1", "histories[2].hold_s"), Contains("not known"));
    CHECK_THAT(changed("duration_s = 2", "duration_s = 2\ntilt_deg = [0, 1]", "histories[2].tilt_deg"), Contains("not known"));
    const std::string deep = with(groups(), "seed = 3\ncount = 1\ndepth_m = [0.002, 0.01]", "seed = 3\ncount = 1\ndepth_m = [0.002, 0.5]");
    CHECK_THAT(said(over_quick(branches() + deep), "depth_m = [0.002, 0.5]", "histories[2].depth_m"), Contains("at most"));
    CHECK_THAT(said(over_quick(branches() + "histories = 3\n"), "histories = 3", "material.histories"), Contains("not known"));
}

TEST_CASE("histories need a sweep in the plane and tilt and clearance in space; measured tissue has none", "[histories]") {
    const std::string group = groups().substr(0, groups().find("[[histories]]", 5));
    CHECK_THAT(said(example_study_text() + group, "kind = \"ramp\"", "histories[0].kind"), Contains("loads.sweep"));
    const std::string measured = "based_on = \"" + (std::filesystem::current_path() / "fem/studies/measured").string() + "\"\n";
    CHECK_THAT(said(measured + group, "[[histories]]", "histories"), Contains("needs finite elements"));
    const std::string solid = with(with(group, "max_angle_deg = 30", "tilt_deg = [0, 30]\nclearance_m = [0.02, 0.04]"), "[0.002, 0.01]", "[0.001, 0.002]");
    const Study study = example_study(solid_study_text() + with(solid, "seed = 1", "seed = 991"));
    CHECK(study.histories.at(0).tilt_deg[1] == 30);
    CHECK(study.histories.at(0).clearance_m[0] == 0.02);
    const std::string again = with(solid, "kind = \"ramp\"", "kind = \"again\"\napart_m = 0.01");
    CHECK_THAT(said(solid_study_text() + with(again, "seed = 1", "seed = 991"), "apart_m", "histories[0].apart_m"), Contains("the plane"));
}

TEST_CASE("a history of kind file has a file beside the study and a contact on the free surface", "[histories]") {
    const TemporaryFolder folder;
    folder.file("hand.csv", "time_s,x_m,y_m\n");
    const auto text = [](const std::string& file, const std::string& contact) {
        return over_quick(branches() + "[[histories]]\nname = \"hand\"\nkind = \"file\"\nfile = \"" + file + "\"\ncontact_m = " + contact + "\n");
    };
    const Study study = read_study(folder.file("s.toml", text("hand.csv", "[0.05, 0.1]")));
    REQUIRE(study.histories.size() == 1);
    CHECK(study.histories[0].file == folder.file("hand.csv"));
    CHECK(study.histories[0].contact_m == Eigen::Vector2d(0.05, 0.1));
    CHECK(study.histories[0].count == 1);
    const auto refused = [&](const std::string& words) { return refusal<StudyError>([&] { read_study(folder.file("s.toml", words)); }); };
    CHECK_THAT(refused(text("none.csv", "[0.05, 0.1]")), Contains("s.toml:8: key 'histories[0].file': there is no file"));
    CHECK_THAT(refused(text("hand.csv", "[0.05, 0.09]")), Contains("s.toml:9: key 'histories[0].contact_m'") && Contains("free surface"));
    CHECK_THAT(refused(text("hand.csv", "[0, 0.01]")), Contains("histories[0].contact_m") && Contains("15 mm"));
    CHECK_THAT(refused(text("hand.csv", "[0.05, 0.1]") + "seed = 3\n"), Contains("histories[0].seed") && Contains("not known"));
}
