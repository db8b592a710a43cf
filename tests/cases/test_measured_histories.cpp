#include "cases/measured_histories.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <set>

#include "../measured_example.h"
#include "../refusal.h"
#include "error.h"
#include "mesh/outline.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const std::string header = "history,time [ms],contact_x [mm],contact_y [mm],displacement_x [mm],displacement_y [mm],force_x [mN],force_y [N]";

/// A ramp down into the top at x mm, by 0.4 mm a row (3.6 mm in 10 rows).
std::string ramp(const std::string& name, double x, const std::string& more = "", int rows = 10) {
    std::string text;
    for (int n = 0; n < rows; ++n) text += fmt::format("{},{},{},100,0,{},10,{}{}\n", name, 500 + 20 * n, x, -0.4 * n, -0.05 * n, more);
    return text;
}

Study relaxing_study() {
    std::string text = measured_study_text();
    text = with(text, "file = \"../data/d.csv\"", "file = \"../data/d.csv\"\nhistories = \"../data/h.csv\"");
    return example_study(with(text, "[material]\n", "[material]\nviscosity = \"measured\"\nmoduli = \"long-term\"\n"));
}

std::vector<History> read(const std::string& text) {
    const TemporaryFolder folder;
    return read_measured_histories(relaxing_study(), folder.file("h.csv", text));
}

std::string refused(const std::string& text) {
    return refusal<FileError>([&] { read(text); });
}

}  // namespace

TEST_CASE("measured histories are read in SI units with contact and role and with times from 0", "[histories][measured]") {
    const std::vector<History> histories = read("# a robot\n" + header + ",kind,role\n" + ramp("a", 40, ",ramp,train") + "\n" + ramp("b", 60, ",press,held_out"));
    REQUIRE(histories.size() == 2);
    const History& h = histories[0];
    CHECK(h.name == "a");
    CHECK(h.kind == "ramp");
    CHECK(h.group == "ramp");
    CHECK(h.role == "train");
    CHECK(histories[1].role == "held_out");
    CHECK(h.contact_m.isApprox(Eigen::Vector2d(0.04, 0.1)));
    CHECK(h.direction.isApprox(Eigen::Vector2d(0, -1)));
    CHECK(h.time_s[0] == 0);
    CHECK(h.time_s[9] == Approx(0.18));
    CHECK(h.push_m(9, 1) == Approx(-0.0036));
    CHECK(h.force_N(9, 0) == Approx(0.01));
    CHECK(h.force_N(9, 1) == Approx(-0.45));
    CHECK(h.elastic_N.rows() == 0);
    CHECK(h.contact == std::vector<int>(10, 1));
}

TEST_CASE("measured histories are split by contact and seed and at least one remains for training", "[histories][measured]") {
    std::string text = header + "\n";
    for (int i = 0; i < 10; ++i) text += ramp(fmt::format("a{}", i), 10 + 8 * i) + ramp(fmt::format("b{}", i), 10.5 + 8 * i);
    const std::vector<History> histories = read(text), again = read(text);
    std::map<std::string, int> count;
    for (std::size_t i = 0; i < histories.size(); ++i) {
        ++count[histories[i].role];
        CHECK(histories[i].role == again[i].role);
        CHECK(histories[i].role == histories[i ^ 1].role);  // contacts half a millimetre apart
    }
    CHECK(count["held_out"] == 4);   // a fifth of ten contacts, two histories each
    CHECK(count["validation"] == 2);
    CHECK(count["train"] == 14);
    const std::vector<History> two = read(header + "\n" + ramp("a", 40) + ramp("b", 60));
    CHECK(two[0].role != two[1].role);
    CHECK_THAT(refused(header + "\n" + ramp("a", 40) + ramp("b", 40.5)), Contains("h.csv: has histories at only one contact"));
    CHECK_THAT(refused(header + ",role\n" + ramp("a", 40, ",held_out") + ramp("b", 60, ",validation")), Contains("no history of role 'train'"));
}

TEST_CASE("roles of measured histories are kept and test histories within 2 mm of training are refused", "[histories][measured]") {
    const std::string own = header + ",role\n";
    const auto roles = [&](double x) { return own + ramp("a", 40, ",train") + ramp("b", x, ",held_out") + ramp("c", x + 0.5, ",validation"); };
    CHECK(read(roles(42.1)).size() == 3);
    CHECK_THAT(refused(roles(41.9)), Contains("h.csv:12: history 'b' is 'held_out', less than 2 mm along the surface from 'a' of line 2, which is 'train'"));
    CHECK_THAT(refused(own + ramp("a", 40, ",validation") + ramp("b", 41, ",train") + ramp("c", 60, ",held_out")), Contains("history 'b' is 'train'"));
    CHECK_THAT(refused(own + ramp("a", 40, ",train") + ramp("b", 60, ",validation")), Contains("h.csv: has no history of role 'held_out'"));
}

TEST_CASE("an invalid measured history is refused with its place", "[histories][measured]") {
    const std::string good = ramp("b", 60);
    const auto line = [&](const std::string& row) { return header + "\n" + ramp("a", 40) + row + "\n"; };
    CHECK_THAT(refused(with(header, "time [ms]", "time") + "\n" + good), Contains("h.csv:1: column 'time' has no unit"));
    CHECK_THAT(refused(with(header, "time [ms]", "time [min]") + "\n" + good), Contains("'min' is not known; allowed: ms, s"));
    CHECK_THAT(refused(with(header, ",time [ms]", "") + "\n" + good), Contains("'time' is missing"));
    CHECK_THAT(refused(line("a,700,40,100,0,-3.6,10,nan")), Contains("h.csv:12: column 'force_y' is 'nan'"));
    CHECK_THAT(refused(line("a,680,40,100,0,-3.6,10,-1")), Contains("h.csv:12: column 'time': 0.68 s is not later than 0.68 s"));
    CHECK_THAT(refused(line("a,700,42,100,0,-3.6,10,-1")), Contains("h.csv:12: history 'a' has another contact than on line 2"));
    CHECK_THAT(refused(line("a,700,40,100,0,-3.6,10")), Contains("has 7 fields"));
    CHECK_THAT(refused(line(",700,40,100,0,-3.6,10,-1")), Contains("'history' is empty"));
    for (const char* name : {"2024/run1", ".", "..", "run\t1", "run\x7f"})  // names that cases.h5 cannot have
        CHECK_THAT(refused(header + "\n" + ramp("a", 40) + ramp(name, 60)), Contains("h.csv:12: column 'history' is '") && Contains("'/'"));
    CHECK_THAT(refused(header + "\n" + ramp("a", 40) + good + ramp("a", 40)), Contains("h.csv:22: history 'a' continues here"));
    CHECK_THAT(refused(header + ",role\n" + ramp("a", 40, ",train") + ramp("b", 60, ",proof")), Contains("'role' is 'proof'"));
    CHECK_THAT(refused(header + "\n" + good + ramp("c", 40, "", 7)), Contains("history 'c' has 7 rows, at least 8 are needed"));
    std::string deep = header + "\n" + good;
    for (int n = 0; n < 9; ++n) deep += fmt::format("d,{},40,100,0,{},0,-1\n", 20 * n, -3.0 - 0.1 * n);
    CHECK_THAT(refused(deep), Contains("history 'd' begins at a displacement of 3 mm"));
    std::string out = header + "\n" + good;
    for (int n = 0; n < 9; ++n) out += fmt::format("d,{},40,100,0,{},0,{}\n", 20 * n, 0.4 * n, 0.1 * n);
    CHECK_THAT(refused(out), Contains("history 'd' has a displacement out of the tissue"));
    std::string far = header + "\n" + good;
    for (int n = 0; n < 9; ++n) far += fmt::format("d,{},40,100,0,{},0,-1\n", 20 * n, -20 * n);
    CHECK_THAT(refused(far), Contains("history 'd' has a displacement of 160 mm, more than the tissue's size of 100 mm"));
    std::string against = header + "\n" + good;
    for (int n = 0; n < 9; ++n) against += fmt::format("d,{},40,100,0,{},0,{}\n", 20 * n, -0.4 * n, 0.1 * n);
    CHECK_THAT(refused(against), Contains("history 'd' has a force against its largest displacement"));
    std::string still = header + "\n" + good;
    for (int n = 0; n < 9; ++n) still += fmt::format("d,{},40,100,0,0,0,1\n", 20 * n);
    CHECK_THAT(refused(still), Contains("history 'd' has no displacement"));
    std::string inside = header + "\n" + good;
    for (int n = 0; n < 9; ++n) inside += fmt::format("d,{},40,90,0,{},0,-1\n", 20 * n, -0.4 * n);
    CHECK_THAT(refused(inside), Contains("history 'd' has a contact 10 mm off the free surface"));
    CHECK_THAT(refused("# nothing\n"), Contains("has no header"));
    CHECK_THAT(refused(header + "\n"), Contains("has no rows"));
}

TEST_CASE("relative moduli are fitted only in a study with measured histories that states its moduli", "[histories][measured]") {
    const Study study = relaxing_study();
    CHECK(study.material.fits_shares);
    CHECK(study.material.long_term);
    CHECK(study.material.viscosity.empty());
    CHECK(study.material.relaxes());
    const std::string data = "file = \"../data/d.csv\"", both = data + "\nhistories = \"../data/h.csv\"";
    const auto asked = [&](const std::string& viscosity, const std::string& files) {
        return with(with(measured_study_text(), data, files), "[material]\n", "[material]\n" + viscosity + "\n");
    };
    const Study times = example_study(asked("moduli = \"instantaneous\"\nviscosity = [{ tau_s = 10 }, { tau_s = 0.5 }]", both));
    CHECK(times.material.fits_shares);
    REQUIRE(times.material.viscosity.size() == 2);
    CHECK(times.material.viscosity[0].tau_s == 0.5);
    const auto refuse = [&](const std::string& viscosity, const std::string& files) { return refusal<StudyError>([&] { example_study(asked(viscosity, files)); }); };
    CHECK_THAT(refuse("moduli = \"long-term\"\nviscosity = \"measured\"", data), Contains("histories") && Contains("is missing"));
    CHECK_THAT(refuse("", both), Contains("histories") && Contains("tissue that relaxes"));
    CHECK_THAT(refuse("viscosity = \"measured\"", both), Contains("moduli"));
    CHECK_THAT(refuse("moduli = \"long-term\"\nviscosity = \"guessed\"", both), Contains("measured"));
    CHECK_THAT(refuse("moduli = \"long-term\"\nviscosity = [{ tau_s = 10 }, { g = 0.1, tau_s = 0.5 }]", both), Contains(".g"));
    CHECK_THAT(refusal<StudyError>([&] { example_study(with(example_study_text(), "[material]\n", "[material]\nmoduli = \"long-term\"\nviscosity = \"measured\"\n")); }),
               Contains("viscosity") && Contains("data.histories"));
}
