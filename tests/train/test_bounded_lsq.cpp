#include <catch2/catch.hpp>

#include "error.h"
#include "small_problem.h"
#include "train/bounded_lsq.h"
#include "train/certificate.h"

using namespace tissue;
using namespace tissue::test;

namespace {

constexpr double kkt = 1e-12;          // BoundedLsqOptions::kkt_tolerance
constexpr double near_optimum = 1e-9;  // of theta for a well-conditioned B: kkt times its condition number
constexpr double tight_gap = 1e-7;     // of the certificate at that kkt

}  // namespace

TEST_CASE("the exact solver finds a known optimum with springs at both bounds of the box") {
    for (unsigned long seed = 1; seed <= 20; ++seed) {
        const Problem p = problem_with_active_bounds(60, 45, seed);
        const BoundedLsqSummary s = solve_bounded_lsq(p.loss, p.start, p.box);
        CHECK(s.status == LsqStatus::converged);
        CHECK((s.theta - p.optimum).cwiseAbs().maxCoeff() < near_optimum);
        CHECK(s.residual_norm == Approx(p.loss(p.optimum)).epsilon(1e-12));
        CHECK(kkt_residual(p.loss, s.theta, p.box) < 10 * kkt);
    }
}

TEST_CASE("with inactive bounds the exact solver gives the least-squares solution") {
    const tissue::Rng rng = tissue::seeded_rng(1);
    const Eigen::MatrixXd B = random_matrix(30, 20, rng.get());
    const Eigen::VectorXd b = random_matrix(30, 1, rng.get());
    const BoundedLsqSummary s = solve_bounded_lsq(plain_loss(B, b), Eigen::VectorXd::Zero(20), make_box(20, -1e6, 1e6));
    CHECK((s.theta - B.colPivHouseholderQr().solve(b)).norm() < near_optimum);
    CHECK(s.iterations <= 5);  // Newton steps; each removes the error left by the shift of the one before
}

TEST_CASE("forces of a spring set in the box are matched exactly") {
    for (const char* law : {"isotropic", "axial", "geometric"})
        for (const char* topology : {"grid4", "grid8"}) {
            const Problem p = lattice_problem(topology, law, 6, 2);
            const BoundedLsqSummary s = solve_bounded_lsq(p.loss, p.start, p.box);
            CAPTURE(law, topology);
            CHECK(s.status == LsqStatus::converged);
            CHECK(s.residual_norm < 1e-10 * p.loss.scale());
            CHECK((s.theta - p.box.project(s.theta)).norm() == 0);
        }
}

TEST_CASE("the exact solver keeps springs without influence on the data at their start") {
    const tissue::Rng rng = tissue::seeded_rng(3);
    Eigen::MatrixXd B = random_matrix(20, 12, rng.get());
    B.col(4).setZero();
    B.col(7) *= 1e-16;  // the rounding of a displacement that should be zero
    const Eigen::VectorXd start = 2 * Eigen::VectorXd::Ones(12) + 0.5 * random_matrix(12, 1, rng.get());
    const BoundedLsqSummary s =
        solve_bounded_lsq(plain_loss(B, random_matrix(20, 1, rng.get())), start, make_box(12, 1, 3));
    CHECK(s.status == LsqStatus::converged);
    CHECK(s.theta[4] == start[4]);
    CHECK(s.theta[7] == start[7]);

    const BoundedLsqSummary none =
        solve_bounded_lsq(plain_loss(Eigen::MatrixXd::Zero(20, 12), B.col(0)), start, make_box(12, 1, 3));
    CHECK(none.status == LsqStatus::converged);
    CHECK(none.theta == start);
    CHECK(none.residual_norm == Approx(B.col(0).norm()));
}

TEST_CASE("with rank-deficient columns the exact solver still satisfies loss and optimality conditions") {
    // one column repeated and one equal to the sum of two others: the loss depends only on combinations
    Problem p = problem_with_active_bounds(40, 15, 4);
    Eigen::MatrixXd B(40, 17);
    B.leftCols(15) = Eigen::MatrixXd(p.loss.matrix());
    B.col(15) = B.col(2);
    B.col(16) = B.col(2) + B.col(5);
    const ForceLoss loss = plain_loss(B, p.loss.target() + 2 * B.col(15) + 2 * B.col(16));
    const Box box = make_box(17, 1, 3);
    const BoundedLsqSummary s = solve_bounded_lsq(loss, Eigen::VectorXd::Constant(17, 2), box);
    CHECK(s.status == LsqStatus::converged);
    CHECK(kkt_residual(loss, s.theta, box) < 10 * kkt);
    // the added columns do not extend the column space
    CHECK(s.residual_norm == Approx(p.loss(p.optimum)).epsilon(1e-10));
    CHECK(loss_gap(s.residual_norm, loss_lower_bound(loss, s.theta, box), loss.scale()) < tight_gap);
}

TEST_CASE("a problem with more springs than equations ends at a certified optimum in its box") {
    const tissue::Rng rng = tissue::seeded_rng(5);
    for (int trial = 0; trial < 20; ++trial) {
        const ForceLoss loss = plain_loss(random_matrix(25, 60, rng.get()), 40 * random_matrix(25, 1, rng.get()));
        const Box box = make_box(60, 0.05, 3);
        const BoundedLsqSummary s = solve_bounded_lsq(loss, Eigen::VectorXd::Ones(60), box);
        CHECK(s.status == LsqStatus::converged);
        CHECK(loss_gap(s.residual_norm, loss_lower_bound(loss, s.theta, box), loss.scale()) < tight_gap);
    }
}

TEST_CASE("the exact solver finds the optimum for columns of very different length") {
    Problem p = problem_with_active_bounds(60, 45, 6);
    Eigen::MatrixXd B = Eigen::MatrixXd(p.loss.matrix());
    Eigen::VectorXd unit(45);
    for (Eigen::Index s = 0; s < 45; ++s) unit[s] = std::pow(10, -4 + static_cast<double>(s % 9));
    B = B * unit.cwiseInverse().asDiagonal();
    const Box box{p.box.lo.cwiseProduct(unit), p.box.hi.cwiseProduct(unit)};
    const ForceLoss loss = plain_loss(B, p.loss.target());
    const BoundedLsqSummary s = solve_bounded_lsq(loss, p.start.cwiseProduct(unit), box);
    CHECK(s.status == LsqStatus::converged);
    CHECK((s.theta.cwiseQuotient(unit) - p.optimum).cwiseAbs().maxCoeff() < near_optimum);
}

TEST_CASE("the exact solver is deterministic and does not move from an optimum") {
    const Problem p = problem_with_active_bounds(60, 45, 7);
    const BoundedLsqSummary first = solve_bounded_lsq(p.loss, p.start, p.box);
    CHECK(first.theta == solve_bounded_lsq(p.loss, p.start, p.box).theta);
    const BoundedLsqSummary again = solve_bounded_lsq(p.loss, first.theta, p.box);
    CHECK(again.iterations == 0);
    CHECK((again.theta - first.theta).norm() < 1e-14);
}

TEST_CASE("an exact solve stopped by its iteration limit has status iterations_done") {
    const Problem p = problem_with_active_bounds(60, 45, 8);
    BoundedLsqOptions options;
    options.max_iterations = 1;
    const BoundedLsqSummary s = solve_bounded_lsq(p.loss, p.start, p.box, options);
    CHECK(s.status == LsqStatus::iterations_done);
    CHECK(s.iterations == 1);
    CHECK(s.kkt_residual > kkt);
    CHECK(s.residual_norm < p.loss(p.start));
}

TEST_CASE("an exact solve that finds no lower loss before its tolerance has status stalled") {
    const ForceLoss loss = plain_loss(Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Constant(1, 2));
    BoundedLsqOptions options;
    options.kkt_tolerance = -1;
    const BoundedLsqSummary s = solve_bounded_lsq(loss, Eigen::VectorXd::Ones(1), make_box(1, 0, 9), options);
    CHECK(s.status == LsqStatus::stalled);
    CHECK(s.theta[0] == Approx(2).epsilon(1e-15));
    CHECK(train_status(s.status) == TrainStatus::stalled);
    CHECK(train_status(LsqStatus::converged) == TrainStatus::converged);
    CHECK(train_status(LsqStatus::iterations_done) == TrainStatus::iterations_done);
}

TEST_CASE("the exact solver refuses inconsistent sizes and an empty box and a start outside it") {
    const Problem p = problem_with_active_bounds(12, 6, 9);
    CHECK_THROWS_AS(solve_bounded_lsq(p.loss, Eigen::VectorXd::Ones(5), p.box), MismatchError);
    CHECK_THROWS_AS(solve_bounded_lsq(p.loss, p.start, make_box(7, 1, 3)), MismatchError);
    CHECK_THROWS_AS(solve_bounded_lsq(p.loss, p.start, make_box(6, 3, 1)), MismatchError);
    CHECK_THROWS_AS(solve_bounded_lsq(p.loss, p.start, make_box(6, 2.5, 3)), MismatchError);
}
