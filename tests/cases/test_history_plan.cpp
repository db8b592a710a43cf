#include "cases/history_plan.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <set>

#include "cases/plan.h"
#include "cases/study_mesh.h"
#include "cases/sweep.h"
#include "error.h"
#include "mesh/outline.h"
#include "../example.h"
#include "../refusal.h"
#include "../solid_example.h"
#include "../solid_shape_study.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

constexpr double degree = 3.14159265358979323846 / 180;

Study mini() {
    return read_study("fem/studies/relax-mini.toml");
}

/// The committed study with 40 histories in each group.
Study many() {
    Study study = mini();
    for (Study::Histories& group : study.histories) group.count = 40;
    return study;
}

Outline outline() {
    return Outline(make_lattice("grid4", 10, 10, 0.1, 0.1));
}

const Study::Histories& group_of(const Study& study, const PlannedHistory& history) {
    for (const Study::Histories& group : study.histories)
        if (group.name == history.group) return group;
    throw std::logic_error("no such group");
}

/// The solid example with tissue that relaxes, two histories of kind `ramp` and two of kind `poke`.
Study solid() {
    const std::string place = "count = 2\ndepth_m = [0.001, 0.002]\ntilt_deg = [0, 30]\nclearance_m = [0.02, 0.04]\nrise_s = [0.05, 0.5]\n";
    return example_study(with(solid_study_text(), "C2_Pa = 491.0", "C2_Pa = 491.0\nviscosity = [{ g = 0.4, tau_s = 0.5 }]\nmoduli = \"instantaneous\"") +
                         "viscosity = [{ g = 0.1, tau_s = 0.5 }]\n" + "[[histories]]\nname = \"ramp\"\nkind = \"ramp\"\nseed = 991\nhold_s = 0.1\n" + place +
                         "[[histories]]\nname = \"poke\"\nkind = \"poke\"\nseed = 992\nduration_s = 2\nwander_deg = 25\n" + place);
}

}  // namespace

TEST_CASE("planned histories have unique names and surface contacts and start at rest with ascending times", "[histories]") {
    const Study study = many();
    const auto histories = planned_histories(study);
    REQUIRE(histories.size() == 40 * study.histories.size());
    std::set<std::string> names;
    for (const PlannedHistory& h : histories) {
        INFO(h.push.name);
        CHECK(names.insert(h.push.name).second);
        const double arc = outline().arc_of(h.push.contact_m);
        CHECK((outline().position(arc) - h.push.contact_m).norm() < tolerance::rounding);
        CHECK(h.push.direction.norm() == Approx(1).epsilon(tolerance::rounding));
        const Trajectory& c = h.trajectory;
        REQUIRE(c.push_m.rows() == c.time_s.size());
        CHECK(c.time_s[0] == 0);
        CHECK(c.push_m.row(0).norm() == 0);
        for (Eigen::Index t = 1; t < c.time_s.size(); ++t) CHECK(c.time_s[t] > c.time_s[t - 1]);
        CHECK(c.depth_m() == h.push.depth_m);
        const Study::Histories& group = group_of(study, h);
        CHECK(h.push.depth_m <= group.depth_m[1]);
        CHECK(h.role == group.role);
        CHECK(h.kind == group.kind);
    }
    CHECK(names.count("ramp-0001") == 1);
    CHECK(names.count("again-0040") == 1);
}

TEST_CASE("contacts of histories are at least 2 mm or 5 degrees from every training contact", "[histories]") {
    const Study study = many();
    std::vector<StudyPath> trained;
    for (const PlannedPath& p : planned_paths(study))
        if (p.role == "train") {
            trained.push_back(p.push);
            trained.push_back({"", Eigen::Vector2d(0.1 - p.push.contact_m.x(), p.push.contact_m.y()), Eigen::Vector2d(-p.push.direction.x(), p.push.direction.y())});
        }
    const auto apart = [&](const Point& contact_m, const Point& direction) {
        const double arc = outline().arc_of(contact_m);
        for (const StudyPath& t : trained) {
            const double other = outline().arc_of(t.contact_m);
            if (std::abs(arc - other) < 0.002 - 1e-9 && std::acos(std::clamp(direction.dot(t.direction), -1.0, 1.0)) < 5 * degree - 1e-6) return false;
        }
        return true;
    };
    for (const PlannedHistory& h : planned_histories(study)) {
        INFO(h.push.name);
        CHECK(apart(h.push.contact_m, h.push.direction));
        const Eigen::Index last = h.trajectory.time_s.size() - 1;
        if (h.second_contact_m) CHECK(apart(*h.second_contact_m, h.trajectory.push_m.row(last).transpose().normalized()));
    }
}

TEST_CASE("histories depend on the seed of their own group and not on other groups", "[histories]") {
    const Study study = mini();
    Study other = study, more = study;
    other.histories[0].seed += 1000;
    more.histories[1].count = 5;
    const auto a = planned_histories(study), b = planned_histories(study), c = planned_histories(other), d = planned_histories(more);
    const auto same = [](const PlannedHistory& x, const PlannedHistory& y) {
        return x.push.name == y.push.name && x.push.contact_m == y.push.contact_m && x.trajectory.time_s == y.trajectory.time_s && x.trajectory.push_m == y.trajectory.push_m;
    };
    REQUIRE(a.size() == c.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        CHECK(same(a[i], b[i]));
        CHECK(same(a[i], c[i]) == (a[i].group != study.histories[0].name));
        const auto again = std::find_if(d.begin(), d.end(), [&](const PlannedHistory& h) { return h.push.name == a[i].push.name; });
        CHECK(same(a[i], *again));
    }
}

TEST_CASE("a ramp follows minimum jerk and holds; a release returns in the time of its ramp", "[histories]") {
    const Study study = many();
    for (const PlannedHistory& h : planned_histories(study)) {
        if (h.kind != "ramp" && h.kind != "release") continue;
        INFO(h.push.name);
        const Study::Histories& group = group_of(study, h);
        const double end_s = h.trajectory.time_s[h.trajectory.time_s.size() - 1], ramps = h.kind == "ramp" ? 1 : 2, rise_s = end_s / ramps - group.hold_s;
        CHECK(rise_s >= group.rise_s[0] - 1e-9);
        CHECK(rise_s <= group.rise_s[1] + 1e-9);
        for (Eigen::Index t = 0; t < h.trajectory.time_s.size(); ++t) {
            const double at = h.trajectory.time_s[t], back = at - rise_s - group.hold_s;
            double part = minimum_jerk(std::min(at / rise_s, 1.0));
            if (h.kind == "release" && back > 0) part = 1 - minimum_jerk(std::min(back / rise_s, 1.0));
            CHECK((h.trajectory.push_m.row(t).transpose() - part * h.push.depth_m * h.push.direction).norm() < 1e-12);
        }
        CHECK(h.trajectory.contact == std::vector<int>(h.trajectory.contact.size(), 1));
    }
}

TEST_CASE("a history of kind poke never rests and ends within its wander angle and one rise time", "[histories]") {
    const Study study = many();
    for (const PlannedHistory& h : planned_histories(study)) {
        if (h.kind != "poke") continue;
        INFO(h.push.name);
        const Study::Histories& group = group_of(study, h);
        const double end_s = h.trajectory.time_s[h.trajectory.time_s.size() - 1];
        CHECK(end_s >= group.duration_s);
        CHECK(end_s < group.duration_s + group.rise_s[1]);
        // no rest: consecutive displacements differ
        for (Eigen::Index t = 0; t + 1 < h.trajectory.time_s.size(); ++t) CHECK(h.trajectory.push_m.row(t) != h.trajectory.push_m.row(t + 1));
        const Point last = h.trajectory.push_m.row(h.trajectory.time_s.size() - 1).transpose();
        CHECK(std::acos(std::clamp(last.normalized().dot(h.push.direction), -1.0, 1.0)) <= group.wander_deg * degree + 1e-9);
        CHECK(last.norm() >= group.depth_m[0] - 1e-12);
    }
}

TEST_CASE("a second contact lies at its distance or at the first contact after 0.8 s without contact", "[histories]") {
    Study study = many();
    const auto check = [&](bool elsewhere) {
        for (const PlannedHistory& h : planned_histories(study)) {
            if (h.kind != "again") continue;
            INFO(h.push.name);
            const Study::Histories& group = group_of(study, h);
            REQUIRE(h.second_contact_m.has_value() == elsewhere);
            if (elsewhere) CHECK(std::abs(outline().arc_of(*h.second_contact_m) - outline().arc_of(h.push.contact_m)) == Approx(group.apart_m).epsilon(1e-9));
            double left = 0, landed = 0;
            for (Eigen::Index t = 1; t < h.trajectory.time_s.size(); ++t) {
                const int before = h.trajectory.contact[static_cast<std::size_t>(t - 1)], now = h.trajectory.contact[static_cast<std::size_t>(t)];
                if (before == 1 && now == 0) left = h.trajectory.time_s[t - 1];
                if (before == 0 && now != 0) landed = h.trajectory.time_s[t - 1];
            }
            CHECK(landed - left == Approx(0.8).epsilon(1e-9));
            CHECK(h.trajectory.contact.back() == (elsewhere ? 2 : 1));
            CHECK(h.trajectory.push_m.row(h.trajectory.time_s.size() - 1).norm() == Approx(h.push.depth_m).epsilon(1e-9));
        }
    };
    check(true);
    study.histories.back().apart_m = 0;
    check(false);
    study.histories.back().apart_m = 0.9;
    CHECK_THAT(refusal<MismatchError>([&] { planned_histories(study); }), Contains("histories 'again'") && Contains("no space"));
}

TEST_CASE("the plan solves histories in permanent contact on relaxing and on elastic tissue from one displacement file", "[histories]") {
    const Study study = mini();
    const Plan plan = make_plan(study);
    const std::string& again = plan.parts.at("path-again-0001");
    for (const char* argument : {" -history history-again-0001", " -density 1040", " -second_x ", " -second_y ", " -C1 263", " -records 1 ", " -allow_lost 1"})
        CHECK_THAT(again, Contains(argument));
    // after time without contact the displacement would differ on elastic tissue
    CHECK(plan.parts.count("path-again-0001-elastic") == 0);
    const std::string& relaxes = plan.parts.at("path-ramp-0001");
    const std::string& elastic = plan.parts.at("path-ramp-0001-elastic");
    CHECK_THAT(relaxes, Contains(" -branches 3 -g1 0.3 -tau1 0.05 -g2 0.25 -tau2 1 -g3 0.2 -tau3 10"));
    CHECK_THAT(elastic, !Contains("-branches"));
    CHECK_THAT(plan.parts.at("path-ramp-0001"), !Contains("-second_x"));
    CHECK_THAT(plan.parts.at("path-s0150-p000"), !Contains("-branches") && !Contains("-history") && !Contains("-density"));
    for (const char* name : {"ramp-0001", "ramp-0001-elastic"})
        CHECK_THAT(plan.fragment, Contains(std::string("$(R)/cases/") + name + ".csv: $(R)/plan/path-" + name + " $(R)/plan/history-ramp-0001 $(R)/mesh.msh"));
    CHECK_THAT(plan.fragment, Contains(" -history $(R)/plan/history-ramp-0001 ") && Contains(" ramp-0001 ramp-0001-elastic "));
    const std::string& steps = plan.parts.at("history-ramp-0001");
    CHECK(steps.substr(0, steps.find('\n')) == "0 0 0 0 1");
    CHECK_THAT(plan.parts.at("collect"), Contains("history ramp held_out ramp-0001\n") && Contains("history poke validation poke-0001\n"));
}

TEST_CASE("elastic tissue has one solve per history and a study without histories plans none", "[histories]") {
    Study study = mini();
    study.material.viscosity.clear();
    study.material.share.clear();
    const Plan plan = make_plan(study);
    CHECK(plan.parts.count("path-ramp-0001") == 1);
    CHECK(plan.parts.count("path-ramp-0001-elastic") == 0);
    CHECK_THAT(plan.parts.at("path-ramp-0001"), !Contains("-branches"));
    for (const auto& [name, text] : make_plan(read_study("fem/studies/surface-quick.toml")).parts) CHECK_THAT(text, !Contains("histor") && !Contains("relaxes"));
}

TEST_CASE("a history group whose histories have names of load paths is refused in planning", "[histories]") {
    Study study = mini();
    study.histories[0].name = "held-out";
    CHECK_THAT(refusal<StudyError>([&] { make_plan(study); }), Contains("relax-mini.toml: key 'histories': 'held-out-0001'"));
}

TEST_CASE("histories in space keep their tilt and clearance and a nodule has its own relative moduli", "[histories]") {
    const Study study = solid();
    const auto histories = planned_histories(study);
    REQUIRE(histories.size() == 4);
    for (const PlannedHistory& h : histories) {
        INFO(h.push.name);
        REQUIRE(h.trajectory.push_m.cols() == 3);
        CHECK(h.push.contact_m[2] == 0.05);
        CHECK(-h.push.direction[2] >= std::cos(30 * degree) - 1e-9);
        const double wall = std::min({h.push.contact_m[0], 0.1 - h.push.contact_m[0], h.push.contact_m[1], 0.08 - h.push.contact_m[1]});
        CHECK(wall >= 0.02 - 1e-12);
        const Point last = h.trajectory.push_m.row(h.trajectory.time_s.size() - 1).transpose();
        const double off = std::acos(std::clamp(last.normalized().dot(h.push.direction), -1.0, 1.0)) / degree;
        CHECK(off <= (h.kind == "poke" ? 25 + 1e-6 : 1e-5));
    }
    const Plan plan = make_plan(study);
    CHECK_THAT(plan.parts.at("path-poke-0001"), Contains(" -history history-poke-0001 -density 1000 -branches 1 -g1 0.4 -tau1 0.5 -g1_11 0.1"));
    CHECK_THAT(plan.parts.at("path-poke-0001-elastic"), !Contains("-branches"));
    CHECK_THAT(plan.fragment, Contains("poke-0001.csv: $(R)/plan/path-poke-0001 $(R)/plan/history-poke-0001 scripts/run_gmsh fem/block3.geo"));
}

TEST_CASE("a file history has the given contact and the direction of its largest displacement; the plan depends on the file", "[histories]") {
    const TemporaryFolder folder;
    folder.file("hand.csv", "time_s,x_m,y_m\n0,0,0\n0.05,0,-0.002\n0.1,0.003,-0.004\n0.2,0,0\n");
    const std::string text = "based_on = \"" + (std::filesystem::current_path() / "fem/studies/surface-quick").string() +
                             "\"\n[[histories]]\nname = \"hand\"\nkind = \"file\"\nfile = \"hand.csv\"\ncontact_m = [0.05, 0.1]\n";
    const Study study = read_study(folder.file("s.toml", text));
    const auto histories = planned_histories(study);
    REQUIRE(histories.size() == 1);
    CHECK(histories[0].push.name == "hand-0001");
    CHECK(histories[0].push.contact_m == Eigen::Vector2d(0.05, 0.1));
    CHECK(histories[0].push.depth_m == Approx(0.005).epsilon(tolerance::rounding));
    CHECK((histories[0].push.direction - Eigen::Vector2d(0.6, -0.8)).norm() < tolerance::rounding);
    CHECK_THAT(make_plan(study).fragment, Contains("$(R)/plan.mk: $(wildcard " + folder.file("hand.csv") + ")"));
    folder.file("hand.csv", "time_s,x_m,y_m\n0,0,0\n");
    CHECK_THAT(refusal<FileError>([&] { make_plan(study); }), Contains("hand.csv:2: "));
}

TEST_CASE("the contact of a file history moves to a solid's surface; far off or near an edge it is refused", "[histories]") {
    const TemporaryFolder folder;
    folder.file("dome.geo", "");
    folder.file("hand.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n0.1,0,0,-0.004\n0.2,0,0,0\n");
    const std::optional<Shape> shape = dome();
    const auto histories = [&](const std::string& contact_m) {
        const std::string relaxes = with(shape_study_text(), "C2_Pa = 491.0", "C2_Pa = 491.0\nviscosity = [{ g = 0.4, tau_s = 0.5 }]\nmoduli = \"instantaneous\"");
        return planned_histories(read_study(folder.file("s.toml", relaxes + "[[histories]]\nname = \"hand\"\nkind = \"file\"\nfile = \"hand.csv\"\ncontact_m = " + contact_m + "\n")), shape);
    };
    const Point contact_m = histories("[0.0, 0.0, 0.052]").at(0).push.contact_m;
    CHECK((contact_m - Eigen::Vector3d(0, 0, 0.05)).norm() < 1e-4);
    const auto refused = [&](const std::string& where) { return refusal<StudyError>([&] { histories(where); }); };
    CHECK_THAT(refused("[0.0, 0.0, 0.08]"), Contains("key 'contact_m' of ") && Contains(": is 30 mm off the free surface"));
    CHECK_THAT(refused("[0.05, 0.0, 0.003]"), Contains(" mm from where the free surface ends or turns; a disc needs "));
}
