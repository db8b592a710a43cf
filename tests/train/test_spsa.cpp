#include <catch2/catch.hpp>

#include "small_problem.h"
#include "train/bounded_lsq.h"
#include "train/certificate.h"
#include "train/spsa.h"

using namespace tissue;
using namespace tissue::test;

namespace {

constexpr double goal = 0.02;        // required gap of a trained set
constexpr double seed_noise = 1e-6;  // of theta: the seed changes rounding alone, amplified by the conjugate directions

TrainSummary train(const Problem& p, unsigned long seed = 1, const StopCriteria& stop = {}) {
    return Spsa().minimise(p.loss, p.start, p.box, 1, stop, seeded_rng(seed).get());
}

double gap_of(const Problem& p, double loss) {
    const Eigen::VectorXd best = solve_bounded_lsq(p.loss, p.start, p.box).theta;
    return loss_gap(loss, loss_lower_bound(p.loss, best, p.box), p.loss.scale());
}

}  // namespace

TEST_CASE("SPSA converges to a known optimum with springs at both bounds of the box") {
    for (unsigned long seed = 1; seed <= 10; ++seed) {
        const Problem p = problem_with_active_bounds(60, 45, seed);
        const TrainSummary s = train(p);
        CHECK(s.status == TrainStatus::converged);
        CHECK(loss_gap(s.loss, p.loss(p.optimum), p.loss.scale()) < 1e-3);  // SpsaOptions::gap_tolerance
        CHECK(s.loss == Approx(p.loss(s.theta)).epsilon(1e-9));
        CHECK((s.theta - p.box.project(s.theta)).norm() == 0);
    }
}

TEST_CASE("SPSA comes within 2 % of the optimum on lattices of every spring law") {
    for (const char* law : {"isotropic", "axial", "geometric"})
        for (const char* topology : {"grid4", "grid8"})
            for (const double softest : {0.3, -1.0}) {  // reference inside the box, and about half of it below
                const Problem p = lattice_problem(topology, law, 6, 2, softest);
                CAPTURE(law, topology, softest);
                CHECK(gap_of(p, train(p).loss) < goal);
            }
}

TEST_CASE("SPSA leaves the bounds of the box on which it starts") {
    for (const double side : {1.0, 3.0}) {
        Problem p = problem_with_active_bounds(60, 45, 2);
        p.start.setConstant(side);
        CHECK(loss_gap(train(p).loss, p.loss(p.optimum), p.loss.scale()) < 1e-3);
    }
}

TEST_CASE("SPSA finds the optimum of one spring in less than ten evaluations") {
    const Problem p{plain_loss(Eigen::MatrixXd::Constant(1, 1, 2), Eigen::VectorXd::Constant(1, 4)), make_box(1, 0, 9),
                    Eigen::VectorXd::Ones(1), Eigen::VectorXd::Constant(1, 2)};
    const TrainSummary s = train(p);
    CHECK(s.theta[0] == Approx(2).epsilon(1e-9));
    CHECK(s.evaluations < 10);
}

TEST_CASE("SPSA keeps springs without influence on the data at their start") {
    Problem p = problem_with_active_bounds(20, 12, 3);
    Eigen::MatrixXd B = Eigen::MatrixXd(p.loss.matrix());
    B.col(4).setZero();
    B.col(7) *= 1e-7;  // its curvature lies at the rounding of the loss
    p.loss = plain_loss(B, p.loss.target());
    const TrainSummary s = train(p);
    CHECK(s.theta[4] == p.start[4]);
    CHECK(s.theta[7] == p.start[7]);
    CHECK(gap_of(p, s.loss) < goal);
}

TEST_CASE("the loss of SPSA never rises and an iteration takes two evaluations") {
    const Problem p = lattice_problem("grid8", "axial", 8, 4, -1.0);
    const TrainSummary s = train(p);
    REQUIRE(s.curve.size() > 5);
    for (std::size_t k = 1; k < s.curve.size(); ++k) CHECK(s.curve[k].loss <= s.curve[k - 1].loss);
    CHECK(s.iterations == (s.evaluations + 1) / 2);
    CHECK(s.restarts == 0);
}

TEST_CASE("SPSA is deterministic for a seed and another seed gives the same springs to 1e-6") {
    const Problem p = problem_with_active_bounds(60, 45, 5);
    const TrainSummary first = train(p, 7), same = train(p, 7), other = train(p, 8);
    CHECK(first.theta == same.theta);
    CHECK(first.evaluations == same.evaluations);
    CHECK((first.theta - other.theta).cwiseAbs().maxCoeff() < seed_noise);
}

TEST_CASE("SPSA stays at an optimum and ends at a loss of zero") {
    Problem p = problem_with_active_bounds(60, 45, 6);
    p.start = p.optimum;
    CHECK(train(p).loss <= p.loss(p.optimum) * (1 + 1e-12));

    p.loss = plain_loss(Eigen::MatrixXd(p.loss.matrix()), Eigen::VectorXd::Zero(60));
    p.box.lo.setZero();
    p.start.setZero();
    const TrainSummary s = train(p);
    CHECK(s.loss == 0);
    CHECK(s.theta.norm() == 0);
}

TEST_CASE("SPSA stopped within a failing move has status iterations_done and keeps to its limit") {
    const Problem p = problem_with_active_bounds(60, 45, 3);
    SpsaOptions options;
    options.gap_tolerance = -1;  // its certificate never ends it: the last move fails
    const auto trained = [&](int iterations) {
        StopCriteria stop;
        stop.iterations = iterations;
        return Spsa(options).minimise(p.loss, p.start, p.box, 1, stop, seeded_rng(1).get());
    };
    const TrainSummary end = trained(100000);
    const int all = end.iterations;
    REQUIRE(all > 100);
    CHECK(end.status == TrainStatus::stalled);
    CHECK(loss_gap(end.loss, p.loss(p.optimum), p.loss.scale()) < 1e-3);
    for (int iterations = all - 30; iterations < all; ++iterations) {
        const TrainSummary s = trained(iterations);
        CAPTURE(all, iterations);
        CHECK(s.status == TrainStatus::iterations_done);
        CHECK(s.iterations == iterations);
    }
}
