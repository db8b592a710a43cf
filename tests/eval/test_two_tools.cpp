#include "eval/two_tools.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "../mesh/embedded_block.h"
#include "../solid_model_example.h"
#include "../tolerances.h"
#include "eval/evaluation.h"
#include "eval/held_out.h"
#include "springs/energy_model_terms.h"
#include "springs/indentation_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

TrainedModel model() {
    TrainedModel m;
    static_cast<TissueModel&>(m) = solid_model_example(embedded_block(Lattice{{8, 8, 3}, {0.08, 0.08, 0.03}}));
    EnergyModelDiagnostics& diagnostics = m.books.energy_model.emplace();
    diagnostics.status = {"small_gain"};
    diagnostics.start_objective = diagnostics.gradient = Eigen::VectorXd::Ones(1);
    diagnostics.iterations = diagnostics.evaluations = {1};
    return m;
}

/// A pair of discs apart_m apart with the forces of this energy model; the first force is multiplied by `stronger`. A
/// pair within 14 mm has a fixed force.
LoadPath pair_of(const TrainedModel& m, const std::string& name, double apart_m, double stronger = 1) {
    LoadPath path;
    path.name = name;
    path.role = "held_out_two";
    path.contact_m = Eigen::Vector3d(0.024, 0.041, 0.03);
    path.direction = Eigen::Vector3d(0, 0, -1);
    path.depth_m = 0.005;
    path.second = SecondTool{Eigen::Vector3d(0.024 + apart_m, 0.041, 0.03), Eigen::Vector3d(0.6, 0, -0.8), 0.003};
    const NodeField none = NodeField::Zero(m.mesh.node_count(), 3);
    for (double s : {0.0, 0.0025, 0.005}) {
        PathRecord record{s, none, none, Point::Zero(3), Point::Zero(3), 0, 1, 0, 0};
        record.second_force_N = Point::Zero(3);
        if (s > 0 && apart_m > 0.014) {
            const ToolsEquilibrium rest = IndentationSolver(m).at({{path.contact_m, path.push_m(record)}, {path.second->contact_m, path.second_push_m(record)}});
            REQUIRE(rest);
            record.contact_force_N = stronger * rest.contact_force[0];
            record.second_force_N = rest.contact_force[1];
        } else if (s > 0) {
            record.contact_force_N = record.second_force_N = Eigen::Vector3d(0, 0, -0.1);
        }
        path.records.push_back(record);
    }
    return path;
}

Cases cases_of(const TrainedModel& m, std::vector<LoadPath> paths) {
    Cases cases;
    cases.nodes = m.mesh.nodes;
    cases.magnitudes_m = {0.005};
    cases.paths = std::move(paths);
    return cases;
}

}  // namespace

TEST_CASE("a disc pair has a force error per disc for both discs together and for each alone", "[solid][two_tools]") {
    const TrainedModel m = model();
    const TwoTools two = evaluate_two_tools(m, cases_of(m, {pair_of(m, "held-out-two-0001", 0.016), pair_of(m, "held-out-two-0002", 0.030, 1.25)}), 2);
    REQUIRE(two.models == std::vector<std::string>{"learned", "alone"});
    REQUIRE(two.roles.size() == 1);
    const IndentationPairs& role = two.roles[0];
    CHECK(role.role == "held_out_two");
    REQUIRE(role.pairs.size() == 2);
    const IndentationPair& near = role.pairs[0];
    CHECK(near.apart_m() == Approx(0.016).epsilon(tolerance::rounding));
    CHECK(near.radius_m == 0.007);
    CHECK((near.push_m[1] - 0.003 * Eigen::Vector3d(0.6, 0, -0.8)).norm() < tolerance::rounding);
    for (std::size_t t : {0, 1}) {
        CHECK(*near.error[0][t].force < tolerance::newton);
        const double alone = IndentationSolver(m).at(near.contact_m[t], near.push_m[t]).contact_force.norm();
        CHECK(*near.error[1][t].force > 0.02);
        CHECK(alone > near.fe_force_N[t].norm());
    }
    CHECK(*role.pairs[1].error[0][0].force == Approx(0.2).epsilon(tolerance::newton));
    CHECK(*role.pairs[1].error[0][1].force < tolerance::newton);
    const Statistics s = role.statistics(0).force;
    CHECK(s.n == 4);
    CHECK(s.of() == 4);
    CHECK(s.max == Approx(0.2).epsilon(tolerance::newton));
}

TEST_CASE("a pair without FE reference lacks two forces and overlapping discs have no answer", "[solid][two_tools]") {
    const TrainedModel m = model();
    LoadPath lost = pair_of(m, "held-out-two-0001", 0.030);
    lost.lost = "the tissue is folded";
    const TwoTools two = evaluate_two_tools(m, cases_of(m, {lost, pair_of(m, "held-out-two-0002", 0.013), pair_of(m, "held-out-two-0003", 0.020)}), 1);
    const IndentationPairs& role = two.roles.at(0);
    CHECK(role.lost == std::vector<std::string>{"held-out-two-0001: the tissue is folded"});
    const ContactStatistics s = role.statistics(0);
    CHECK(s.force.no_reference == 2);
    CHECK(s.force.missing == 2);
    CHECK(s.force.n == 2);
    CHECK_THAT(s.reasons, Contains("nearer than two radii of 7 mm (2)"));
    CHECK(role.statistics(1).force.missing == 0);  // each disc alone has an answer
    LoadPath single = pair_of(m, "held-out-0001", 0.030);
    single.second.reset();
    CHECK(evaluate_two_tools(m, cases_of(m, {single}), 1).empty());
}

TEST_CASE("eval.json and report.md have results of two tools only if there are pairs", "[solid][two_tools]") {
    const TrainedModel m = model();
    Evaluation e;
    e.energy_model = m.energy_model;
    e.energy_model_diagnostics = m.books.energy_model;
    e.models.push_back({"learned", {}, {}, 0});
    e.listed = false;
    CHECK_THAT(to_json(e, 0), !Contains("two_tools"));
    CHECK_THAT(to_markdown(e), !Contains("Two discs"));
    LoadPath lost = pair_of(m, "held-out-two-0003", 0.030);
    lost.lost = "the tissue is folded";
    e.two_tools = evaluate_two_tools(m, cases_of(m, {pair_of(m, "held-out-two-0001", 0.016), pair_of(m, "held-out-two-0002", 0.013), lost}), 1);
    const auto block = nlohmann::json::parse(to_json(e, 0))["two_tools"]["held_out_two"];
    CHECK(block["learned"]["n"] == 2);
    CHECK(block["learned"]["missing"] == 2);
    CHECK(block["learned"]["of"] == 6);
    CHECK(block["learned"]["max"].is_null());
    CHECK(block["alone"]["n"] == 4);
    CHECK(block["lost"].size() == 1);
    REQUIRE(block["pairs"].size() == 2);
    CHECK(block["pairs"][0]["name"] == "held-out-two-0001");
    CHECK(block["pairs"][0]["apart_m"].get<double>() == Approx(0.016));
    CHECK(block["pairs"][0]["tools"][1]["push_m"][2].get<double>() == Approx(-0.0024));
    CHECK(block["pairs"][0]["tools"][0]["error"]["learned"].get<double>() < tolerance::newton);
    CHECK(block["pairs"][1]["tools"][0]["error"]["learned"].is_null());
    const std::string report = to_markdown(e);
    CHECK_THAT(report, Contains("## Two discs at once: pairs of `held_out_two`, force error on each disc"));
    CHECK_THAT(report, Contains("Pairs without an FE reference: 1:\n- held-out-two-0003: the tissue is folded\n"));
    CHECK(report.find("| held-out-two-0002 | 13.0 | 5.00, 3.00 |") < report.find("| held-out-two-0001 | 16.0 | 5.00, 3.00 |"));
}

TEST_CASE("the untrained model has the spring curve of the learned one and heuristics have Hooke's", "[solid][held_out]") {
    TrainedModel m = model();
    m.heuristic_b = m.heuristic_a;
    m.books.energy_model->untrained_constants = m.energy_model->constants;
    m.books.energy_model->untrained_patch = m.energy_model->patch;
    LoadPath path = pair_of(m, "held-out-0001", 0.016);
    path.role = "held_out";
    path.second.reset();
    const auto force_of = [&](const Eigen::VectorXd& constants, const SpringCurve& curve) {
        EnergyModel energy_model = *m.energy_model;
        energy_model.constants = constants;
        energy_model.curve = curve;
        const Equilibrium rest = IndentationSolver(m.mesh, energy_model).at(path.contact_m, path.push_m(path.records.back()));
        REQUIRE(rest);
        return Point(rest.contact_force);
    };
    const Point truth = force_of(m.energy_model->constants, m.energy_model->curve);
    for (PathRecord& record : path.records) record.contact_force_N = record.magnitude_m / path.depth_m * truth;
    const HeldOut held_out = evaluate_held_out(m, cases_of(m, {path}), 1);
    const auto error_of = [&](const std::string& name) {
        const auto at = std::find(held_out.models.begin(), held_out.models.end(), name);
        REQUIRE(at != held_out.models.end());
        return *held_out.role("held_out")->contacts.at(0).error.at(static_cast<std::size_t>(at - held_out.models.begin())).force;
    };
    CHECK(error_of("learned") < 1e-9);
    CHECK(error_of("untrained") < 1e-9);
    const Point hooke = force_of(springs_alone(m.mesh, m.energy_model->constants, m.heuristic_a), SpringCurve());
    CHECK(error_of("heuristic_a_patch") == Approx((hooke - truth).norm() / truth.norm()).epsilon(1e-6));
    CHECK((force_of(springs_alone(m.mesh, m.energy_model->constants, m.heuristic_a), m.energy_model->curve) - hooke).norm() > 1e-3 * hooke.norm());
}
