#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <fmt/format.h>

#include "cases/cases_table.h"
#include "cases/plan.h"
#include "cases/solid_training.h"
#include "cases/study_energy_model.h"
#include "cases/study_mesh.h"
#include "cases/sweep.h"
#include "error.h"
#include "mesh/cells.h"
#include "mesh/solid_block.h"
#include "springs/supports.h"
#include "train/untrained_model.h"
#include "../example.h"
#include "../mesh/ball.h"
#include "../mutations.h"
#include "../refusal.h"
#include "../solid_shape_study.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

constexpr double degree = 3.14159265358979323846 / 180;

const Study& study() {
    static const Study s = shape_study();
    return s;
}

const std::optional<Shape>& shape() {
    static const std::optional<Shape> s = dome();
    return s;
}

Study spread_study(int count, double clearance_m = 0.015, int each = 3) {
    Study s = study();
    s.loads.contacts.clear();
    s.loads.spread = Study::Loads::Spread{count, clearance_m, {{0, 0}, {30, 0}, {30, 180}}, each};
    return s;
}

/// A spherical inclusion four times as stiff as the base material.
Study::Nodule stone() {
    Study::Nodule nodule{{}, Inclusion(Eigen::Vector3d(0.01, 0.0, 0.03), 0.009), {}};
    nodule.C1_Pa = 4 * (263 + 491);
    return nodule;
}

double tilt_deg(const FreeSurface& surface, const StudyPath& p) {
    return std::acos(std::clamp(surface.nearest(p.contact_m).inward.dot(p.direction), -1.0, 1.0)) / degree;
}

Cases dome_cases() {
    Cases cases;
    cases.study = study().name;
    cases.shape = shape();
    cases.nodes = study_nodes(study(), shape());
    cases.magnitudes_m = study().loads.magnitudes_m;
    for (const PlannedPath& p : planned_paths(study(), shape())) {
        if (p.role != "train" && p.push.name != "held-out-0001") continue;
        cases.paths.push_back(path_as_solved(p, [&](int r) -> NodeField { return NodeField::Constant(cases.nodes.rows(), 3, 1e-4 * r); }));
    }
    return cases;
}

}  // namespace

TEST_CASE("listed contacts of a solid shape move to its surface and are tilted from its inward normal", "[solid_shape]") {
    const FreeSurface surface = study_surface(study(), shape());
    const std::vector<StudyPath> paths = solid_training(study(), shape());
    REQUIRE(paths.size() == 5);
    CHECK(paths[0].name == "c01-t00-a000");
    CHECK(paths[1].name == "c01-t30-a270");
    CHECK(paths[4].name == "c02-t30-a180");
    for (const StudyPath& p : paths) {
        CHECK(surface.nearest(p.contact_m).distance_m < 1e-12);
        CHECK(p.direction.norm() == Approx(1).epsilon(tolerance::rounding));
    }
    CHECK(tilt_deg(surface, paths[0]) < 1e-4);
    CHECK(tilt_deg(surface, paths[1]) == Approx(30).epsilon(1e-6));
    CHECK(paths[2].contact_m == paths[3].contact_m);
    CHECK(paths[2].depth_m == 0.003);
    const auto moved = [](const Eigen::Vector3d& at) {
        Study s = study();
        s.loads.contacts[1].at_m = at;
        return refusal<StudyError>([&] { solid_training(s, shape()); });
    };
    CHECK_THAT(moved({0, 0, 0.07}), Contains("example.toml: key 'loads.contacts[1].at_m': (0, 0, 0.07) m is ") && Contains("from the free surface"));
    CHECK_THAT(moved({0.049, 0, 0.005}), Contains("key 'loads.contacts[1].at_m'") && Contains("needs 12 mm"));
}

TEST_CASE("spread contacts are more than 20 mm apart and keep their clearance while azimuths rotate", "[solid_shape]") {
    const Study s = spread_study(10);
    const FreeSurface surface = study_surface(s, shape());
    const std::vector<StudyPath> paths = solid_training(s, shape());
    REQUIRE(paths.size() == 30);
    std::set<std::string> names;
    for (const StudyPath& p : paths) {
        CHECK(surface.clearance_m(p.contact_m) >= 0.015);
        CHECK(tilt_deg(surface, p) == Approx(p.name[5] == '0' ? 0 : 30).margin(1e-4));
        CHECK(names.insert(p.name).second);
    }
    double nearest = 1;
    for (std::size_t i = 0; i < 30; i += 3)
        for (std::size_t j = 0; j < i; j += 3) nearest = std::min(nearest, (paths[i].contact_m - paths[j].contact_m).norm());
    CHECK(nearest > 0.02);
    CHECK(paths[0].contact_m[2] > 0.045);  // the first one at the top, farthest from the edge
    CHECK(paths[1].name == "c01-t30-a000");
    CHECK(paths[4].name == "c02-t30-a138");
    CHECK(paths[8].name == "c03-t30-a095");  // 2 x 137.508 + 180 - 360
    const std::vector<StudyPath> again = solid_training(s, shape());
    for (std::size_t i = 0; i < 30; ++i) CHECK(again[i].contact_m == paths[i].contact_m);
    // further contacts are appended
    CHECK(solid_training(spread_study(4), shape())[9].contact_m == paths[9].contact_m);
    const std::vector<StudyPath> in_turn = solid_training(spread_study(4, 0.015, 2), shape());
    REQUIRE(in_turn.size() == 8);
    const std::vector<int> same{0, 1, 5, 3, 7, 8, 9, 10};  // directions 1 2, 3 1, 2 3, 1 2 of the four contacts
    for (std::size_t i = 0; i < 8; ++i) CHECK((in_turn[i].contact_m == paths[static_cast<std::size_t>(same[i])].contact_m && in_turn[i].direction == paths[static_cast<std::size_t>(same[i])].direction));
    CHECK_THAT(refusal<StudyError>([&] { solid_training(spread_study(2, 0.09), shape()); }), Contains("key 'loads.spread': the free surface has 0 places 90 mm"));
}

TEST_CASE("contacts drawn on a solid shape are uniform by area within the ranges of their role", "[solid_shape]") {
    const FreeSurface surface = study_surface(study(), shape());
    std::map<std::string, int> count;
    for (const PlannedPath& p : planned_paths(study(), shape())) {
        ++count[p.role];
        CHECK(p.sizes_m == (p.role == "check" ? study().check_sizes_m : study().sizes_m));
        if (p.role == "train") continue;
        const double clearance_m = surface.clearance_m(p.push.contact_m), tilt = tilt_deg(surface, p.push);
        CHECK(surface.nearest(p.push.contact_m).distance_m < 1e-12);
        CHECK(clearance_m >= (p.role == "validation" ? 0.015 : 0.012));
        CHECK(clearance_m <= (p.role == "validation" ? 0.2 : 0.03));
        CHECK(tilt >= (p.role == "validation" ? 0 : 10) - 1e-6);
        CHECK(tilt <= 30 + 1e-6);
        CHECK(p.depth_m <= 0.008);
    }
    CHECK(count == std::map<std::string, int>{{"train", 5}, {"validation", 10}, {"held_out", 40}, {"check", 20}});
    Study many = study();
    many.draws.resize(1);
    many.draws[0].count = 1000;
    many.draws[0].clearance_m[0] = 0.012;
    double high = 0, east = 0, all = 0, area_high = 0, area = 0;
    // centroids of 9 equal parts of each facet, weighted by the area of the facet
    for (const Point& p : surface.points(3)) {
        const double part = surface.measure()[surface.nearest(p).facet];
        if (surface.clearance_m(p) < 0.012) continue;
        area += part;
        area_high += part * (p[2] > 0.035);
    }
    Eigen::Vector3d aside = Eigen::Vector3d::Zero();
    for (const PlannedPath& p : planned_paths(many, shape())) {
        if (p.role == "train") continue;
        high += p.push.contact_m[2] > 0.035;
        east += p.push.contact_m[0] > 0;
        aside += p.push.direction - surface.nearest(p.push.contact_m).inward * surface.nearest(p.push.contact_m).inward.dot(p.push.direction);
        ++all;
    }
    CHECK(all == 1000);
    CHECK(high / all == Approx(area_high / area).margin(0.04));
    CHECK(east / all == Approx(0.5).margin(0.04));
    CHECK((aside / all).norm() < 0.03);
    Study other = study();
    other.draws[0].seed = 77;
    const auto before = planned_paths(study(), shape()), after = planned_paths(other, shape());
    for (std::size_t i = 0; i < after.size(); ++i)
        CHECK((after[i].push.contact_m == before[i].push.contact_m) == (after[i].role != "validation"));
    other.draws[0].clearance_m[0] = 0.09;
    CHECK_THAT(refusal<MismatchError>([&] { planned_paths(other, shape()); }), StartsWith("draws.validation: clearance_m"));
}

TEST_CASE("without a mesh the plan of a solid shape only asks for the mesh", "[solid_shape]") {
    const Plan first = make_plan(study());
    CHECK(first.parts.size() == 1);
    CHECK_THAT(first.fragment, Contains("SHAPE_ARGUMENTS := -3 -clmin 10 -clmax 10\n") && Contains("$(R)/plan.mk: $(R)/mesh.msh\n"));
}

TEST_CASE("the plan passes exact arguments in order for each path of a solid shape", "[solid_shape]") {
    Study s = study();
    s.geometry.shape = "fem/dome.geo";
    s.name = "dome";
    s.material.regions = {{{}, "stone"}};
    s.material.regions[0].C1_Pa = 8000;
    const Plan plan = make_plan(s, shape());
    const StudyPath p = solid_training(s, shape())[1];
    const std::string& part = plan.parts.at("path-" + p.name);
    CHECK(part == fmt::format("-shape fem/dome.geo -unit_m 0.001 -fixed bed -regions stone -springs mesh.msh -size_near 0.005 -size_far 0.02 -C1 263 -C2 491 "
                              "-C1_11 8000 -C2_11 0 -contact_x {} -contact_y {} -contact_z {} -direction_x {} -direction_y {} -direction_z {} "
                              "-disc_radius 0.007 -depth 0.008 -records 4 -tolerance 1e-09 -max_newton 12 -allow_lost 1\n",
                              p.contact_m[0], p.contact_m[1], p.contact_m[2], p.direction[0], p.direction[1], p.direction[2]));
    CHECK_THAT(plan.fragment, Contains("$(R)/cases/" + p.name + ".csv: PATH_ARGUMENTS = -shape fem/dome.geo ") && Contains(" -springs $(R)/mesh.msh ") &&
                                  Contains("$(R)/cases/" + p.name + ".csv: $(R)/plan/path-" + p.name + " $(R)/mesh.msh $(BUILD)/stage/rim scripts/run_gmsh fem/fill3.geo fem/dome.geo\n") &&
                                  Contains("FIGURES := held_out held_out_force shape solid\n"));
    CHECK(plan.fragment.find("SOLID") == std::string::npos);
    CHECK(plan.fragment.find("PATHS +=") == std::string::npos);  // every path is listed once
    CHECK_THAT(plan.parts.at("path-check-0001"), Contains("-size_near 0.004 -size_far 0.015"));
    s.geometry.fixed = {"bed $(rm)"};
    CHECK_THAT(refusal<StudyError>([&] { make_plan(s, shape()); }), Contains("key 'geometry.fixed'") && Contains("make does not support"));
    s = study();
    s.springs.terms = {"spring.wall"};
    s.geometry.shape = "fem/dome.geo";
    CHECK_THAT(refusal<StudyError>([&] { make_plan(s, shape()); }), Contains("key 'springs.terms': term 'spring.wall'"));
}

TEST_CASE("a solid shape is remeshed if its beds cover other parts and not if their stiffness changes", "[solid_shape]") {
    Study s = study();
    s.geometry.shape = "fem/dome.geo";
    s.geometry.fixed = {"bed", "wall"};
    const auto shape_part = [&](const std::vector<double>& beds_Pa_m) {
        s.geometry.bed_Pa_m = beds_Pa_m;
        return make_plan(s, std::nullopt).parts.at("shape");
    };
    CHECK(std::set<std::string>{shape_part({}), shape_part({3e5, 0}), shape_part({0, 3e5}), shape_part({3e5, 3e5}), shape_part({3e5, 6e5})}.size() == 5);
    CHECK(shape_part({3e5, 6e5}) == shape_part({4e5, 5e5}));
}

TEST_CASE("regions of a solid shape stiffen the springs and cells and supports inside them", "[solid_shape][long]") {
    Study s = study();
    s.material.regions = {{{}, "stone"}};
    s.material.regions[0].C1_Pa = 10 * (263 + 491);
    std::optional<Shape> stony = shape();
    for (std::size_t t = 0; t < stony->region.size() / 2; ++t) stony->region[t] = 1;
    const SpringMesh mesh = study_mesh(s, stony, "embedded");
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(2);
    const Eigen::VectorXd soft = study_energy_model(study(), shape(), mesh).constants(none), hard = study_energy_model(s, stony, mesh).constants(none);
    const Eigen::VectorXd ratio = hard.cwiseQuotient(soft);
    CHECK(ratio.minCoeff() == Approx(1).epsilon(tolerance::rounding));
    CHECK(ratio.maxCoeff() == Approx(10).epsilon(tolerance::rounding));
    CHECK((ratio.array() > 1.01 && ratio.array() < 9.99).any());
    double volume_m3 = 0;
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < stony->region.size() / 2; ++i) {
        Eigen::Matrix<double, 4, 3> corners;
        for (int k = 0; k < 4; ++k) corners.row(k) = mesh.nodes.row(mesh.simplices(static_cast<Eigen::Index>(i), k));
        const double own = (corners.bottomRows<3>().rowwise() - corners.row(0)).determinant() / 6;
        volume_m3 += own;
        moment += own * corners.colwise().mean().transpose();
    }
    const NodeField ground = region_points(s, stony, mesh);
    CHECK(ground.col(3).sum() == Approx(std::log(10.0) * volume_m3).epsilon(tolerance::rounding));
    CHECK((ground.leftCols(3).transpose() * ground.col(3) / std::log(10.0) - moment).norm() < 1e-9 * moment.norm());
    s.springs.terms = {"spring.nodule", "contact.normal.ground"};
    CHECK(study_energy_model(s, stony, mesh).ground() == ground);
    s.springs.terms = study().springs.terms;
    Cases cases = dome_cases();
    cases.shape = stony;
    const Eigen::VectorXd own = untrained_model(s, cases, {}).heuristic_a, even = untrained_model(study(), dome_cases(), {}).heuristic_a;
    CHECK(untrained_model(s, cases, {}).nodule.empty());
    Study lumpy = study();
    lumpy.nodule = Study::Nodule{{10 * s.material.C1_Pa, 0, {}, {}}, Inclusion(Eigen::Vector3d(0, 0, 0.025), 0.01), {}};
    CHECK(untrained_model(lumpy, dome_cases(), {}).nodule.triangles.rows() == 320);
    // Van Gelder's springs too
    CHECK((own.cwiseQuotient(even) - ratio.head(mesh.spring_count())).norm() < 1e-9 * own.size());
    stony->region.assign(stony->region.size(), 1);
    CHECK((study_energy_model(s, stony, mesh).constants(none) - 10 * soft).norm() < 1e-9 * soft.norm());  // supports too
}

TEST_CASE("lattice pieces and supports have the stiffness of their tissue and bed; an unsampled region is refused", "[solid_shape][long]") {
    Study s = study();
    s.file = "dome.toml";
    s.material.regions = {{{}, "stone"}};
    s.material.regions[0].C1_Pa = 10 * (263 + 491);
    std::optional<Shape> stony = shape();
    const auto middle = [&](std::size_t t) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int node : stony->simplices.row(static_cast<Eigen::Index>(t))) sum += stony->nodes.row(node).transpose() / 4;
        return sum;
    };
    for (std::size_t t = 0; t < stony->region.size(); ++t) stony->region[t] = middle(t).x() > 0 ? 1 : 0;
    const SpringMesh mesh = study_mesh(s, stony, "embedded");
    const double E = 6 * 754.0;
    for (const Cells& pieces : {Cells(mesh.springs), mesh_cells(mesh)}) {
        const Eigen::VectorXd moduli = solid_moduli(s, stony, mesh, pieces);
        int right = 0, left = 0;
        // the border between regions deviates from x = 0 by at most one box of 10 mm
        for (Eigen::Index e = 0; e < pieces.rows(); ++e) {
            double low = 1, high = -1;
            for (int node : pieces.row(e)) {
                low = std::min(low, mesh.nodes(node, 0));
                high = std::max(high, mesh.nodes(node, 0));
            }
            if (low > 0.011) CHECK(moduli[e] == Approx(10 * E).epsilon(tolerance::rounding));
            if (high < -0.011) CHECK(moduli[e] == Approx(E).epsilon(tolerance::rounding));
            right += low > 0.011;
            left += high < -0.011;
        }
        CHECK(right > 10);
        CHECK(left > 10);
    }
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(2);
    const Eigen::Index M = mesh.support_count();
    const Eigen::VectorXd ratio = study_energy_model(s, stony, mesh).constants(none).tail(M).cwiseQuotient(study_energy_model(study(), shape(), mesh).constants(none).tail(M));
    CHECK(ratio.minCoeff() == Approx(1).epsilon(tolerance::rounding));
    CHECK(ratio.maxCoeff() == Approx(10).epsilon(tolerance::rounding));

    // elastic bed: the support of a rigid bed in series with the bed; all other constants are unchanged
    for (const auto& [of, on] : {std::pair<Study, std::optional<Shape>>{study(), shape()}, {s, stony}}) {
        Study bedded = of;
        bedded.geometry.fixed = {"bed", "wall"};
        bedded.geometry.bed_Pa_m = {3e5, 0};
        CHECK_THAT(refusal<MismatchError>([&, &of_shape = on] { study_energy_model(bedded, of_shape, mesh); }), Contains("make it again (make mesh)"));
        bedded.geometry.bed_Pa_m = {3e5, 3e5};
        // a shape without bed numbers lies on the bed everywhere
        const Eigen::VectorXd whole = study_energy_model(bedded, on, mesh).constants(none);
        bedded.geometry.bed_Pa_m = {3e5, 0};
        std::optional<Shape> lain = on;
        lain->bed.assign(lain->fixed_facets.size(), 1);
        const Eigen::VectorXd rigid = study_energy_model(of, on, mesh).constants(none), elastic = study_energy_model(bedded, lain, mesh).constants(none);
        const Eigen::Index others = rigid.size() - M;
        CHECK(elastic.head(others) == rigid.head(others));
        CHECK(whole == elastic);
        lain->bed[0] = 2;
        CHECK_THAT(refusal<MismatchError>([&] { study_energy_model(bedded, lain, mesh); }), Contains("has a bed 2, and the study has 1 beds"));
        const Eigen::ArrayXd compliance = rigid.tail(M).array().inverse() + (3e5 * fixed_areas(mesh)).array().inverse();
        CHECK((elastic.tail(M).array() * compliance - 1).abs().maxCoeff() < tolerance::rounding);

        // bed under one half: elastic supports there, rigid ones on the other half, weighted by area between them
        int yes = 0, no = 0, both = 0;
        std::vector<int> in(static_cast<std::size_t>(mesh.node_count()), 0);
        for (std::size_t f = 0; f < lain->fixed_facets.size(); ++f) {
            double x = 0;
            for (int node : lain->fixed_facets[f]) x += lain->nodes(node, 0);
            lain->bed[f] = x < 0;
            for (int node : lain->fixed_facets[f]) in[static_cast<std::size_t>(node)] |= x < 0 ? 1 : 2;
        }
        const Eigen::VectorXd half = study_energy_model(bedded, lain, mesh).constants(none);
        for (Eigen::Index m = 0; m < M; ++m) {
            const int where = in[static_cast<std::size_t>(mesh.fixed[static_cast<std::size_t>(m)])];
            const double k = half[others + m], on_bed = elastic[others + m], on_rock = rigid[others + m];
            if (where == 1) CHECK(k == Approx(on_bed).epsilon(tolerance::rounding));
            if (where == 2) CHECK(k == Approx(on_rock).epsilon(tolerance::rounding));
            if (where == 3) CHECK((k > on_bed && k < on_rock));
            yes += where == 1, no += where == 2, both += where == 3;
        }
        CHECK((yes > 3 && no > 3 && both > 1));
    }

    // a Maxwell branch that neither the region nor the supports have
    s.material.viscosity = {{0.3, 1.0}};
    s.material.share = {0.3};
    s.material.regions[0].share = {0.0};
    const Relaxation r = study_relaxation(s, stony, mesh, study_energy_model(s, stony, mesh));
    REQUIRE(r.share.rows() == ratio.size() + mesh.spring_count() + cell_count(mesh));
    CHECK(r.share.bottomRows(M).isZero(0));
    const Eigen::VectorXd springs = r.share.col(0).head(mesh.spring_count());
    CHECK(springs.maxCoeff() == Approx(0.3).epsilon(1e-6));
    CHECK(springs.minCoeff() == Approx(0).margin(1e-6));

    std::optional<Shape> more = stony;
    more->region[7] = 2;
    CHECK_THAT(refusal<MismatchError>([&] { study_energy_model(s, more, mesh); }), Contains("has region 2, and study") && Contains("only 1"));

    // a region of one tetrahedron of a fine mesh, between all sample points
    std::optional<Shape> fine = dome(30);
    fine->region.assign(fine->region.size(), 0);
    std::size_t least = 0;
    const auto near = [&](std::size_t t) { return (fine->nodes.row(fine->simplices(static_cast<Eigen::Index>(t), 0)).transpose() - Eigen::Vector3d(0, 0, 0.025)).norm(); };
    for (std::size_t t = 0; t < fine->region.size(); ++t) least = near(t) < near(least) ? t : least;
    fine->region[least] = 1;
    s.springs.spacing_m = 0.025;
    const SpringMesh coarse = study_mesh(s, fine, "embedded");
    CHECK_THAT(refusal<StudyError>([&] { study_energy_model(s, fine, coarse); }), StartsWith("dome.toml: key 'material.regions.stone': no point of the lattice's cubes (25 mm, 64 points each) is in this region"));
}

TEST_CASE("a first model's eight paths include every direction about equally and contacts of the whole list", "[solid_shape][long]") {
    for (const std::size_t kinds : {2U, 3U})
        for (int count = 9; count <= 34; ++count) {
            CAPTURE(kinds, count);
            Study s = spread_study(count, 0.015, 1);
            s.name = "dome", s.geometry.shape = "fem/dome.geo";
            s.loads.spread->pushes_deg.resize(kinds);
            const std::string fragment = make_plan(s, shape()).fragment, key = "FIRST_TRAINED :=";
            std::istringstream names(fragment.substr(fragment.find(key) + key.size(), fragment.find('\n', fragment.find(key)) - fragment.find(key) - key.size()));
            std::set<std::string> all;
            std::map<std::size_t, int> of_kind;
            int last = 0;
            for (std::string name; names >> name;) {
                all.insert(name);
                const int contact = std::stoi(name.substr(1, 2));
                ++of_kind[static_cast<std::size_t>(contact - 1) % kinds];
                last = std::max(last, contact);
            }
            CHECK(all.size() == 8);
            REQUIRE(of_kind.size() == kinds);
            for (const auto& [kind, found] : of_kind) CHECK(found >= 8 / static_cast<int>(kinds));
            CHECK(last > 0.7 * count);
        }
}

TEST_CASE("a nodule stiffens cells of a solid shape by their fraction inside and enters its contact terms", "[solid_shape]") {
    Study s = study();
    s.nodule = stone();
    const SpringMesh mesh = study_mesh(s, shape(), "embedded");
    const Eigen::VectorXd inside = fraction_inside(mesh, mesh_cells(mesh), s.nodule->inclusion);
    const double ball_m3 = 4.0 / 3 * 3.14159265358979 * std::pow(0.009, 3);
    CHECK(inside.sum() * std::pow(0.011, 3) == Approx(ball_m3).epsilon(0.03));  // sampled at 64 points per cube
    const double E = 6 * 754.0;
    CHECK((solid_moduli(s, shape(), mesh, mesh_cells(mesh)) - (E * (1 + 3 * inside.array())).matrix()).norm() < 1e-9 * E);
    s.springs.terms = {"spring.nodule", "cell.nodule", "contact.normal.ground"};
    const EnergyModelTerms model_terms = study_energy_model(s, shape(), mesh);
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(3), plain = study_energy_model(study(), shape(), mesh).constants(Eigen::VectorXd::Zero(2));
    const Eigen::VectorXd ratio = model_terms.constants(none).cwiseQuotient(plain);
    CHECK(ratio.minCoeff() == Approx(1).epsilon(tolerance::rounding));
    CHECK(ratio.maxCoeff() > 2);
    CHECK(ratio.maxCoeff() <= 4 * (1 + tolerance::rounding));
    Eigen::VectorXd one = none;
    one << 1, 0, 0;  // factor (E / E of the base material)^p with p = 1
    const Eigen::VectorXd more = model_terms.constants(one).cwiseQuotient(model_terms.constants(none)).head(mesh.spring_count());
    CHECK((more - ratio.head(mesh.spring_count())).norm() < 1e-9 * more.norm());
    CHECK(model_terms.ground() == nodule_points(s));
    CHECK(model_terms.ground().col(3).sum() == Approx(std::log(4.0) * ball_m3).epsilon(1e-6));
    // arguments for gmsh and FreeFEM
    s.geometry.shape = "fem/dome.geo";
    s.name = "dome";
    CHECK_THAT(make_plan(s, shape()).parts.at("path-" + solid_training(s, shape())[0].name),
               Contains(" -nodule_x 0.01 -nodule_y 0 -nodule_z 0.03 -nodule_radius 0.009 -C1_11 3016 -C2_11 0 -contact_x "));
}

TEST_CASE("a nodule given by the surface file of a ball stiffens the same cells as the ball", "[solid_shape][long]") {
    Study s = study();
    s.name = "dome", s.file = "dome.toml", s.geometry.shape = "fem/dome.geo";
    s.nodule = stone();
    const Eigen::Vector3d centre_m = s.nodule->inclusion.centre_m();
    const SpringMesh mesh = study_mesh(s, shape(), "embedded");
    const Eigen::VectorXd ball = solid_moduli(s, shape(), mesh, mesh_cells(mesh));
    const NodeField points = nodule_points(s);
    const auto enclosed = [&](const Eigen::Vector3d& at_m, double thin = 1, double turned = 0) {
        MshFile file = ball_surface(Eigen::Vector3d::Zero(), 9, 5);
        for (MshFile::Point& p : file.points) {
            const Eigen::Vector3d at = 1e3 * at_m + Eigen::AngleAxisd(turned, Eigen::Vector3d::UnitX()) * Eigen::Vector3d(p.x, p.y, thin * p.z);
            p = {at[0], at[1], at[2]};
        }
        s.nodule->inclusion = Inclusion(inclusion_surface(file, 1e-3));
        s.nodule->shape = "stone.stl";
    };
    enclosed(centre_m);
    const double E = s.material.youngs_modulus_Pa();
    // one of the 64 points of a cube may lie between both surfaces
    CHECK((solid_moduli(s, shape(), mesh, mesh_cells(mesh)) - ball).cwiseAbs().maxCoeff() < 0.05 * 3 * E);
    const NodeField round = nodule_points(s);
    CHECK(round.col(3).sum() == Approx(points.col(3).sum()).epsilon(2e-3));
    CHECK((round.leftCols(3).colwise().mean() - points.leftCols(3).colwise().mean()).norm() < 1e-4);
    const auto spread_m = [&](const NodeField& p) { return std::sqrt((p.leftCols(3).rowwise() - centre_m.transpose()).rowwise().squaredNorm().mean()); };
    CHECK(spread_m(round) == Approx(spread_m(points)).epsilon(0.01));
    refuse_nodule_outside(s, *shape());
    CHECK_THAT(make_plan(s, shape()).parts.at("path-" + solid_training(s, shape())[0].name), Contains(" -nodule_shape stone.stl -nodule_x 0.0"));
    CHECK_THAT(make_plan(s, shape()).fragment, Contains("$(R)/plan.mk: $(wildcard stone.stl)"));
    s.nodule->shape = "a stone.stl";
    CHECK_THAT(refusal<StudyError>([&] { make_plan(s, shape()); }), Contains("key 'nodule.shape': 'a stone.stl': make does not support this name"));

    enclosed({0.01, 0, 0.0095});
    CHECK_THAT(refusal<StudyError>([&] { refuse_nodule_outside(s, *shape()); }), StartsWith("dome.toml: key 'nodule.shape': (") && Contains("stone.stl is ") && Contains("half of mesh.sizes_m[0]"));
    enclosed({0.01, 0, 0.2});
    CHECK_THAT(refusal<StudyError>([&] { refuse_nodule_outside(s, *shape()); }), Contains("stone.stl is not inside fem/dome.geo"));
    enclosed(centre_m, 0.05, 0.7);  // a thin tilted disc contains few points of a grid in its bounding box
    CHECK(nodule_points(s).rows() >= 50);
    enclosed(centre_m, 1e-3);
    CHECK_THAT(refusal<StudyError>([&] { study_energy_model(s, shape(), mesh); }), StartsWith("dome.toml: key 'nodule.shape': no point of the lattice's cubes") && Contains("make springs.spacing_m smaller"));
}

TEST_CASE("a nodule surface that crosses a notch of the shape is refused even if its corners are inside", "[solid_shape]") {
    const Shape block = solid_block(Lattice{{3, 1, 2}, {0.09, 0.04, 0.06}});
    Shape notched{block.nodes, Cells(0, 4), {}, {}, {}};  // the middle of its upper half is missing
    for (const auto& t : block.simplices.rowwise()) {
        const Eigen::RowVector3d middle_m = block.nodes({t[0], t[1], t[2], t[3]}, Eigen::all).colwise().mean();
        if (middle_m[2] > 0.03 && middle_m[0] > 0.03 && middle_m[0] < 0.06) continue;
        notched.simplices.conservativeResize(notched.simplices.rows() + 1, 4);
        notched.simplices.bottomRows(1) = t;
    }
    Study s = study();
    s.file = "notched.toml";
    s.nodule = stone();
    s.nodule->shape = "bar.stl";
    const auto bar = [&](double z_mm) {
        MshFile file;
        file.file = "bar.stl";
        file.points = {{10, 15, z_mm}, {80, 15, z_mm}, {80, 25, z_mm}, {10, 20, z_mm + 8}};
        file.triangles = {{0, {0, 2, 1}, 0}, {0, {0, 1, 3}, 0}, {0, {1, 2, 3}, 0}, {0, {2, 0, 3}, 0}};
        s.nodule->inclusion = Inclusion(inclusion_surface(file, 1e-3));
    };
    bar(10);
    refuse_nodule_outside(s, notched);
    bar(40);
    CHECK_THAT(refusal<StudyError>([&] { refuse_nodule_outside(s, notched); }), StartsWith("notched.toml: key 'nodule.shape': (") && Contains(" of bar.stl is "));
}

TEST_CASE("a nodule outside a solid shape or near its surface is refused by key and place", "[solid_shape]") {
    Study s = study();
    s.file = "dome.toml";
    s.geometry.shape = "dome.geo";
    s.nodule = stone();
    const auto said = [&](const Eigen::Vector3d& centre_m, double radius_m) {
        s.nodule->inclusion = Inclusion(centre_m, radius_m);
        return refusal<StudyError>([&] { refuse_nodule_outside(s, *shape()); });
    };
    CHECK_THAT(said({0, 0, 0.06}, 0.005), StartsWith("dome.toml: key 'nodule.centre_m': (0, 0, 0.06) m is not inside dome.geo"));
    CHECK_THAT(said({0, 0, -0.001}, 0.005), Contains("is not inside"));
    CHECK_THAT(said({0, 0, 0.009}, 0.009), StartsWith("dome.toml: key 'nodule.radius_m': (0, 0, 0.009) m is 9 mm from the surface of dome.geo") &&
                                               Contains("needs 11.77 mm"));  // 1.03 x 9 + 5 / 2
    CHECK_THAT(said({0, 0, 0.0117}, 0.009), Contains("key 'nodule.radius_m'"));
    s.nodule->inclusion = Inclusion(Eigen::Vector3d(0, 0, 0.0118), 0.009);
    refuse_nodule_outside(s, *shape());
    s.nodule.reset();
    refuse_nodule_outside(s, *shape());
}

TEST_CASE("cases of a solid shape are read back unchanged and with an altered dataset are refused or valid", "[solid_shape]") {
    const TemporaryFolder folder;
    const std::string whole = folder.file("whole.h5");
    Cases cases = dome_cases();
    cases.shape = dome(4);  // small, because every dataset is read many times
    cases.nodes = cases.shape->nodes;
    for (LoadPath& path : cases.paths)
        for (PathRecord& r : path.records) r.displacement = r.force = NodeField::Constant(cases.nodes.rows(), 3, r.magnitude_m);
    write_cases(whole, cases, {"tissuectl test", 0, {}});
    const Cases back = read_cases(whole);
    REQUIRE(back.shape);
    CHECK(back.shape->simplices == cases.shape->simplices);
    CHECK(back.shape->fixed_facets == cases.shape->fixed_facets);
    CHECK(back.nodes == cases.nodes);
    REQUIRE(datasets_of(whole, cases_table(false)).size() == Hdf5Reader(whole, "cases").datasets().size());
    const auto not_of_a_path = [](const std::string& dataset) { return dataset.rfind("/paths/", 0) != 0; };  // in tests/cases/test_solid_cases.cpp
    CHECK(refused_mutations(whole, cases_table(false), read_load_cases, "/", not_of_a_path) > 20);
}

TEST_CASE("a solid study reads its shape from a mesh file and refuses a plane shape", "[solid_shape]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("mesh.msh", to_msh(*shape(), {}));
    CHECK(study_shape(study(), file)->simplices.rows() == shape()->simplices.rows());
    CHECK_THAT(refusal<MismatchError>([&] { study_shape(study(), ""); }), Contains("--mesh"));
    const Shape plane = shape_of(make_lattice("grid4", 4, 4, 0.1, 0.1));
    CHECK_THAT(refusal<MismatchError>([&] { study_mesh(study(), plane, "embedded"); }), Contains("different dimensions"));
}
