#include <catch2/catch.hpp>

#include "small_problem.h"
#include "train/spsa_2008.h"

using namespace tissue;
using namespace tissue::test;

namespace {

TrainSummary train(const Problem& p, unsigned long seed = 1, const StopCriteria& stop = {},
                   const Spsa2008Options& options = {}) {
    return Spsa2008(options).minimise(p.loss, p.start, p.box, 1, stop, seeded_rng(seed).get());
}

/// Independent springs: the optimal stiffness of spring s is best[s].
Problem separate_springs(const Eigen::VectorXd& best, double lo = 0.05, double hi = 40) {
    const Eigen::Index n = best.size();
    return {plain_loss(Eigen::MatrixXd::Identity(n, n), best), make_box(n, lo, hi), Eigen::VectorXd::Ones(n), best};
}

Spsa2008Options quick() {
    Spsa2008Options options;
    options.first_step = 0.05;  // small problems allow larger steps than 220 springs
    return options;
}

}  // namespace

TEST_CASE("the paper's SPSA approaches the optimum of six springs without a restart") {
    const Problem p = separate_springs(Eigen::VectorXd::LinSpaced(6, 1.5, 4));
    const TrainSummary s = train(p, 1, {}, quick());
    CHECK(s.status == TrainStatus::iterations_done);
    CHECK(s.restarts == 0);
    CHECK((s.theta - p.optimum).cwiseAbs().maxCoeff() < 0.1);  // last step of the stochastic search
    CHECK(s.loss < 0.03 * p.loss(p.start));
}

TEST_CASE("a spring that turns negative is restarted and the training ends after 20 restarts") {
    Eigen::VectorXd best = Eigen::VectorXd::Constant(4, 2);
    best[1] = -3;
    const TrainSummary s = train(separate_springs(best), 1, {}, quick());
    CHECK(s.status == TrainStatus::restarts_exhausted);
    CHECK(s.restarts == 20);
    CHECK(s.iterations < 20000);
    CHECK(s.theta[1] == 1);                                 // back at its start
    for (int rest : {0, 2, 3}) CHECK(s.theta[rest] > 1.2);  // they approached 2 and were not reset
}

TEST_CASE("springs with a positive optimum need no restart in the paper's SPSA") {
    const TrainSummary s = train(separate_springs(Eigen::VectorXd::Constant(4, 0.5)), 2, {}, quick());
    CHECK(s.restarts == 0);
    CHECK(s.status == TrainStatus::iterations_done);
}

TEST_CASE("the final springs of the paper's SPSA lie in the box near the projected optimum") {
    for (const double best : {9.0, 0.3}) {
        const Problem p = separate_springs(Eigen::VectorXd::Constant(3, best), 0.5, 4);
        const TrainSummary s = train(p, 3, {}, quick());
        CHECK(s.theta == p.box.project(s.theta));
        CHECK((s.theta - p.box.project(p.optimum)).cwiseAbs().maxCoeff() < 0.1);
        CHECK(s.loss == p.loss(s.theta));
    }
}

TEST_CASE("springs of the paper's SPSA compensate one that is clipped at its upper bound") {
    Problem p{plain_loss(Eigen::MatrixXd::Ones(1, 2), Eigen::VectorXd::Constant(1, 10)), make_box(2, 0.05, 40),
              Eigen::VectorXd::Ones(2), Eigen::Vector2d(2, 8)};
    p.box.hi[0] = 2;
    CHECK(train(p, 1, {}, quick()).loss < 0.1);  // 3 if both approach 5 and the first is clipped only at the end
}

TEST_CASE("no spring moves by more than the paper's limit in one iteration") {
    const Problem p = separate_springs(Eigen::VectorXd::Constant(5, 30));
    Spsa2008Options options;
    options.first_step = 100;
    StopCriteria once;
    once.iterations = 1;
    const TrainSummary s = train(p, 4, once, options);
    CHECK((s.theta - p.start).cwiseAbs().maxCoeff() <= 1);
    CHECK((s.theta - p.start).maxCoeff() == 1);
}

TEST_CASE("the first step of the paper's SPSA has the requested size") {
    // one spring: every gradient estimate is exact
    const Problem p = separate_springs(Eigen::VectorXd::Constant(1, 30));
    Spsa2008Options options;
    options.first_step = 0.07;
    StopCriteria once;
    once.iterations = 1;
    CHECK(train(p, 5, once, options).theta[0] == Approx(1.07).epsilon(1e-9));
}

TEST_CASE("an iteration of the paper's SPSA takes two evaluations besides those for its gain") {
    StopCriteria stop;
    stop.iterations = 500;
    const TrainSummary s = train(separate_springs(Eigen::VectorXd::Constant(4, 2)), 6, stop);
    CHECK(s.evaluations == 2 * 500 + 2 * Spsa2008Options().gradient_estimates);
}

TEST_CASE("the paper's SPSA is deterministic for a seed and another seed gives another result") {
    const Problem p = lattice_problem("grid4", "isotropic", 4, 1);
    StopCriteria stop;
    stop.iterations = 300;
    const TrainSummary first = train(p, 7, stop);
    CHECK(first.theta == train(p, 7, stop).theta);
    CHECK_FALSE(first.theta == train(p, 8, stop).theta);
}

TEST_CASE("springs without influence on the loss keep their start in the paper's SPSA") {
    Problem p = separate_springs(Eigen::VectorXd::Constant(3, 2));
    p.loss = plain_loss(Eigen::MatrixXd::Zero(3, 3), p.optimum);
    const TrainSummary s = train(p);
    CHECK(s.theta == p.start);
    CHECK(s.loss == Approx(p.loss.scale()));
}
