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

/// Springs that do not know of each other: the best stiffness of spring s is best[s].
Problem separate_springs(const Eigen::VectorXd& best, double lo = 0.05, double hi = 40) {
    const Eigen::Index n = best.size();
    return {plain_loss(Eigen::MatrixXd::Identity(n, n), best), make_box(n, lo, hi), Eigen::VectorXd::Ones(n), best};
}

Spsa2008Options quick() {
    Spsa2008Options options;
    options.first_step = 0.05;  // small problems bear larger steps than 220 springs
    return options;
}

}  // namespace

TEST_CASE("the paper's spsa comes near the optimum of a few springs without a restart") {
    const Problem p = separate_springs(Eigen::VectorXd::LinSpaced(6, 1.5, 4));
    const TrainSummary s = train(p, 1, {}, quick());
    CHECK(s.status == TrainStatus::iterations_done);
    CHECK(s.restarts == 0);
    CHECK((s.theta - p.optimum).cwiseAbs().maxCoeff() < 0.1);  // a stochastic walk's step at its end
    CHECK(s.loss < 0.03 * p.loss(p.start));
}

TEST_CASE("a spring that turns negative starts again, and after 20 times the training gives up") {
    Eigen::VectorXd best = Eigen::VectorXd::Constant(4, 2);
    best[1] = -3;
    const TrainSummary s = train(separate_springs(best), 1, {}, quick());
    CHECK(s.status == TrainStatus::restarts_exhausted);
    CHECK(s.restarts == 20);
    CHECK(s.iterations < 20000);
    CHECK(s.theta[1] == 1);                                 // back at its original value
    for (int rest : {0, 2, 3}) CHECK(s.theta[rest] > 1.2);  // on their way to 2, and stayed where they had come to
}

TEST_CASE("a spring that stays positive by itself needs few restarts, as the paper says of fifteen of its cases") {
    const TrainSummary s = train(separate_springs(Eigen::VectorXd::Constant(4, 0.5)), 2, {}, quick());
    CHECK(s.restarts == 0);
    CHECK(s.status == TrainStatus::iterations_done);
}

TEST_CASE("no spring leaves the box in the end: above it is clipped, below it is projected") {
    for (const double best : {9.0, 0.3}) {
        const Problem p = separate_springs(Eigen::VectorXd::Constant(3, best), 0.5, 4);
        const TrainSummary s = train(p, 3, {}, quick());
        CHECK(s.theta == p.box.project(s.theta));
        CHECK((s.theta - p.box.project(p.optimum)).cwiseAbs().maxCoeff() < 0.1);
        CHECK(s.loss == p.loss(s.theta));
    }
}

TEST_CASE("a spring clipped above leaves its share to the others") {
    Problem p{plain_loss(Eigen::MatrixXd::Ones(1, 2), Eigen::VectorXd::Constant(1, 10)), make_box(2, 0.05, 40),
              Eigen::VectorXd::Ones(2), Eigen::Vector2d(2, 8)};
    p.box.hi[0] = 2;
    CHECK(train(p, 1, {}, quick()).loss < 0.1);  // 3 when both walk to 5 and the first is cut back only at the end
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

TEST_CASE("the first step of the paper's spsa has the size that was asked for") {
    const Problem p = separate_springs(Eigen::VectorXd::Constant(1, 30));  // one spring: every estimate is the slope
    Spsa2008Options options;
    options.first_step = 0.07;
    StopCriteria once;
    once.iterations = 1;
    CHECK(train(p, 5, once, options).theta[0] == Approx(1.07).epsilon(1e-9));
}

TEST_CASE("an iteration of the paper's spsa is two evaluations, beside those that find its gain") {
    StopCriteria stop;
    stop.iterations = 500;
    const TrainSummary s = train(separate_springs(Eigen::VectorXd::Constant(4, 2)), 6, stop);
    CHECK(s.evaluations == 2 * 500 + 2 * Spsa2008Options().gradient_estimates);
}

TEST_CASE("the paper's spsa with the same seed gives the same bits, with another does not") {
    const Problem p = lattice_problem("grid4", "isotropic", 4, 1);
    StopCriteria stop;
    stop.iterations = 300;
    const TrainSummary first = train(p, 7, stop);
    CHECK(first.theta == train(p, 7, stop).theta);
    CHECK_FALSE(first.theta == train(p, 8, stop).theta);
}

TEST_CASE("springs without any influence stop no walk") {
    Problem p = separate_springs(Eigen::VectorXd::Constant(3, 2));
    p.loss = plain_loss(Eigen::MatrixXd::Zero(3, 3), p.optimum);
    const TrainSummary s = train(p);
    CHECK(s.theta == p.start);
    CHECK(s.loss == Approx(p.loss.scale()));
}
