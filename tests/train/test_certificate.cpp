#include <catch2/catch.hpp>
#include <limits>

#include "small_problem.h"
#include "train/bounded_lsq.h"
#include "train/certificate.h"

using namespace tissue;
using namespace tissue::test;

namespace {

constexpr double rounding = 1e-12;  // of numbers near one after some tens of operations
constexpr double sharp = 1e-7;      // the square root of a slack at rounding level, where the loss itself is zero
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("the gradient of half the squared loss equals its finite difference") {
    const Problem p = problem_with_active_bounds(12, 7, 1);
    const Eigen::VectorXd gradient = loss_gradient(p.loss, p.start);
    for (Eigen::Index s = 0; s < p.start.size(); ++s) {
        const double h = 0.5;  // any step: the central difference of a quadratic is exact
        Eigen::VectorXd plus = p.start, minus = p.start;
        plus[s] += h, minus[s] -= h;
        const double up = p.loss(plus), down = p.loss(minus);
        CHECK(gradient[s] == Approx((up * up - down * down) / (4 * h)).margin(rounding).epsilon(1e-10));
    }
}

TEST_CASE("for one spring the bound is the lowest point of the tangent in the box") {
    // L = |2 - theta| on [0, 1] at theta = 1/2: r = 9/8, slope -3/2, tangent at 1: 9/8 - 3/4 = 3/8
    const ForceLoss loss = plain_loss(Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Constant(1, 2));
    const Eigen::VectorXd half = Eigen::VectorXd::Constant(1, 0.5);
    CHECK(loss_lower_bound(loss, half, make_box(1, 0, 1)) == Approx(std::sqrt(0.75)).epsilon(rounding));
    // mirrored: |-1 - theta| with the lowest point at 0
    const ForceLoss mirrored = plain_loss(Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Constant(1, -1));
    CHECK(loss_lower_bound(mirrored, half, make_box(1, 0, 1)) == Approx(std::sqrt(0.75)).epsilon(rounding));
    // at the optimum on the bound, theta = 1 and L = 1, the lower bound is sharp
    CHECK(loss_lower_bound(loss, Eigen::VectorXd::Ones(1), make_box(1, 0, 1)) == Approx(1).epsilon(rounding));
}

TEST_CASE("the lower bound taken at random sets is not above the optimal loss") {
    const Problem p = problem_with_active_bounds(15, 9, 2);
    const tissue::Rng rng = tissue::seeded_rng(3);
    const double least = p.loss(p.optimum);
    for (int trial = 0; trial < 200; ++trial) {
        const Eigen::VectorXd theta =
            (2 * Eigen::VectorXd::Ones(9) + random_matrix(9, 1, rng.get())).cwiseMax(p.box.lo).cwiseMin(p.box.hi);
        CHECK(loss_lower_bound(p.loss, theta, p.box) <= least * (1 + rounding));
    }
}

TEST_CASE("the lower bound is sharp at an optimum with springs at both bounds of the box") {
    const Problem p = problem_with_active_bounds(40, 30, 4);
    const double least = p.loss(p.optimum), bound = loss_lower_bound(p.loss, p.optimum, p.box);
    CHECK(bound == Approx(least).epsilon(1e-10));
    CHECK(loss_gap(least, bound, p.loss.scale()) < 1e-9);
}

TEST_CASE("the lower bound is zero for an exact fit and the gap is then relative to the force") {
    const Problem p = lattice_problem("grid4", "isotropic", 4, 5);
    CHECK(loss_lower_bound(p.loss, p.optimum, p.box) <= sharp * p.loss.scale());
    CHECK(loss_gap(0.001 * p.loss.scale(), 0, p.loss.scale()) == Approx(0.02).epsilon(rounding));
}

TEST_CASE("springs without influence on the data do not change the lower bound") {
    const Problem p = problem_with_active_bounds(15, 9, 6);
    Eigen::MatrixXd wider = Eigen::MatrixXd::Zero(15, 11);
    wider.leftCols(9) = Eigen::MatrixXd(p.loss.matrix());
    Eigen::VectorXd theta = Eigen::VectorXd::Constant(11, 2);
    theta.head(9) = p.optimum;
    const ForceLoss loss = plain_loss(wider, p.loss.target());
    CHECK(loss_lower_bound(loss, theta, make_box(11, 1, 3)) ==
          Approx(loss_lower_bound(p.loss, p.optimum, p.box)).epsilon(rounding));
}

TEST_CASE("a box unbounded downhill has lower bound zero and a box unbounded uphill keeps its bound") {
    const ForceLoss loss = plain_loss(Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Constant(1, 2));
    const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);  // the optimum, theta = 2, lies above
    CHECK(loss_lower_bound(loss, one, make_box(1, 0, infinity)) == 0);
    CHECK(loss_lower_bound(loss, one, make_box(1, -infinity, 1)) == Approx(1).epsilon(rounding));
}

TEST_CASE("a stiffness outside the box is projected into it before the bound is computed") {
    const Problem p = problem_with_active_bounds(15, 9, 7);
    Eigen::VectorXd outside = p.optimum;
    for (Eigen::Index s = 0; s < 9; ++s) outside[s] += s % 3 == 0 ? -0.5 : s % 3 == 1 ? 0.5 : 0;
    CHECK(loss_lower_bound(p.loss, outside, p.box) == Approx(p.loss(p.optimum)).epsilon(1e-10));
}

TEST_CASE("the gap is the excess of the loss over its bound and is never negative") {
    CHECK(loss_gap(1.02, 1, 1) == Approx(0.02).epsilon(rounding));
    CHECK(loss_gap(1, 1 + 1e-15, 1) == 0);
    CHECK(loss_gap(0, 0, 0) == 0);
}
