#include "train/objective.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../example.h"
#include "../refusal.h"
#include "error.h"
#include "small_problem.h"
#include "springs/heuristic.h"
#include "study/kinds.h"
#include "train/endings.h"
#include "train/train_sets.h"

using namespace tissue;
using namespace tissue::test;
using Catch::Matchers::Contains;

namespace {

Cases cases_of(const Study& study) {
    return example_cases(study, example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1)));
}

/// The example with objective contact and the exact optimiser, on a mesh of this topology.
Study contact_study(const std::string& topology) {
    Study study = example_study();
    study.springs.topology = topology;
    study.springs.law = "axial";
    study.training.objective = "contact";
    study.training.optimizer = "exact";
    study.training.also = {};
    study.training.ridge = 1;
    return study;
}

using Words = std::vector<std::string>;

}  // namespace

TEST_CASE("every objective is found by name and an unknown one is refused with the allowed names", "[objective]") {
    for (const auto& objective : objectives().kinds()) CHECK(objectives().at(objective->name()) == objective);
    CHECK_THAT(refusal<MismatchError>([] { objectives().at("torque"); }),
               Contains("'torque'") && Contains("force, contact"));
}

TEST_CASE("a study accepts every objective and optimiser of the registries", "[objective]") {
    CHECK(objective_names() == objectives().names());
    for (const std::string& name : objective_names()) {
        const std::string text = with(example_study_text(), "seed = 11", "seed = 11\nobjective = \"" + name + "\"");
        CHECK(example_study(text).training.objective == name);
    }
    for (const std::string& name : optimizer_names()) {
        Study study = example_study(with(example_study_text(), "optimizer = \"spsa\"", "optimizer = \"" + name + "\""));
        CHECK(study.training.optimizer == name);
    }
}

TEST_CASE("objective contact gives status floppy for every case of a mesh with zero-energy modes", "[objective]") {
    const Study stiff = contact_study("grid8"), singular = contact_study("grid4");
    const Cases cases = cases_of(stiff);
    const TrainedModel posed = train_sets(stiff, cases, 2), bare = train_sets(singular, cases, 2);
    CHECK(posed.books.problems.objective == "contact");
    CHECK(posed.books.problems.status == Words(4, "posed"));
    CHECK(posed.books.problems.one_set_status == "posed");
    CHECK(endings_of(posed.books.problems, posed.books.trained, posed.books.optimum).broken.empty());
    CHECK(bare.books.problems.status == Words(4, "floppy"));
    const Words broken = endings_of(bare.books.problems, bare.books.trained, bare.books.optimum).broken;
    REQUIRE(broken.size() == 1);
    CHECK_THAT(broken.front(), Contains("objective contact") && Contains("of 4 sets 4 floppy"));
}

TEST_CASE("a load case without force has status no_force and does not change other sets", "[objective]") {
    for (const char* objective : {"force", "contact"}) {
        Study study = example_study();
        study.training.objective = objective;
        study.training.optimizer = "exact";
        Cases cases = cases_of(study), fewer = cases;
        fewer.paths.pop_back();
        for (PathRecord& r : cases.paths.back().records) r.force.setZero(), r.contact_force_N.setZero();
        const TrainedModel model = train_sets(study, cases, 1), without = train_sets(study, fewer, 1);
        CAPTURE(objective);
        CHECK(model.books.problems.status == Words{"posed", "posed", "no_force", "no_force"});
        CHECK(model.one_set == without.one_set);
        CHECK(model.optimum.topRows(2) == without.optimum);
        CHECK(model.optimum.allFinite());
        CHECK(model.books.trained.front().gap.allFinite());
        CHECK(std::isnan(model.books.optimum.rel_loss[3]));  // no loss is relative to a zero force
        CHECK_FALSE(endings_of(model.books.problems, model.books.trained, model.books.optimum).broken.empty());
    }
}

TEST_CASE("load cases without any force give the heuristic as common set with status no_force", "[objective]") {
    const Study study = example_study();
    Cases cases = cases_of(study);
    for (LoadPath& path : cases.paths)
        for (PathRecord& r : path.records) r.force.setZero();
    const TrainedModel model = train_sets(study, cases, 1);
    CHECK(model.books.problems.one_set_status == "no_force");
    CHECK(model.one_set == model.heuristic_a);
}

TEST_CASE("a problem is posed if its solve converged and else has the status of the solve", "[objective]") {
    CHECK(problem_status(LsqStatus::converged) == ProblemStatus::set_up);
    CHECK(problem_status(LsqStatus::stalled) == ProblemStatus::stalled);
    CHECK(problem_status(LsqStatus::iterations_done) == ProblemStatus::iterations_done);
}

TEST_CASE("a joint loss has the minimum of the sum of its losses even for few equations", "[objective]") {
    const tissue::Rng rng = tissue::seeded_rng(3);
    std::vector<ForceLoss> losses;
    for (int i = 0; i < 3; ++i) losses.push_back(plain_loss(random_matrix(4, 40, rng.get()), random_matrix(4, 1, rng.get())));
    const Box box = make_box(40, -10, 10);
    const auto joint = joint_loss(losses);
    REQUIRE(joint);
    const Eigen::VectorXd theta = solve_bounded_lsq(*joint, Eigen::VectorXd::Zero(40), box).theta;
    for (const ForceLoss& loss : losses) CHECK(loss(theta) < 1e-5 * loss.scale());  // twelve equations, forty springs

    // columns of very different length, half of them the same
    std::vector<ForceLoss> same;
    Eigen::MatrixXd B = Eigen::MatrixXd::Constant(2, 400, 1e-5);
    B.leftCols(200) = 1e3 * random_matrix(2, 1, rng.get()).replicate(1, 200);
    same.push_back(plain_loss(B, B.rowwise().sum()));
    const auto found = joint_loss(same);
    REQUIRE(found);
    CHECK(found->matrix().toDense().allFinite());
    CHECK((*found)(Eigen::VectorXd::Ones(400)) < 1e-2 * found->scale());
}

TEST_CASE("losses without force or without springs have no joint loss", "[objective]") {
    const ForceLoss no_force = plain_loss(Eigen::MatrixXd::Ones(2, 3), Eigen::VectorXd::Zero(2));
    const ForceLoss no_springs = plain_loss(Eigen::MatrixXd::Zero(2, 3), Eigen::VectorXd::Ones(2));
    CHECK_FALSE(joint_loss({}));
    CHECK_FALSE(joint_loss({no_force}));
    CHECK_FALSE(joint_loss({no_springs, no_force}));
    CHECK(std::isnan(no_force.relative(Eigen::VectorXd::Ones(3))));
    CHECK(no_springs.relative(Eigen::VectorXd::Ones(3)) == 1);
}
