#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <hdf5.h>
#include <map>
#include <set>
#include <sstream>

#include "../mesh/embedded_block.h"
#include "cases/plan.h"
#include "cases/solid_sweep.h"
#include "cases/study_energy_model.h"
#include "cases/study_mesh.h"
#include "error.h"
#include "../example.h"
#include "mesh/topology.h"
#include "../mutations.h"
#include "../refusal.h"
#include "../solid_example.h"
#include "../tolerances.h"
#include "cases/cases_table.h"
#include "version.h"

using namespace tissue;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const Study& solid() {
    static const Study study = example_study(solid_study_text());
    return study;
}

constexpr double degree = 3.14159265358979323846 / 180;

double wall_m(const Point& p) { return std::min({p[0], 0.1 - p[0], p[1], 0.08 - p[1]}); }
double tilt_deg(const Point& d) { return std::acos(std::clamp(-d[2], -1.0, 1.0)) / degree; }

/// The word that follows "-NAME" in a path's part.
std::string argument(const std::string& part, const std::string& name) {
    std::istringstream words(part);
    for (std::string word; words >> word;)
        if (word == "-" + name) {
            words >> word;
            return word;
        }
    return "";
}

/// Cases of the study's training paths and of one test path, with arbitrary fields.
Cases solid_cases() {
    Cases cases;
    cases.study = solid().name;
    cases.nodes = study_nodes(solid(), {});
    cases.magnitudes_m = solid().loads.magnitudes_m;
    for (const PlannedPath& p : planned_paths(solid())) {
        if (p.role != "train" && p.push.name != "held-out-0001") continue;
        cases.paths.push_back(path_as_solved(p, [&](int r) -> NodeField { return scattered(embedded_block(solid().lattice()), 1e-3 * r).topRows(cases.nodes.rows()); }));
    }
    return cases;
}

std::vector<std::string> names_of(const std::vector<LoadCase>& loads) {
    std::vector<std::string> names;
    for (const LoadCase& load : loads) names.push_back(load.name);
    return names;
}

}  // namespace

TEST_CASE("paths of a solid are its listed and drawn indentations and mesh checks of some test paths") {
    std::map<std::string, int> count;
    std::set<std::string> names;
    for (const PlannedPath& p : planned_paths(solid())) {
        ++count[p.role];
        CHECK(names.insert(p.push.name).second);
        CHECK(p.push.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos);
        CHECK(p.sizes_m == (p.role == "check" ? solid().check_sizes_m : solid().sizes_m));
        CHECK(p.push.depth_m == p.depth_m);
        CHECK(p.records == std::lround(std::ceil(p.depth_m / 0.002 - 1e-9)));
    }
    CHECK(count == std::map<std::string, int>{{"train", 4}, {"validation", 10}, {"held_out", 40}, {"held_out_near_a_wall", 20}, {"check", 20}});
    CHECK(names.count("held-out-near-a-wall-0020") == 1);
    CHECK(names.count("check-0020") == 1);
    Study unchecked = solid();
    unchecked.check_sizes_m = {};
    CHECK(planned_paths(unchecked).size() == 74);
}

TEST_CASE("a map has normal indentations row by row in a role of their own and a figure") {
    const Study mapped = example_study(solid_study_text() + "\n[map]\ndepth_m = 0.005\nx_m = [0.012, 0.06, 0.088]\ny_m = [0.04, 0.068]\n");
    std::vector<PlannedPath> paths;
    for (const PlannedPath& p : planned_paths(mapped))
        if (p.role == "map") paths.push_back(p);
    REQUIRE(paths.size() == 6);
    CHECK(planned_paths(mapped).size() == planned_paths(solid()).size() + 6);
    CHECK(paths[0].push.name == "map-0001");
    CHECK(paths[1].push.contact_m == Eigen::Vector3d(0.06, 0.04, 0.05));
    CHECK(paths[5].push.contact_m == Eigen::Vector3d(0.088, 0.068, 0.05));
    for (const PlannedPath& p : paths) {
        CHECK(p.push.direction == Eigen::Vector3d(0, 0, -1));
        CHECK(p.depth_m == 0.005);
        CHECK(p.records == 3);
    }
    CHECK_THAT(make_plan(mapped).fragment, Contains("FIGURES := held_out held_out_force shape solid map\n"));
    CHECK_THAT(make_plan(solid()).fragment, Contains("FIGURES := held_out held_out_force shape solid\n"));
}

TEST_CASE("a nodule in a block stiffens cells by their fraction inside and its points have its volume") {
    const SpringMesh mesh = study_mesh(solid(), {}, "embedded");
    const Cells cells = mesh_cells(mesh);
    const double E = 6 * 754.0, volume_m3 = std::pow(0.0125, 3);
    const Eigen::VectorXd moduli = solid_moduli(solid(), {}, mesh, cells);
    CHECK(moduli.minCoeff() == Approx(E));
    // sampled at 64 points per cell
    CHECK(((moduli.array() / E - 1) / (18000 / E - 1)).sum() * volume_m3 == Approx(4.0 / 3 * 3.14159265 * std::pow(0.008, 3)).epsilon(0.3));
    const NodeField points = nodule_points(solid());
    CHECK(points.col(3).sum() == Approx(std::log(18000 / E) * 4.0 / 3 * 3.14159265 * std::pow(0.008, 3)).epsilon(1e-6));
    CHECK((points.leftCols(3).colwise().mean().transpose() - solid().nodule->inclusion.centre_m()).norm() < 1e-12);
    CHECK((points.leftCols(3).rowwise() - solid().nodule->inclusion.centre_m().transpose()).rowwise().norm().maxCoeff() < 0.008);

    Study other = solid();
    other.springs.terms = {"spring.nodule", "cell.nodule", "contact.normal.ground"};
    const EnergyModelTerms model_terms = study_energy_model(other, {}, mesh);
    Eigen::VectorXd p = Eigen::VectorXd::Zero(3);
    const Eigen::VectorXd before = model_terms.constants(p);
    p << 1, 0, 0;
    const Eigen::VectorXd ratio = model_terms.constants(p).cwiseQuotient(before).head(mesh.spring_count());
    CHECK((ratio - solid_moduli(solid(), {}, mesh, mesh.springs) / E).norm() < 1e-9);  // exp(1 log(E / E_block))
    CHECK(model_terms.ground() == points);
    other.nodule.reset();
    for (const char* term : {"spring.nodule", "cell.nodule", "contact.hardening.ground"}) {
        other.springs.terms = {"spring.all", term};
        CHECK_THAT(refusal<MismatchError>([&] { study_energy_model(other, {}, mesh); }), Contains(std::string("term '") + term + "' is zero everywhere"));
    }
}

TEST_CASE("an Ogden solid has the springs of a Mooney-Rivlin solid with the same shear modulus") {
    const std::string mooney = "law = \"mooney-rivlin\"\nC1_Pa = 263.0\nC2_Pa = 491.0", own = "C1_Pa = 1000.0\nC2_Pa = 2000.0";
    const Study ogden = example_study(with(with(solid_study_text(), mooney, "law = \"ogden\"\nmu_Pa = [400, -227]\nalpha = [4, -6.23788546255507]"), own,
                                           "mu_Pa = [1500, -2000]\nalpha = [4, -3]"));
    REQUIRE(ogden.material.youngs_modulus_Pa() == Approx(6 * 754));
    REQUIRE(ogden.nodule->youngs_modulus_Pa() == Approx(18000));
    const SpringMesh mesh = study_mesh(solid(), {}, "embedded");
    const Eigen::VectorXd theirs = study_energy_model(solid(), {}, mesh).constants(Eigen::VectorXd::Zero(2));
    CHECK((study_energy_model(ogden, {}, mesh).constants(Eigen::VectorXd::Zero(2)) - theirs).norm() < 1e-9 * theirs.norm());
    const std::string part = make_plan(ogden).parts.at("path-" + ogden.loads.paths[0].name);
    CHECK_THAT(part, Contains(" -law ogden -terms 2 -mu1 400 -alpha1 4 -mu2 -227 -alpha2 -6.2") &&
                         Contains(" -mu1_11 1500 -alpha1_11 4 -mu2_11 -2000 -alpha2_11 -3 "));
    CHECK(part.find("-C1") == std::string::npos);
}

TEST_CASE("contacts drawn on a solid block lie on its top within the ranges of their role") {
    for (const PlannedPath& p : planned_paths(solid()))
        for (const Study::Draws& d : solid().draws) {
            if (p.role != d.role) continue;
            INFO(p.push.name);
            CHECK(p.push.contact_m[2] == 0.05);
            CHECK(wall_m(p.push.contact_m) >= d.clearance_m[0]);
            CHECK(wall_m(p.push.contact_m) <= d.clearance_m[1]);
            CHECK(p.push.direction.norm() == Approx(1).epsilon(tolerance::rounding));
            CHECK(tilt_deg(p.push.direction) >= d.tilt_deg[0] - 1e-6);
            CHECK(tilt_deg(p.push.direction) <= d.tilt_deg[1] + 1e-6);
            CHECK(p.depth_m >= d.depth_m[0]);
            CHECK(p.depth_m <= d.depth_m[1]);
            if (d.tilt_deg[0] == 90) CHECK(p.push.direction[2] == 0);
        }
}

TEST_CASE("contacts drawn on a solid block are uniform over its top and in solid angle") {
    Study many = solid();
    many.draws.resize(1);
    many.draws[0].count = 20000;
    many.draws[0].clearance_m[0] = 0.012;
    many.draws[0].tilt_deg[1] = 60;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero(), push = Eigen::Vector2d::Zero();
    double cosine = 0, near = 0, count = 0;
    for (const PlannedPath& p : planned_paths(many)) {
        if (p.role == "train") continue;
        mean += p.push.contact_m.head(2);
        push += p.push.direction.head(2);
        cosine += -p.push.direction[2];
        near += wall_m(p.push.contact_m) < 0.02;
        ++count;
    }
    CHECK(count == 20000);
    CHECK((mean / count - Eigen::Vector2d(0.05, 0.04)).norm() < 0.001);  // standard error 0.2 mm
    CHECK((push / count).norm() < 0.02);
    CHECK(cosine / count == Approx(0.75).margin(0.005));  // mean of a cosine that is uniform between 1/2 and 1
    CHECK(near / count == Approx(1 - 60.0 * 40 / (76 * 56)).margin(0.015));

    many.draws[0].count = 200;
    many.draws[0].clearance_m[1] = 0.014;  // along all four walls
    int at[4] = {};
    for (const PlannedPath& p : planned_paths(many)) {
        if (p.role == "train") continue;
        const double wall[4] = {p.push.contact_m[0], 0.1 - p.push.contact_m[0], p.push.contact_m[1], 0.08 - p.push.contact_m[1]};
        ++at[std::min_element(wall, wall + 4) - wall];
    }
    for (int beside : at) CHECK(beside > 25);
}

TEST_CASE("contacts drawn on a solid are 2 mm or 5 degrees from training contacts or refused by role") {
    Study crowded = solid();
    crowded.draws.resize(1);
    crowded.draws[0].tilt_deg[1] = 3;
    crowded.draws[0].count = 3000;
    int turned_near = 0;
    for (const PlannedPath& p : planned_paths(crowded)) {
        if (p.role == "train") continue;
        for (const StudyPath& t : crowded.loads.paths) {
            const bool near = (t.contact_m - p.push.contact_m).norm() < 0.002;
            const double angle = std::acos(std::clamp(t.direction.dot(p.push.direction), -1.0, 1.0)) / degree;
            CHECK((!near || angle >= 5));
            turned_near += near;
        }
    }
    CHECK(turned_near == 0);  // a normal indentation is trained at each of these places
    crowded.loads.paths.clear();
    for (double x = 0.02; x < 0.081; x += 0.002)
        for (double y = 0.02; y < 0.061; y += 0.002) crowded.loads.paths.push_back({"t", Eigen::Vector3d(x, y, 0.05), Eigen::Vector3d(0, 0, -1), 0.01, crowded.indenter.radius_m});
    crowded.draws[0].count = 100'000;  // refused as soon as for one
    CHECK_THAT(refusal<MismatchError>([&] { solid_paths(crowded); }), StartsWith("draws.validation: ") && Contains("no space"));
}

TEST_CASE("draws of a solid depend on the seed of their role and not on other roles or meshes") {
    Study other = solid();
    other.draws[0].seed = 77;
    other.check_sizes_m = {};
    const auto before = planned_paths(solid()), after = planned_paths(other);
    for (std::size_t i = 0; i < after.size(); ++i) {
        CHECK(after[i].push.name == before[i].push.name);
        CHECK((after[i].push.contact_m == before[i].push.contact_m) == (after[i].role != "validation"));
    }
}

TEST_CASE("too short or too long edges of the lattice of a block are refused by key in planning") {
    for (const double edge_m : {1e-7, 0.4}) {
        Study study = solid();
        study.springs.spacing_m = edge_m;
        CHECK_THAT(refusal<StudyError>([&] { make_plan(study); }), StartsWith(study.file) && Contains("key 'springs.spacing_m': a lattice of"));
    }
}

TEST_CASE("the plan of a solid block gives each path its arguments and mesh sizes without a common mesh") {
    const Plan plan = make_plan(solid());
    CHECK(plan.parts.size() == 2 + 94);
    CHECK_THAT(plan.fragment, Contains("SOLID := fem/block3.geo\n"));
    CHECK(plan.fragment.find("mesh.msh") == std::string::npos);
    const StudyPath& push = solid().loads.paths[1];
    const std::string& part = plan.parts.at("path-" + push.name);
    CHECK_THAT(plan.fragment, Contains("$(R)/cases/" + push.name + ".csv: PATH_ARGUMENTS = " + part) &&
                                  Contains("$(R)/cases/" + push.name + ".csv: $(R)/plan/path-" + push.name + " scripts/run_gmsh fem/block3.geo\n"));
    CHECK_THAT(part, StartsWith("-geo fem/block3.geo "));
    const auto number = [&](const std::string& name) {
        const std::string word = argument(part, name);
        CHECK_FALSE(word.empty());
        return std::strtod(word.c_str(), nullptr);
    };
    CHECK(number("width") == 0.1);
    CHECK(number("length") == 0.08);
    CHECK(number("height") == 0.05);
    CHECK(argument(part, "cells_x") + argument(part, "cells_y") + argument(part, "cells_z") == "543");
    CHECK(number("size_near") == 0.005);
    CHECK(number("size_far") == 0.02);
    CHECK(number("C1") == 263);
    CHECK(number("C2") == 491);
    CHECK(number("nodule_z") == 0.025);
    CHECK(number("nodule_radius") == 0.008);
    CHECK(number("C1_11") == 1000);
    CHECK(number("C2_11") == 2000);
    const char* axes[] = {"x", "y", "z"};
    for (int a : {0, 1, 2}) {
        CHECK(number(std::string("contact_") + axes[a]) == push.contact_m[a]);
        CHECK(number(std::string("direction_") + axes[a]) == push.direction[a]);  // to the bit
    }
    CHECK(number("disc_radius") == 0.007);
    CHECK(number("depth") == 0.01);
    CHECK(number("records") == 5);
    CHECK(number("tolerance") == 1e-9);
    CHECK(number("max_newton") == 12);
    CHECK(number("allow_lost") == 1);
    CHECK(argument(plan.parts.at("path-check-0001"), "size_near") == "0.004");
    CHECK(argument(plan.parts.at("path-check-0001"), "depth") == argument(plan.parts.at("path-held-out-0001"), "depth"));
    const std::string& text = solid_study_text();
    const Plan even = make_plan(example_study(text.substr(0, text.find("[nodule]"))));
    CHECK(even.parts.at("path-" + push.name).find("nodule") == std::string::npos);
    CHECK(even.parts.at("train") != plan.parts.at("train"));
}

TEST_CASE("depths and mesh size of an indentation scale with its disc radius in plan and cases") {
    const std::string own = "at_m = [0.012, 0.015]", drawn = "[draws.validation]";
    const std::string text = with(with(solid_study_text(), own, own + ", radius_m = 0.0035"), drawn, drawn + "\nradii_m = [0.007, 0.0035]");
    const Study study = example_study(text);
    const Plan plan = make_plan(study);
    const auto number = [&](const std::string& part, const std::string& name) { return std::strtod(argument(plan.parts.at(part), name).c_str(), nullptr); };
    const std::string part = "path-x0120-y0150-t00-a000-r035";
    CHECK(number(part, "disc_radius") == 0.0035);
    CHECK(number(part, "depth") == 0.005);
    CHECK(number(part, "records") == 5);
    CHECK(number(part, "size_near") == 0.0025);
    CHECK(number(part, "size_far") == 0.02);
    CHECK(number("path-validation-0001", "disc_radius") == 0.007);
    CHECK(number("path-validation-0002", "disc_radius") == 0.0035);
    const Plan before = make_plan(solid());
    CHECK(plan.parts.at("path-validation-0001") == before.parts.at("path-validation-0001"));  // the same draws
    CHECK(number("path-validation-0002", "depth") == 0.5 * std::strtod(argument(before.parts.at("path-validation-0002"), "depth").c_str(), nullptr));

    CHECK_THAT(refusal<StudyError>([&] { make_plan(example_study(with(text, "radii_m = [0.007, 0.0035]", "radii_m = [0.003]"))); }),
               Contains("key 'draws.validation.radii_m'") && Contains("3 mm must be between the radii of the training contacts, 3.5 and 7 mm"));
    std::string none_own = solid_study_text();
    for (std::size_t at = 0; (at = none_own.find("pushes_deg", at)) != std::string::npos; at += 30) none_own.insert(at, "radius_m = 0.006, ");
    CHECK_THAT(refusal<StudyError>([&] { make_plan(example_study(none_own)); }), Contains("key 'indenter.radius_m'") && Contains("7 mm must be between"));
    const std::string term = "\"spring.all\"";
    CHECK_NOTHROW(make_plan(example_study(with(text, term, term + ", \"contact.hardening.size\""))));
    CHECK_THAT(refusal<StudyError>([&] { make_plan(example_study(with(solid_study_text(), term, term + ", \"contact.hardening.size\""))); }),
               Contains("key 'springs.terms'") && Contains("several radii"));

    Cases cases = solid_cases();
    cases.disc_radius_m = 0.007;
    cases.paths[0].radius_m = 0.0035;
    cases.paths[0].depth_m = 0.005;
    CHECK(load_magnitudes(cases, cases.paths[0]) == std::vector<double>{0.002, 0.005});
    for (PathRecord& record : cases.paths[0].records) record.magnitude_m /= 2;
    const TemporaryFolder folder;
    const std::string file = folder.file("cases.h5");
    write_cases(file, cases, {"tissuectl test", 0, {}});
    CHECK(Hdf5Reader(file, "cases").number_attribute("/", "format_version") == radii_format_version);
    const Cases after = read_cases(file);
    CHECK(after.disc_radius_m == 0.007);
    CHECK(after.paths[0].radius_m == 0.0035);
    CHECK(after.paths[1].radius_m == 0);
    CHECK(names_of(load_cases(after))[0] == "x0500-y0400-t00-a000-2mm");
    // a variant keeps the disc radii
    CHECK(names_of(load_cases(thinned(solid(), after, solid().whole()))) == names_of(load_cases(after)));
}

TEST_CASE("drawn disc pairs keep their distance at rest and two radii when displaced; FE gets both discs") {
    const std::string role = "[draws.held_out_near_a_wall]";
    const Study study = example_study(with(solid_study_text(), role + "\nseed = 3\ncount = 20\ndepth_m = [0.001, 0.003]\ntilt_deg = [90, 90]\nclearance_m = [0.012, 0.02]",
                                           "[draws.held_out_two]\nseed = 3\ncount = 60\ndepth_m = [0.002, 0.008]\ntilt_deg = [0, 30]\nclearance_m = [0.012, 0.04]\napart_m = [0.015, 0.050]"));
    std::vector<PlannedPath> pairs, others;
    for (const PlannedPath& p : planned_paths(study)) (p.role == "held_out_two" ? pairs : others).push_back(p);
    for (const PlannedPath& p : others) CHECK_FALSE(p.push.second);
    REQUIRE(pairs.size() == 60);
    CHECK(pairs[0].push.name == "held-out-two-0001");
    double least = 1, most = 0, shallowest = 1, deepest = 0;
    for (const PlannedPath& p : pairs) {
        REQUIRE(p.push.second);
        const SecondTool& second = *p.push.second;
        CHECK(second.contact_m[2] == 0.05);
        CHECK(wall_m(second.contact_m) >= 0.012 - 1e-12);
        CHECK(wall_m(p.push.contact_m) >= 0.012 - 1e-12);
        CHECK(tilt_deg(second.direction) <= 30 + 1e-6);
        CHECK(second.direction.norm() == Approx(1).epsilon(tolerance::rounding));
        CHECK(second.direction != p.push.direction);
        const double apart_m = (second.contact_m - p.push.contact_m).norm();
        CHECK((second.contact_m + second.depth_m * second.direction - p.push.contact_m - p.push.depth_m * p.push.direction).norm() >= 0.014);
        least = std::min(least, apart_m);
        most = std::max(most, apart_m);
        shallowest = std::min(shallowest, second.depth_m);
        deepest = std::max(deepest, second.depth_m);
    }
    CHECK(least >= 0.015);
    CHECK(least < 0.018);
    CHECK(most <= 0.050);
    CHECK(most > 0.045);
    CHECK(shallowest >= 0.002);
    CHECK(deepest <= 0.008);
    CHECK(deepest > 0.006);

    const std::string part = make_plan(study).parts.at("path-held-out-two-0001");
    const SecondTool& second = *pairs[0].push.second;
    CHECK(std::stod(argument(part, "second_x")) == second.contact_m[0]);
    CHECK(std::stod(argument(part, "second_z")) == 0.05);
    CHECK(std::stod(argument(part, "second_direction_y")) == second.direction[1]);
    CHECK(std::stod(argument(part, "second_depth")) == second.depth_m);
    CHECK(argument(make_plan(study).parts.at("path-held-out-0001"), "second_depth").empty());
    CHECK(make_plan(study).parts.at("path-held-out-0001") == make_plan(solid()).parts.at("path-held-out-0001"));

    const Study narrow = example_study(with(solid_study_text(), role, "[draws.held_out_two]\napart_m = [0.1, 0.2]"));
    CHECK_THAT(refusal<MismatchError>([&] { planned_paths(narrow); }), Contains("draws.held_out_two: clearance_m leaves no space for two discs apart_m apart"));
}

TEST_CASE("a two-disc path is read back unchanged from a file of a later format version") {
    const TemporaryFolder folder;
    const std::string file = folder.file("cases.h5");
    Cases cases = solid_cases();
    write_cases(file, cases, {"tissuectl test", 0, {}});
    for (const std::string& dataset : Hdf5Reader(file, "cases").datasets()) CHECK_THAT(dataset, !Contains("second"));
    CHECK(Hdf5Reader(file, "cases").number_attribute("/", "format_version") == solid_format_version);
    LoadPath& pair = cases.paths.back();
    pair.role = "held_out_two";
    pair.second = SecondTool{Eigen::Vector3d(0.03, 0.05, 0.05), Eigen::Vector3d(0.6, 0, -0.8), pair.depth_m / 2};
    for (std::size_t r = 0; r < pair.records.size(); ++r) pair.records[r].second_force_N = Eigen::Vector3d(0.1, -0.2, -1.0 * static_cast<double>(r));
    write_cases(file, cases, {"tissuectl test", 0, {}});
    CHECK(Hdf5Reader(file, "cases").number_attribute("/", "format_version") == two_tools_format_version);
    const LoadPath back = read_cases(file).paths.back();
    REQUIRE(back.second);
    CHECK(back.second->contact_m == pair.second->contact_m);
    CHECK(back.second->direction == pair.second->direction);
    CHECK(back.second->depth_m == pair.second->depth_m);
    REQUIRE(back.records.size() == pair.records.size());
    for (std::size_t r = 0; r < back.records.size(); ++r) CHECK(back.records[r].second_force_N == pair.records[r].second_force_N);
    CHECK((back.second_push_m(back.records.back()) - pair.depth_m / 2 * pair.second->direction).norm() < tolerance::rounding);

    Cases trained = cases;
    trained.paths.back().role = "train";
    write_cases(file, trained, {"tissuectl test", 0, {}});
    CHECK_THAT(refusal<FileError>([&] { read_cases(file); }), Contains("second_contact") && Contains("'train'"));
    for (const char* dataset : {"second_contact", "second_direction", "second_depth", "second_force"}) {
        write_cases(file, cases, {"tissuectl test", 0, {}});
        const std::string name = "/paths/" + cases.paths.back().name + "/" + dataset;
        INFO(name);
        const hid_t h = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
        H5Ldelete(h, name.c_str(), H5P_DEFAULT);
        H5Fclose(h);
        CHECK_THAT(refusal<FileError>([&] { read_cases(file); }), Contains(std::string("second_")));
    }
}

TEST_CASE("a training path in space is a load case at every magnitude up to its depth") {
    Cases cases = solid_cases();
    CHECK(names_of(load_cases(cases)) ==
          std::vector<std::string>{"x0500-y0400-t00-a000-4mm", "x0500-y0400-t00-a000-10mm", "x0500-y0400-t30-a270-4mm",
                                   "x0500-y0400-t30-a270-10mm", "x0120-y0150-t00-a000-4mm", "x0120-y0150-t00-a000-10mm",
                                   "x0500-y0400-t90-a090-3mm"});
    LoadPath path = cases.paths[0];
    path.depth_m = 0.008;
    CHECK(load_magnitudes(cases, path) == std::vector<double>{0.004, 0.008});
    path.depth_m = 0.004;
    CHECK(load_magnitudes(cases, path) == std::vector<double>{0.004});
    cases.magnitudes_m = {0.004};  // as in a variant
    path.depth_m = 0.010;
    CHECK(load_magnitudes(cases, path) == std::vector<double>{0.004});
    path.direction = Eigen::Vector2d(0, -1);  // in the plane the magnitudes of the cases
    path.depth_m = 0.003;
    CHECK(load_magnitudes(cases, path) == std::vector<double>{0.004});
}

TEST_CASE("a variant of a solid keeps its first training paths and every drawn path") {
    const Cases cases = solid_cases();
    Study::Variant few = solid().whole();
    few.first_paths = 2;
    few.magnitudes_m = {0.004};
    const Cases kept = thinned(solid(), cases, few);
    REQUIRE(kept.paths.size() == 3);
    CHECK(kept.paths[1].name == solid().loads.paths[1].name);
    CHECK(kept.paths[2].role == "held_out");
    CHECK(kept.magnitudes_m == few.magnitudes_m);
    CHECK(thinned(solid(), cases, solid().whole()).paths.size() == cases.paths.size());
}

TEST_CASE("cases in space are read back unchanged from a file of a later format version") {
    const TemporaryFolder folder;
    const std::string file = folder.file("cases.h5");
    const Cases cases = solid_cases();
    write_cases(file, cases, {"tissuectl test", 0, {}});
    CHECK(Hdf5Reader(file, "cases").number_attribute("/", "format_version") == solid_format_version);
    CHECK(solid_format_version > energy_model_format_version);
    const Cases after = read_cases(file);
    CHECK(after.nodes == cases.nodes);
    REQUIRE(after.paths.size() == cases.paths.size());
    for (std::size_t i = 0; i < cases.paths.size(); ++i) {
        CHECK(after.paths[i].contact_m == cases.paths[i].contact_m);
        CHECK(after.paths[i].direction == cases.paths[i].direction);
        CHECK(after.paths[i].records.back().displacement == cases.paths[i].records.back().displacement);
        CHECK(after.paths[i].records.back().force == cases.paths[i].records.back().force);
        CHECK(after.paths[i].records.back().contact_force_N == cases.paths[i].records.back().contact_force_N);
    }
    write_cases(file, example_cases(example_study(), example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1))), {"tissuectl test", 0, {}});
    CHECK(Hdf5Reader(file, "cases").number_attribute("/", "format_version") == format_version);
    CHECK_FALSE(Hdf5Reader(file, "cases").has_attribute("/", "dimension"));
}

TEST_CASE("cases with a dimension other than 2 or 3 or than that of their nodes are refused") {
    const TemporaryFolder folder;
    const std::string file = folder.file("cases.h5");
    const auto said = [&](double dimension) {
        write_cases(file, solid_cases(), {"tissuectl test", 0, {}});
        const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), attribute = H5Aopen(id, "dimension", H5P_DEFAULT);
        REQUIRE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &dimension) >= 0);
        H5Aclose(attribute);
        H5Fclose(id);
        return refusal<FileError>([&] { read_cases(file); });
    };
    for (double wrong : {1.0, 4.0, 2.5, -3.0, std::nan("")}) CHECK_THAT(said(wrong), Contains("cases.h5: /: ") && Contains("must be 2 or 3"));
    CHECK_THAT(said(2), Contains("cases.h5: /nodes"));

    Cases shaped = solid_cases();
    shaped.shape = shape_of(make_lattice("grid4", 4, 4, 0.1, 0.1));
    write_cases(file, shaped, {"tissuectl test", 0, {}});
    CHECK_THAT(refusal<FileError>([&] { read_cases(file); }), Contains("cases.h5: /shape") && Contains("plane"));
}

TEST_CASE("cases in space with one altered dataset are refused in one line or are valid") {
    const TemporaryFolder folder;
    const std::string whole = folder.file("whole.h5");
    Cases cases = solid_cases();
    cases.paths.erase(cases.paths.begin() + 1, cases.paths.end() - 1);
    write_cases(whole, cases, {"tissuectl test", 0, {}});
    CHECK(refused_mutations(whole, cases_table(false), read_load_cases) > 50);
}

TEST_CASE("relative moduli are those of the material and stiffness-weighted means in springs that cross a nodule") {
    Study s = solid();
    REQUIRE(s.nodule);
    const SpringMesh mesh = study_mesh(s, {}, s.springs.topology);
    CHECK(study_relaxation(s, {}, mesh, study_energy_model(s, {}, mesh)).empty());
    s.material.viscosity = {{0.3, 0.05}, {0.2, 1}};
    s.material.share = {0.3, 0.2};
    s.nodule->share = s.material.share;
    const EnergyModelTerms model_terms = study_energy_model(s, {}, mesh);
    const Relaxation even = study_relaxation(s, {}, mesh, model_terms);
    const Eigen::Index elements = model_terms.energy(mesh).constant_count() - mesh.support_count();  // supports do not relax
    CHECK(even.tau_s == Eigen::Vector2d(0.05, 1));
    CHECK(even.contact_share == Eigen::Vector2d(0.3, 0.2));
    CHECK(even.share.rows() == model_terms.energy(mesh).constant_count());
    CHECK((even.share.col(0).head(elements).array() == 0.3).all());

    s.nodule->share = {0.1, 0.2};
    const Relaxation own = study_relaxation(s, {}, mesh, model_terms);
    CHECK((own.share.col(1).head(elements).array() == 0.2).all());
    const Eigen::VectorXd inside = fraction_inside(mesh, mesh.springs, s.nodule->inclusion);
    CHECK(inside.maxCoeff() > 0.3);
    const double E = s.material.youngs_modulus_Pa(), hard = s.nodule->youngs_modulus_Pa();
    for (Eigen::Index i = 0; i < inside.size(); ++i) {
        const double in = inside[i] * hard, out = (1 - inside[i]) * E;
        REQUIRE(own.share(i, 0) == Approx((0.1 * in + 0.3 * out) / (in + out)).epsilon(1e-9));
    }
    CHECK(own.contact_share == even.contact_share);
}
