#include "eval/evaluation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "error.h"
#include "../example.h"
#include "../refusal.h"
#include "springs/heuristic.h"
#include "../tolerances.h"
#include "train/train_sets.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

struct Example {
    Study study;
    Cases cases;
    TrainedModel model;
};

/// The learned sets are those of the reference, so that all their errors vanish.
const Example& perfect() {
    static const Example example = [] {
        const Study study = example_study();
        const Eigen::VectorXd theta = example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1));
        const Cases cases = example_cases(study, theta);
        return Example{study, cases, example_model(study, cases, theta)};
    }();
    return example;
}

Evaluation evaluated(const TrainedModel& model, const Cases& cases) {
    return evaluate(model, cases, 0.05 * model.modulus_N_m, 40 * model.modulus_N_m, 2);
}

}  // namespace

TEST_CASE("learned springs equal to the reference have no errors and the heuristic has every kind of error") {
    const Evaluation e = evaluated(perfect().model, perfect().cases);
    CHECK(e.models.front().name == "learned");
    const ModelErrors &learned = e.model("learned"), &heuristic = e.model("heuristic_a");
    CHECK(learned.rel_loss().max <= tolerance::rounding);
    CHECK(learned.resolved_error().max <= tolerance::solve);
    CHECK(learned.closed_loop().force.max <= tolerance::solve);
    CHECK(learned.closed_loop().shape.max <= tolerance::solve);
    CHECK(learned.rel_loss().n == 4);
    CHECK(heuristic.rel_loss().median > 0.01);
    CHECK(heuristic.resolved_error().median > 0.01);
    CHECK(heuristic.closed_loop().force.median > 0.01);
    CHECK(heuristic.closed_loop().shape.median > 0.01);
}

TEST_CASE("the evaluation has learned sets of both optimisers and the optimum and all baselines") {
    const Evaluation e = evaluated(perfect().model, perfect().cases);
    for (const char* name : {"learned", "learned_spsa_2008", "optimum", "heuristic_a", "heuristic_b", "uniform"}) {
        CHECK(e.model(name).cases.size() == e.case_names.size());
    }
    CHECK_THAT(refusal<MismatchError>([&] { e.model("magic"); }), Contains("magic"));
}

TEST_CASE("the optimum has the least loss of all models within the box") {
    const Example& x = perfect();
    const TrainedModel trained = train_sets(x.study, x.cases, 1);
    const Evaluation e = evaluated(trained, x.cases);
    for (const ModelErrors& m : e.models)
        for (std::size_t c = 0; c < m.cases.size(); ++c) {
            if (m.name == "heuristic_b" || m.name == "uniform") continue;  // may lie outside the box
            CHECK(e.model("optimum").cases[c].open_loop.rel_loss <=
                  m.cases[c].open_loop.rel_loss + tolerance::newton);
        }
}

TEST_CASE("forces of heuristic_a are six times those of heuristic_b") {
    const Evaluation e = evaluated(perfect().model, perfect().cases);
    for (std::size_t c = 0; c < e.case_names.size(); ++c)
        CHECK(e.model("heuristic_a").cases[c].open_loop.resolved_force_N ==
              Approx(6 * e.model("heuristic_b").cases[c].open_loop.resolved_force_N).epsilon(tolerance::solve));
}

TEST_CASE("a force curve runs from rest to the largest magnitude and equals FE for reference springs") {
    const Evaluation e = evaluated(perfect().model, perfect().cases);
    REQUIRE(e.curves.size() == 2);
    for (const ForceCurve& curve : e.curves) {
        CHECK(curve.magnitude_m.front() == 0);
        CHECK(curve.magnitude_m.back() == Approx(0.008).epsilon(tolerance::rounding));
        CHECK(curve.fe_N.front() == 0);
        for (std::size_t r = 0; r < curve.fe_N.size(); ++r)
            CHECK(curve.model_force_N[0][r] ==
                  Approx(curve.fe_N[r]).epsilon(tolerance::solve).margin(tolerance::rounding));
        // 0, 2, 4, 6, 8 mm use the set of the nearest magnitude, half-way that of the smaller one
        const std::string shallow = curve.path + "-4mm", deep = curve.path + "-8mm";
        CHECK(curve.serving_set == std::vector<std::string>{shallow, shallow, shallow, shallow, deep});
    }
}

TEST_CASE("a path that FE ended before its first load case has no force curve and is listed") {
    const Example& x = perfect();
    Cases cases = x.cases;
    LoadPath& lost = cases.paths.back();
    lost.records.resize(2);  // at rest and at 2 mm
    lost.lost = "no equilibrium beyond 2 mm";
    const Evaluation e = evaluated(train_sets(x.study, cases, 1), cases);
    REQUIRE(e.curves.size() == 1);
    CHECK(e.curves[0].path == "left");
    CHECK(e.curves[0].serving_set.back() == "left-8mm");
    const nlohmann::json j = nlohmann::json::parse(to_json(e, 11));
    CHECK(j["lost"]["train"] == std::vector<std::string>{"corner: no equilibrium beyond 2 mm"});
    CHECK(j["curves"].size() == 1);
    CHECK_THAT(to_markdown(e), Contains("1 of the training paths end early in FE") && Contains("- corner: no equilibrium beyond 2 mm") && Contains("2 of 4 load cases, 2 without a reference"));
    for (const nlohmann::json& s : {j["closed_loop"]["trained"]["learned"], j["open_loop"]["learned"]["rel_loss"]}) {
        CHECK(s["n"] == 2);
        CHECK(s["of"] == 4);
        CHECK(s["no_reference"] == 2);
    }
    CHECK_FALSE(nlohmann::json::parse(to_json(evaluated(x.model, x.cases), 11)).contains("lost"));
}

TEST_CASE("errors relative to a zero FE force are absent with a reason and not counted in n") {
    const Example& x = perfect();
    for (const char* objective : {"force", "contact"}) {
        Study study = x.study;
        study.training.objective = objective;
        Cases cases = x.cases, fewer = x.cases;
        fewer.paths.pop_back();
        for (PathRecord& r : cases.paths.back().records) r.force.setZero(), r.contact_force_N.setZero();
        for (Cases* some : {&cases, &fewer}) {  // a drawn contact with a force; the one without follows
            some->paths.push_back(x.cases.paths[0]);
            some->paths.back().role = "held_out", some->paths.back().name = "drawn";
        }
        cases.paths.push_back(cases.paths[1]);
        cases.paths.back().role = "held_out", cases.paths.back().name = "drawn-without";
        const Evaluation e = evaluated(train_sets(study, cases, 1), cases), without = evaluated(train_sets(study, fewer, 1), fewer);
        CAPTURE(objective);
        CHECK(e.uniform_N_m == without.uniform_N_m);
        for (const ModelErrors& m : e.models) {
            CAPTURE(m.name);
            const ModelErrors& same = without.model(m.name);
            CHECK(m.rel_loss().n == 2);
            CHECK(m.rel_loss().max == same.rel_loss().max);
            CHECK(m.resolved_error().n == 2);
            CHECK(m.resolved_error().max == same.resolved_error().max);
            CHECK(m.closed_loop().force.n == 2);
            CHECK(m.closed_loop().force.median == same.closed_loop().force.median);
            CHECK_FALSE(m.cases[3].closed_loop.force);
            CHECK_THAT(m.closed_loop().reasons, Contains("the reference force is zero (2)"));
        }
        const ContactStatistics drawn = e.held_out.role("held_out")->statistics(0);
        CHECK(drawn.force.n == 1);
        CHECK(drawn.force.of() == 2);
        CHECK(drawn.force.no_reference == 1);
        CHECK_THAT(drawn.reasons, Contains("the reference force is zero (1)"));
        const nlohmann::json j = nlohmann::json::parse(to_json(e, 11));
        CHECK(j["open_loop"]["learned"]["n"] == 2);
        CHECK(j["open_loop"]["learned"]["rel_loss"]["max"].is_number());
        CHECK(j["cases"][3]["models"]["learned"]["rel_loss"].is_null());
        CHECK(j["cases"][3]["models"]["learned"]["closed_loop_error"].is_null());
        CHECK_THAT(to_markdown(e), !Contains("nan %") && !Contains("inf %"));
    }
}

TEST_CASE("a mesh with zero-energy modes reports its reason and chooses the uniform stiffness by rel_loss") {
    const Example& x = perfect();
    Study study = x.study;
    study.springs.topology = "grid4";
    const TrainedModel model = train_sets(study, x.cases, 1);
    const Evaluation e = evaluated(model, x.cases);
    CHECK(e.uniform_chosen_on == "rel_loss");
    CHECK(e.model("learned").closed_loop().force.n == 0);
    CHECK_THAT(e.model("learned").closed_loop().reasons, Contains("zero-energy modes"));
    const nlohmann::json j = nlohmann::json::parse(to_json(e, 11));
    const nlohmann::json& entry = j["closed_loop"]["trained"]["learned"];
    CHECK(entry["median"].is_null());
    CHECK(entry["n"] == 0);
    CHECK(entry["of"] == 4);
    CHECK(entry["missing"] == 4);
    CHECK_THAT(entry["reason"].get<std::string>(), Contains("zero-energy modes"));
    CHECK(entry["shape"]["median"].is_null());
    CHECK(entry["shape"]["n"] == 0);
    CHECK(j["cases"][0]["models"]["learned"]["closed_loop_error"].is_null());
    CHECK_THAT(to_markdown(e), Contains("No answer of ") && Contains("zero-energy modes"));
}

TEST_CASE("a model with missing answers has its own n in every table and counts its reasons") {
    Evaluation e = evaluated(perfect().model, perfect().cases);
    const auto lose = [&](std::size_t model, std::size_t c, EquilibriumStatus status) {
        constexpr double missing = std::numeric_limits<double>::infinity();
        e.models[model].cases[c].closed_loop = {missing, missing, missing, reason_of(status)};
    };
    lose(0, 1, EquilibriumStatus::unstable);
    lose(0, 2, EquilibriumStatus::unstable);
    lose(0, 3, EquilibriumStatus::not_converged);
    const nlohmann::json j = nlohmann::json::parse(to_json(e, 11));
    const nlohmann::json &own = j["closed_loop"]["trained"]["learned"], &other = j["closed_loop"]["trained"]["uniform"];
    CHECK(own["n"] == 1);
    CHECK(own["of"] == 4);
    CHECK(own["missing"] == 3);
    CHECK(own["median"].is_null());  // infinite: three of four are missing
    CHECK(own["p95"].is_null());
    CHECK(other["n"] == 4);
    CHECK(other["of"] == 4);
    CHECK(own["shape"]["n"] == 1);
    CHECK(other["shape"]["n"] == 4);
    CHECK_FALSE(other.contains("reason"));
    const std::string reasons = reason_of(EquilibriumStatus::unstable) + " (2); " +
                                reason_of(EquilibriumStatus::not_converged) + " (1)";
    CHECK(own["reason"] == reasons);
    const std::string report = to_markdown(e), table = report.substr(report.find("| model | rel_loss"));
    const auto row = [&](const std::string& model) {
        const std::size_t from = table.find("| " + model + " |");
        return table.substr(from, table.find('\n', from) - from);
    };
    CHECK_THAT(row("learned"), Contains("| 4 of 4 | none / none / none |") && Catch::EndsWith("| 1 of 4 |"));
    CHECK_THAT(row("uniform"), Contains("| 4 of 4 |") && Catch::EndsWith("| 4 of 4 |"));
    CHECK_THAT(report, Contains("No answer of learned: " + reasons));
}

TEST_CASE("eval.json has the numbers of the evaluation for every model and case") {
    const Evaluation e = evaluated(perfect().model, perfect().cases);
    const nlohmann::json j = nlohmann::json::parse(to_json(e, 11));
    CHECK(j["study"] == "example");
    CHECK(j["seed"] == 11);
    CHECK_FALSE(j["version"].get<std::string>().empty());
    for (const ModelErrors& m : e.models) {
        CHECK(j["open_loop"][m.name]["rel_loss"]["median"] == m.rel_loss().median);
        CHECK(j["open_loop"][m.name]["resolved_force_error"]["p95"] == m.resolved_error().p95);
        CHECK(j["open_loop"][m.name]["n"] == 4);
        const nlohmann::json& closed = j["closed_loop"]["trained"][m.name];
        CHECK(closed["max"] == m.closed_loop().force.max);
        CHECK(closed["n"] == 4);
        CHECK(closed["shape"]["median"] == m.closed_loop().shape.median);
        CHECK(closed["shape"]["n"] == 4);
        CHECK(closed["shape_max_over_depth"]["p95"] == m.closed_loop().shape_max_over_depth.p95);
        CHECK(j["cases"][1]["models"][m.name]["closed_loop_shape"] == m.cases[1].closed_loop.shape.value());
    }
    for (const char* key : {"sets", "restarts", "iterations", "gap", "seconds"}) CHECK(j["training"].contains(key));
    CHECK(j["training"]["sets"] == 4);
    CHECK(j["training"]["gap"].contains("median"));
    CHECK(j["training"]["gap"].contains("max"));
    REQUIRE(j["cases"].size() == 4);
    CHECK(j["cases"][0]["name"] == "left-4mm");
    CHECK(j["cases"][0]["magnitude_m"] == 0.004);
}

TEST_CASE("a drawn contact without FE reference counts in N and is reported as such") {
    Cases cases = perfect().cases;
    for (const char* name : {"drawn", "drawn-lost"}) {
        cases.paths.push_back(cases.paths[0]);
        cases.paths.back().role = "held_out";
        cases.paths.back().name = name;
    }
    cases.paths.back().lost = "no equilibrium beyond 3 mm";
    const Evaluation e = evaluated(perfect().model, cases);
    const nlohmann::json j = nlohmann::json::parse(to_json(e, 11)), &held_out = j["closed_loop"]["held_out"];
    for (const char* model : {"learned", "uniform", "force_table"}) {
        CAPTURE(model);
        CHECK(held_out[model]["n"] == 1);
        CHECK(held_out[model]["of"] == 2);
        CHECK(held_out[model]["missing"] == 0);
        CHECK(held_out[model]["no_reference"] == 1);
        CHECK(held_out[model]["max"].is_number());
    }
    CHECK(held_out["learned"]["shape"]["of"] == 2);
    CHECK_THAT(to_markdown(e), Contains("; 1 of 2 contacts, 1 without a reference") && Contains("2 contacts were drawn, 1 of them without an FE reference"));
}

TEST_CASE("drawn contacts have displacement errors and fields of median and worst are kept for figures") {
    Cases cases = perfect().cases;
    for (std::size_t p : {0, 1}) {
        cases.paths.push_back(cases.paths[p]);
        cases.paths.back().role = "held_out";
        cases.paths.back().name = "drawn-" + std::to_string(p);
    }
    TrainedModel model = perfect().model;
    model.trained.front().theta *= 2;  // the force is wrong, the displacements are not
    const Evaluation e = evaluated(model, cases);
    const nlohmann::json j = nlohmann::json::parse(to_json(e, 11)), &held_out = j["closed_loop"]["held_out"];
    CHECK(held_out["learned"]["median"].get<double>() == Approx(1).epsilon(tolerance::solve));
    CHECK(held_out["learned"]["shape"]["max"].get<double>() <= tolerance::solve);
    CHECK(held_out["learned"]["shape_max_over_depth"]["max"].get<double>() <= tolerance::solve);
    CHECK(held_out["uniform"]["shape"]["median"].get<double>() > 0.01);
    CHECK(held_out["uniform"]["shape"]["n"] == 2);
    CHECK(held_out["force_table"]["n"] == 2);
    CHECK(held_out["force_table"]["shape"].is_null());
    CHECK(held_out["force_table"]["shape_max_over_depth"].is_null());
    CHECK(j["drawn"]["held_out"][1]["shape"]["force_table"].is_null());
    CHECK(j["drawn"]["held_out"][1]["shape"]["uniform"].get<double>() > 0.01);

    const std::size_t uniform = static_cast<std::size_t>(
        std::find(e.held_out.models.begin(), e.held_out.models.end(), "uniform") - e.held_out.models.begin());
    CHECK(j["drawn"]["held_out"][0]["shape"]["uniform"] == *e.held_out.roles[0].contacts[0].error[uniform].shape);
    REQUIRE(j["drawn_shapes"].size() == 2);
    CHECK(j["drawn_shapes"][0]["name"] != j["drawn_shapes"][1]["name"]);
    for (const nlohmann::json& shape : j["drawn_shapes"]) {
        const auto path = std::find_if(cases.paths.begin(), cases.paths.end(),
                                       [&](const LoadPath& p) { return p.name == shape["name"]; });
        const NodeField& u = path->records.back().displacement;
        REQUIRE(shape["displacement_m"].size() == static_cast<std::size_t>(u.rows()));
        for (Eigen::Index i = 0; i < u.rows(); ++i)
            for (Eigen::Index axis : {0, 1})
                CHECK(std::abs(shape["displacement_m"][i][axis].get<double>() - u(i, axis)) <= tolerance::solve * u.norm());
    }
    CHECK_THAT(to_markdown(e), Contains("; displacement error"));
}

TEST_CASE("kept displacement fields are those of the learned springs at the median and the worst contact") {
    Cases cases = perfect().cases;
    for (std::size_t p : {0, 1, 0}) {
        cases.paths.push_back(cases.paths[p]);
        LoadPath& path = cases.paths.back();
        path.role = "held_out";
        path.name = "drawn-" + std::to_string(cases.paths.size());
        if (cases.paths.size() == 5) path.records.back().displacement *= 1.5;  // displacements that no model has
    }
    TrainedModel model = perfect().model;
    model.trained.front().theta = model.heuristic_a.transpose().replicate(model.trained.front().theta.rows(), 1);
    const Evaluation e = evaluated(model, cases);
    std::vector<std::pair<double, std::string>> order;
    for (const DrawnContact& c : e.held_out.role("held_out")->contacts) order.emplace_back(*c.error[0].shape, c.name);
    std::sort(order.begin(), order.end());
    REQUIRE(e.held_out.shapes.size() == 2);
    for (std::size_t i : {0, 1}) {
        const DrawnShape& shape = e.held_out.shapes[i];
        CHECK(shape.name == order[i + 1].second);
        const LoadPath& path = *std::find_if(cases.paths.begin(), cases.paths.end(),
                                             [&](const LoadPath& p) { return p.name == shape.name; });
        const NodeField& u = path.records.back().displacement;
        CHECK((shape.displacement_m - u).norm() / u.norm() == Approx(order[i + 1].first).epsilon(tolerance::solve));
    }
}

TEST_CASE("the report lists the study and every model and every case") {
    const Evaluation e = evaluated(perfect().model, perfect().cases);
    const std::string report = to_markdown(e);
    CHECK_THAT(report, Contains("example"));
    for (const ModelErrors& m : e.models) CHECK_THAT(report, Contains("| " + m.name + " |"));
    for (const std::string& name : e.case_names) CHECK_THAT(report, Contains("| " + name + " |"));
}

TEST_CASE("the relative loss of a set is not below its bound and other objectives have no bound") {
    for (const auto& [objective, ridge] : {std::pair{"force", 0.0}, std::pair{"force", 1.0}, std::pair{"contact", 0.0}}) {
        Study study = perfect().study;
        study.springs.law = "axial";
        study.training.objective = objective;
        study.training.ridge = ridge;
        const TrainedModel model = train_sets(study, perfect().cases, 2);
        const std::string report = to_markdown(evaluated(model, perfect().cases));
        CAPTURE(objective, ridge);
        std::istringstream table(report.substr(report.find("| set | L_lb N | L_lb relative |")));
        std::string row;
        std::getline(table, row), std::getline(table, row);
        for (std::size_t c = 0; c < model.case_names.size(); ++c) {
            std::getline(table, row);
            INFO(row);
            std::istringstream cells(row);
            std::string nothing, name, bound_N, bound;
            std::getline(cells, nothing, '|'), std::getline(cells, name, '|'), std::getline(cells, bound_N, '|'), std::getline(cells, bound, '|');
            CHECK(name == " " + model.case_names[c] + " ");
            const bool alone = std::string(objective) == "force" && ridge == 0;
            CHECK((bound != " none ") == alone);
            for (const SetDiagnostics& t : model.books.trained) {
                std::string loss;
                std::getline(cells, loss, '|');
                if (alone) CHECK(std::stod(loss) >= std::stod(bound));
                CHECK(std::stod(loss) == Approx(100 * t.rel_loss[static_cast<Eigen::Index>(c)]).margin(0.051));
            }
        }
    }
}

TEST_CASE("evaluation of a model with other cases or an unknown spring law is refused") {
    const Example& x = perfect();
    Cases cases = x.cases;
    std::swap(cases.paths[0], cases.paths[1]);
    CHECK_THAT(refusal<MismatchError>([&] { evaluated(x.model, cases); }), Contains("other cases"));
    TrainedModel renamed = x.model;
    renamed.case_names[0] += " of others";
    CHECK_THAT(refusal<MismatchError>([&] { evaluated(renamed, x.cases); }), Contains("other cases"));
    cases = x.cases;
    cases.nodes *= 1.01;
    CHECK_THROWS_AS(evaluated(x.model, cases), MismatchError);
    cases = x.cases;
    cases.paths.pop_back();
    CHECK_THROWS_AS(evaluated(x.model, cases), MismatchError);
    TrainedModel model = x.model;
    model.law = "elastic";
    CHECK_THROWS_AS(evaluated(model, x.cases), MismatchError);
}
