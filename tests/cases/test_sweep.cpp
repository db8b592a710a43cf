#include "cases/sweep.h"

#include <catch2/catch.hpp>
#include <set>

#include "error.h"
#include "../example.h"
#include "mesh/outline.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// The example with contacts spaced over the surface, and with a drawn validation and test set.
std::string swept_text() {
    const std::string& text = example_study_text();
    const std::size_t from = text.find("paths = ["), to = text.find("[springs]");
    return text.substr(0, from) +
           "[loads.sweep]\nspacing_m = 0.025\nclearance_m = 0.025\nangles_deg = [-30, 0, 30]\n\n"
           "[draws]\nheld_out = { seed = 5, count = 40, depth_m = [0.002, 0.008], max_angle_deg = 30 }\n"
           "validation = { seed = 6, count = 10, depth_m = [0.002, 0.008], max_angle_deg = 30 }\n\n" +
           text.substr(to);
}

const Study& swept() {
    static const Study study = example_study(swept_text());
    return study;
}

Outline outline() {
    return Outline(make_lattice("grid4", 4, 4, 0.1, 0.1));
}

}  // namespace

TEST_CASE("a study with listed paths plans them in order to the largest magnitude") {
    const Study study = example_study();
    const auto paths = planned_paths(study);
    REQUIRE(paths.size() == 2);
    CHECK(paths[1].push.name == "corner");
    CHECK(paths[1].role == "train");
    CHECK(paths[1].depth_m == 0.008);
    CHECK(paths[1].records == 4);
}

TEST_CASE("every path of a sweep has a unique name and points from the free surface into the tissue") {
    std::set<std::string> names;
    for (const PlannedPath& p : planned_paths(swept())) {
        CHECK(names.insert(p.push.name).second);
        CHECK(p.push.direction.norm() == Approx(1).epsilon(tolerance::rounding));
        const double arc = outline().arc_of(p.push.contact_m);
        CHECK((outline().position(arc) - p.push.contact_m).norm() < tolerance::rounding);
        CHECK(p.push.direction.dot(outline().inward_normal(arc)) > 0);
        CHECK(p.push.contact_m.y() >= 0.025 - tolerance::rounding);
        CHECK(p.depth_m <= 0.008);
        CHECK(p.records >= 1);
    }
}

TEST_CASE("training contacts within 0.1 mm and directions within one degree get distinct names") {
    Study study = swept();
    study.loads.sweep->spacing_m = 0.02501;  // the fourth contact is 0.03 mm from the contact at the corner
    // 45 degrees from the bisector of a corner, and from the normal of a side
    study.loads.sweep->angles_deg = {-45, 0, 0.3, 45};
    std::set<std::string> names;
    std::vector<Eigen::Vector4d> pushes;
    for (const PlannedPath& p : planned_paths(study)) {
        CHECK(names.insert(p.push.name).second);
        CHECK(p.push.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos);
        if (p.role == "train") pushes.emplace_back(p.push.contact_m.x(), p.push.contact_m.y(), p.push.direction.x(), p.push.direction.y());
    }
    const auto count = [&](double x, double y) {
        return std::count_if(pushes.begin(), pushes.end(), [&](const Eigen::Vector4d& p) {
            return (p.head(2) - Eigen::Vector2d(x, y)).norm() < 1e-9;
        });
    };
    CHECK(count(0.1, 0.02500) == 4);  // none of the study's own directions is left out
    CHECK(count(0.1, 0.1) >= 4);
    CHECK(count(0.09997, 0.1) == 4);
}

TEST_CASE("path names have 0.1 mm and one degree resolution if that distinguishes all contacts") {
    std::set<std::string> names;
    for (const PlannedPath& p : planned_paths(swept())) names.insert(p.push.name);
    for (const char* name : {"s0250-m030", "s0250-p000", "s0500-p030", "s1000-p045", "held-out-0001", "validation-0010"})
        CHECK(names.count(name) == 1);
}

TEST_CASE("a listed path with the name of another path's mesh check is refused in planning") {
    Study study = example_study();
    study.check_refine = 2 * study.refine;
    study.check_fraction = 1;
    study.loads.paths[1].name = "check-" + study.loads.paths[0].name;
    CHECK_THAT(refusal<MismatchError>([&] { planned_paths(study); }), Contains("'" + study.loads.paths[1].name + "'"));
}

TEST_CASE("one of two training contacts that mirror each other is solved") {
    for (const PlannedPath& p : planned_paths(swept())) {
        if (p.role != "train") continue;
        // the surface runs counter-clockwise from the bottom right, so its first half is the right one
        CHECK(p.push.contact_m.x() >= 0.05 - tolerance::rounding);
        if (p.push.contact_m.x() < 0.05 + tolerance::rounding) {
            const Eigen::Vector2d middle(0.05, 0.1);
            CHECK(outline().angle(outline().arc_of(middle), p.push.direction) > -1e-6);
        }
    }
}

TEST_CASE("drawn contacts are at least 2 mm or 5 degrees from training contacts and their mirror images") {
    Study askew = swept();  // spaced from one end of the surface, so that mirror images lie between contacts
    askew.loads.sweep->spacing_m = 0.020;
    askew.loads.sweep->clearance_m = 0.015;
    for (Study::Draws& draws : askew.draws) draws.count = 200;
    for (const auto& [study, draws] : {std::pair(swept(), 50), std::pair(askew, 400)}) {
        const auto paths = planned_paths(study);
        int drawn = 0, near = 0;
        for (const PlannedPath& d : paths) {
            if (d.role == "train") continue;
            ++drawn;
            const double arc = outline().arc_of(d.push.contact_m);
            for (const PlannedPath& t : paths) {
                if (t.role != "train") continue;
                for (double sign : {1.0, -1.0}) {
                    const Eigen::Vector2d contact(sign > 0 ? t.push.contact_m.x() : 0.1 - t.push.contact_m.x(),
                                                  t.push.contact_m.y()),
                        push(sign * t.push.direction.x(), t.push.direction.y());
                    const double away = std::abs(outline().arc_of(contact) - arc);
                    const double degrees = std::acos(std::min(1.0, push.dot(d.push.direction))) * 180 / 3.14159265358979;
                    near += away >= 0.002 - 1e-9 || degrees >= 5 - 1e-6 ? 0 : 1;
                }
            }
        }
        CHECK(near == 0);
        CHECK(drawn == draws);
    }
}

TEST_CASE("contacts on a low block keep the sweep's clearance from both ends of the surface") {
    Study low = swept();
    low.geometry.height_m = 0.012;
    low.loads.sweep->spacing_m = 0.020;
    low.loads.sweep->clearance_m = 0.015;
    const Outline surface(make_lattice("grid4", low.lattice()));
    const auto paths = planned_paths(low);
    CHECK(paths.size() > 50);
    for (const PlannedPath& p : paths) {
        const double arc = surface.arc_of(p.push.contact_m);
        CHECK(arc >= 0.015 - tolerance::rounding);
        CHECK(arc <= surface.length() - 0.015 + tolerance::rounding);
    }
}

TEST_CASE("the same seed draws the same contacts and another seed draws others") {
    const auto one = planned_paths(swept()), same = planned_paths(swept());
    Study other = swept();
    other.draws[0].seed += 100;
    const auto moved = planned_paths(other);
    REQUIRE(one.size() == same.size());
    REQUIRE(one.size() == moved.size());
    int different = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
        CHECK(one[i].push.contact_m == same[i].push.contact_m);
        CHECK(one[i].depth_m == same[i].depth_m);
        different += one[i].push.contact_m == moved[i].push.contact_m ? 0 : 1;
    }
    CHECK(different >= 10);
}

TEST_CASE("a sweep of more than 10000 contacts is refused by key") {
    Study endless = swept();
    endless.loads.sweep->spacing_m = 1e-9;
    CHECK_THAT(refusal<MismatchError>([&] { planned_paths(endless); }), Contains("loads.sweep.spacing_m") && Contains("10000"));
}

TEST_CASE("a sweep whose clearance leaves no place on the surface is refused by key") {
    Study small = swept();
    small.loads.sweep->clearance_m = 0.16;  // from both ends of a surface of 0.3 m
    CHECK_THAT(refusal<MismatchError>([&] { planned_paths(small); }), Contains("loads.sweep.clearance_m") && Contains("0.16"));
}

TEST_CASE("a draw without room between the training contacts is refused by key") {
    Study crowded = swept();
    crowded.loads.sweep->spacing_m = 0.001;
    crowded.loads.sweep->angles_deg = {-6, -3, 0, 3, 6};
    for (Study::Draws& draws : crowded.draws) {
        draws.max_angle_deg = 5;
        draws.count = 100'000;  // refused as soon as for one: tries are counted for each contact
    }
    CHECK_THAT(refusal<MismatchError>([&] { planned_paths(crowded); }), Contains("draws."));
}
