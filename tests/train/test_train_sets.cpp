#include "train/train_sets.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <tuple>

#include "error.h"
#include "../example.h"
#include "../refusal.h"
#include "springs/spring_law.h"
#include "../tolerances.h"
#include "train/force_loss.h"
#include "train/loss_terms.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

Cases cases_of(const Study& study) {
    return example_cases(study, example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1)));
}

/// sqrt(f_fe' Q f_fe) of a load case [N]. With objective contact, f_fe is the contact force at the ends of its segment.
double fe_scale(const TrainedModel& model, const Cases& cases, std::size_t c) {
    const LoadCase load = load_cases(cases)[c];
    const Eigen::VectorXd weight = model.books.node_weight.row(static_cast<Eigen::Index>(c));
    const Target target = model.books.problems.objective == "force"
                              ? force_target(load, weight)
                              : contact_target(model.mesh, load, locate_on_surface(model.mesh, load.path->contact_m), weight);
    return loss_of(model.mesh, *make_spring_law(model.law), target).scale();
}

}  // namespace

TEST_CASE("the trained sets do not depend on the number of threads") {
    const Study study = example_study();
    const Cases cases = cases_of(study);
    const TrainedModel one = train_sets(study, cases, 1), three = train_sets(study, cases, 3);
    CHECK(one.books.node_weight == three.books.node_weight);
    REQUIRE(one.trained.size() == three.trained.size());
    for (std::size_t t = 0; t < one.trained.size(); ++t) {
        CHECK(one.trained[t].theta == three.trained[t].theta);
        CHECK(one.books.trained[t].loss_N == three.books.trained[t].loss_N);
        CHECK(one.books.trained[t].iterations == three.books.trained[t].iterations);
        CHECK(one.books.trained[t].restarts == three.books.trained[t].restarts);
        CHECK(one.books.trained[t].status == three.books.trained[t].status);
        CHECK(one.books.trained[t].curve_iteration == three.books.trained[t].curve_iteration);
    }
    CHECK(one.optimum == three.optimum);
}

TEST_CASE("a trained set depends on the seed and its own name and not on other sets") {
    const Study study = example_study();
    Cases cases = cases_of(study);
    const TrainedModel both = train_sets(study, cases, 2);
    cases.paths.erase(cases.paths.begin());
    const TrainedModel alone = train_sets(study, cases, 2);
    CHECK(alone.case_names == std::vector<std::string>{"corner-4mm", "corner-8mm"});
    CHECK(alone.books.node_weight == both.books.node_weight.bottomRows(2));
    for (std::size_t t = 0; t < both.trained.size(); ++t)
        CHECK(alone.trained[t].theta == both.trained[t].theta.bottomRows(2));
}

TEST_CASE("another seed draws another Q and trains other sets") {
    Study study = example_study();
    const Cases cases = cases_of(study);
    const TrainedModel first = train_sets(study, cases, 1);
    study.training.seed += 1;
    const TrainedModel second = train_sets(study, cases, 1);
    CHECK((first.books.node_weight - second.books.node_weight).cwiseAbs().maxCoeff() > 1e-3);
    CHECK(first.trained.front().theta != second.trained.front().theta);
}

TEST_CASE("weights Q are drawn higher for the 3 x 3 nodes about the contact than for others") {
    const Study study = example_study();
    const TrainedModel model = train_sets(study, cases_of(study), 1);
    std::set<double> drawn;
    for (Eigen::Index c = 0; c < model.case_count(); ++c) {
        int near_nodes = 0;
        for (int i = 0; i < model.mesh.node_count(); ++i) {
            const double away = (model.mesh.nodes.row(i) - model.contact_m.row(c)).cwiseAbs().maxCoeff();
            const bool near = away < 1.5 * 0.025;
            const auto& range = near ? study.training.weight_near : study.training.weight_far;
            CHECK(model.books.node_weight(c, i) >= range[0]);
            CHECK(model.books.node_weight(c, i) <= range[1]);
            near_nodes += near ? 1 : 0;
            drawn.insert(model.books.node_weight(c, i));
        }
        const bool corner = model.case_names[static_cast<std::size_t>(c)].rfind("corner", 0) == 0;
        CHECK(near_nodes == (corner ? 4 : 6));  // of the 3 x 3, those in the tissue
    }
    CHECK(drawn.size() == 4 * 25);  // every node of every case has its own weight
}

TEST_CASE("every trained set lies in the box with its recorded loss and no larger loss than the heuristic") {
    const Study study = example_study();
    const Cases cases = cases_of(study);
    const TrainedModel model = train_sets(study, cases, 2);
    const auto law = make_spring_law(model.law);
    const std::vector<LoadCase> loads = load_cases(cases);
    for (std::size_t o = 0; o < model.trained.size(); ++o) {
        const SetDiagnostics& t = model.books.trained[o];
        const NodeField& theta = model.trained[o].theta;
        CHECK(t.optimizer == model.trained[o].optimizer);
        CHECK(theta.minCoeff() >= study.training.k_min_E2 * model.modulus_N_m * (1 - tolerance::rounding));
        CHECK(theta.maxCoeff() <= study.training.k_max_E2 * model.modulus_N_m * (1 + tolerance::rounding));
        for (Eigen::Index c = 0; c < theta.rows(); ++c) {
            const LoadCase& load = loads[static_cast<std::size_t>(c)];
            const NodeField weight = model.books.node_weight.row(c).transpose().replicate(1, 2);
            const ForceLoss loss(law->force_matrix(model.mesh, load.record->displacement),
                                 as_vector(load.record->force), as_vector(weight));
            CHECK(t.loss_N[c] == Approx(loss(theta.row(c).transpose())).epsilon(tolerance::solve));
            CHECK(t.rel_loss[c] == Approx(t.loss_N[c] / loss.scale()).epsilon(tolerance::rounding));
            CHECK(t.loss_N[c] <= loss(model.heuristic_a));
            CHECK(t.curve_loss_N(c, 0) == Approx(loss(model.heuristic_a)).epsilon(tolerance::solve));
            CHECK(model.books.optimum.lower_bound_N[c] <= t.loss_N[c] * (1 + tolerance::solve));
        }
    }
}

TEST_CASE("a trained model has masses and modulus and heuristics and contacts and displacements of its study") {
    const Study study = example_study();
    const TrainedModel model = train_sets(study, cases_of(study), 1);
    CHECK(model.modulus_N_m == Approx(6 * (263 + 491) * 0.0003).epsilon(tolerance::rounding));
    CHECK(model.node_mass_kg.sum() == Approx(1040 * 0.0003 * 0.01).epsilon(tolerance::rounding));
    CHECK(model.heuristic_a.isApprox(6 * model.heuristic_b, tolerance::rounding));
    CHECK(model.contact_m.row(3) == Eigen::RowVector2d(0.1, 0.1));
    CHECK(model.magnitude_m[3] == Approx(0.008).epsilon(tolerance::rounding));
    CHECK(model.direction.row(0) == Eigen::RowVector2d(1, 0));
}

TEST_CASE("an optimiser named twice trains once and the main optimiser of the study comes first") {
    Study study = example_study();
    study.training.also = {"spsa-2008", "spsa", "spsa-2008"};
    const TrainedModel model = train_sets(study, cases_of(study), 1);
    REQUIRE(model.trained.size() == 2);
    CHECK(model.trained[0].optimizer == "spsa");
    CHECK(model.trained[1].optimizer == "spsa-2008");
}

TEST_CASE("training progress counts every set once up to the total") {
    const Study study = example_study();
    std::vector<int> compared;
    int last_total = 0;
    train_sets(study, cases_of(study), 3, [&](int done, int total, const std::string& set) {
        CHECK_FALSE(set.empty());
        compared.push_back(done);
        last_total = total;
    });
    REQUIRE(last_total > 0);
    REQUIRE(static_cast<int>(compared.size()) == last_total);
    for (std::size_t i = 0; i < compared.size(); ++i) CHECK(compared[i] == static_cast<int>(i) + 1);
}

TEST_CASE("cases of another lattice are refused with study and lattice") {
    const Study study = example_study();
    Cases cases = cases_of(study);
    cases.nodes *= 1.001;
    CHECK_THAT(refusal<MismatchError>([&] { train_sets(study, cases, 1); }), Contains("example") && Contains("5 x 5"));
    const Study coarse = example_study(with(example_study_text(), "cells = [4, 4]", "cells = [2, 2]"));
    CHECK_THROWS_AS(train_sets(coarse, cases_of(study), 1), MismatchError);
}

TEST_CASE("training with an unknown optimiser or a missing record is refused also in several threads") {
    Study study = example_study();
    Cases cases = cases_of(study);
    study.training.optimizer = "adam";
    CHECK_THAT(refusal<MismatchError>([&] { train_sets(study, cases, 2); }), Contains("adam") && Contains("spsa-2008"));
    study = example_study();
    cases.paths[1].records.pop_back();
    CHECK_THROWS_AS(train_sets(study, cases, 2), MismatchError);
}

TEST_CASE("statuses of a training are read back from model.h5 and are empty for earlier files") {
    const Study study = example_study();
    const TrainedModel model = train_sets(study, cases_of(study), 1);
    CHECK(model.books.optimum.status == std::vector<std::string>(4, "converged"));
    CHECK(model.books.problems.objective == "force");
    CHECK(model.books.problems.status == std::vector<std::string>(4, "posed"));
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5");
    write_trained_model(file, model, {});
    TrainedModel back = read_trained_model(file);
    CHECK(back.books.optimum.status == model.books.optimum.status);
    CHECK(back.books.problems.objective == "force");
    CHECK(back.books.problems.status == model.books.problems.status);
    CHECK(back.books.problems.one_set_status == "posed");
    CHECK(back.books.trained[1].status == model.books.trained[1].status);
    replace_dataset(file, "/optimum/status");
    replace_dataset(file, "/problems/status");
    back = read_trained_model(file);
    CHECK(back.books.optimum.status.empty());
    CHECK(back.books.problems.status.empty());
}

TEST_CASE("a set with status target_met has a loss within its target for every objective and ridge", "[objective]") {
    int met = 0;
    for (const auto& [objective, ridge, target] : {std::tuple{"force", 1.0, 0.7}, std::tuple{"contact", 0.0, 0.05}, std::tuple{"contact", 1.0, 0.3}}) {
        Study study = example_study();
        study.springs.law = "axial";
        study.training.objective = objective;
        study.training.ridge = ridge;
        study.training.optimizer = "spsa";
        study.training.also = {"spsa-2008", "nlopt:LD_LBFGS"};
        study.training.target_rel_loss = target;
        const Cases cases = cases_of(study);
        const TrainedModel model = train_sets(study, cases, 2);
        CAPTURE(objective, ridge);
        for (const SetDiagnostics& t : model.books.trained)
            for (Eigen::Index c = 0; c < t.loss_N.size(); ++c) {
                CAPTURE(t.optimizer, c);
                met += t.status[static_cast<std::size_t>(c)] == "target_met";
                const double scale = fe_scale(model, cases, static_cast<std::size_t>(c));
                CHECK(t.rel_loss[c] * scale <= t.loss_N[c] * (1 + tolerance::solve));
                if (t.status[static_cast<std::size_t>(c)] != "target_met") continue;
                CHECK(t.loss_N[c] <= target * scale * (1 + tolerance::solve));
                CHECK(t.rel_loss[c] <= target * (1 + tolerance::solve));
            }
    }
    CHECK(met > 0);
}

TEST_CASE("training spring sets without any load case is refused with the cause") {
    const Study study = example_study();
    Cases cases = cases_of(study);
    for (LoadPath& path : cases.paths) {
        path.records.resize(1);  // ended before the first magnitude
        path.lost = "the tangent is not positive definite";
    }
    CHECK_THAT(refusal<MismatchError>([&] { train_sets(study, cases, 1); }), Contains("none of its") && Contains("first load case") && Contains("the tangent is not positive definite"));
}
