#include <catch2/catch.hpp>

#include "error.h"
#include "small_problem.h"
#include "train/bounded_lsq.h"
#include "train/nlopt_optimizer.h"
#include "train/optimizer.h"

using namespace tissue;
using namespace tissue::test;

namespace {

const char* const iterative[] = {"spsa-2008", "spsa", "nlopt:LD_LBFGS", "nlopt:LN_BOBYQA"};

TrainSummary train(const std::string& name, const Problem& p, const StopCriteria& stop = {}) {
    return optimizers().at(name)->minimise(p.loss, p.start, p.box, 1, stop, tissue::seeded_rng(1).get());
}

}  // namespace

TEST_CASE("every optimiser is found under its own name") {
    for (const char* name : {"spsa-2008", "spsa", "exact", "nlopt:LD_LBFGS", "nlopt:LN_BOBYQA"})
        CHECK(optimizers().at(name)->name() == name);
    for (const std::string& algorithm : nlopt_algorithm_names())
        CHECK(optimizers().at("nlopt:" + algorithm)->name() == "nlopt:" + algorithm);
}

TEST_CASE("an unknown optimiser is refused with the allowed names") {
    CHECK_THROWS_AS(optimizers().at("spsa-1998"), MismatchError);
    CHECK_THROWS_WITH(optimizers().at("sgd"), Catch::Contains("'sgd'") && Catch::Contains("spsa-2008, spsa, exact"));
    CHECK_THROWS_AS(optimizers().at("nlopt:LD_NEWTON"), MismatchError);
    CHECK_THROWS_WITH(optimizers().at("nlopt:"), Catch::Contains("LD_LBFGS") && Catch::Contains("LN_BOBYQA"));
}

TEST_CASE("every optimiser refuses inconsistent sizes and an empty box and an outside start and zero modulus") {
    const Problem p = problem_with_active_bounds(12, 6, 1);
    for (const char* name : {"spsa-2008", "spsa", "exact", "nlopt:LD_LBFGS"}) {
        CAPTURE(name);
        const Optimizer& optimizer = *optimizers().at(name);
        const tissue::Rng rng = tissue::seeded_rng(1);
        const auto attempt = [&](const Eigen::VectorXd& start, const Box& box, double unit) {
            optimizer.minimise(p.loss, start, box, unit, {}, rng.get());
        };
        CHECK_THROWS_AS(attempt(Eigen::VectorXd::Ones(5), p.box, 1), MismatchError);
        CHECK_THROWS_AS(attempt(p.start, make_box(7, 1, 3), 1), MismatchError);
        CHECK_THROWS_AS(attempt(p.start, make_box(6, 3, 1), 1), MismatchError);
        CHECK_THROWS_AS(attempt(p.start, make_box(6, 1, 1.5), 1), MismatchError);
        CHECK_THROWS_AS(attempt(p.start, make_box(6, 2.5, 3), 1), MismatchError);
        CHECK_THROWS_AS(attempt(p.start, p.box, 0), MismatchError);
    }
}

TEST_CASE("training ends at the requested number of iterations including zero") {
    const Problem p = lattice_problem("grid4", "isotropic", 6, 2, -1.0);
    for (const char* name : iterative)
        for (int iterations : {0, 1, 33}) {
            CAPTURE(name, iterations);
            StopCriteria stop;
            stop.iterations = iterations;
            const TrainSummary s = train(name, p, stop);
            CHECK(s.status == TrainStatus::iterations_done);
            CHECK(s.iterations == iterations);
            CHECK(s.theta.size() == p.start.size());
            if (iterations == 0) CHECK(s.theta == p.start);
        }
}

TEST_CASE("training ends at its time limit") {
    const Problem p = lattice_problem("grid8", "isotropic", 10, 2, -1.0);
    StopCriteria stop;
    stop.iterations = 1000000000;
    stop.max_seconds = 1e-4;  // a few dozen evaluations, so that no training is complete before
    for (const char* name : {"spsa-2008", "spsa", "nlopt:LN_SBPLX"}) {
        CAPTURE(name);
        CHECK(train(name, p, stop).status == TrainStatus::time_out);
    }
    stop.max_seconds = 0;
    for (const char* name : iterative) CHECK(train(name, p, stop).iterations == 0);
}

TEST_CASE("training ends when the target loss is reached") {
    const Problem p = problem_with_active_bounds(40, 12, 3);
    const double before = p.loss(p.start) / p.loss.scale(), least = p.loss(p.optimum) / p.loss.scale();
    StopCriteria stop;
    stop.target_rel_loss = 0.5 * (before + least);
    for (const char* name : iterative) {
        CAPTURE(name);
        const TrainSummary s = train(name, p, stop);
        CHECK(s.status == TrainStatus::target_met);
        CHECK(s.loss <= *stop.target_rel_loss * p.loss.scale());
        CHECK(s.iterations > 0);
    }
    stop.target_rel_loss = 2 * before;  // met before the first iteration
    for (const char* name : iterative) CHECK(train(name, p, stop).iterations == 0);
}

TEST_CASE("a learning curve starts at iteration 0 and includes 1000 and 5000 and ends at the result") {
    const Problem p = lattice_problem("grid4", "isotropic", 8, 4, 0.0);
    StopCriteria stop;
    stop.iterations = 6000;
    const TrainSummary s = train("spsa-2008", p, stop);
    std::vector<int> at;
    for (const LearningPoint& point : s.curve) at.push_back(point.iteration);
    CHECK(at == std::vector<int>{0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 6000});
    CHECK(s.curve.front().loss == Approx(p.loss(p.start)));
    CHECK(s.curve.back().loss == s.loss);
    CHECK(s.loss == p.loss(s.theta));
}

TEST_CASE("gradient-based optimisers of NLopt reach the loss of the exact solver to 1 %") {
    const Problem p = lattice_problem("grid4", "axial", 4, 5, -1.0);
    const double least = solve_bounded_lsq(p.loss, p.start, p.box).residual_norm;
    StopCriteria stop;
    stop.iterations = 2000;
    for (const std::string& algorithm : nlopt_algorithm_names()) {
        if (algorithm.rfind("LD_", 0) != 0) continue;
        CAPTURE(algorithm);
        const TrainSummary s = train("nlopt:" + algorithm, p, stop);
        CHECK(s.loss == Approx(least).epsilon(1e-2));
        CHECK((s.theta - p.box.project(s.theta)).norm() == 0);
    }
}

TEST_CASE("the exact solver as an optimiser has status converged and returns the optimum") {
    const Problem p = problem_with_active_bounds(40, 30, 6);
    const TrainSummary s = train("exact", p);
    CHECK(s.status == TrainStatus::converged);
    CHECK((s.theta - p.optimum).norm() < 1e-9);
    CHECK(s.curve.back().loss == s.loss);
}

TEST_CASE("every training status has its own text") {
    CHECK(std::string(to_string(TrainStatus::stalled)) == "stalled");
    CHECK(std::string(to_string(TrainStatus::iterations_done)) == "iterations_done");
    CHECK(std::string(to_string(TrainStatus::time_out)) == "time_out");
    CHECK(std::string(to_string(TrainStatus::target_met)) == "target_met");
    CHECK(std::string(to_string(TrainStatus::converged)) == "converged");
    CHECK(std::string(to_string(TrainStatus::restarts_exhausted)) == "restarts_exhausted");
}
