#include "train/nonlinear_fit.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_rng.h>

#include "error.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// Rosenbrock's function: minimum 0 at (1, 1).
void valley(const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J) {
    f << 10 * (x[1] - x[0] * x[0]), 1 - x[0];
    J << -20 * x[0], 10, -1, 0;
}

}  // namespace

TEST_CASE("a fit finds the minimum of Rosenbrock's function") {
    const FitResult fit = nonlinear_fit(valley, 2, Eigen::Vector2d(-1.2, 1), {200, 0, 1e-12, 0});
    CHECK((fit.x - Eigen::Vector2d(1, 1)).norm() < 1e-6);
    CHECK(fit.half_square < 1e-12);
    CHECK(fit.iterations > 3);
    CHECK(fit.evaluations >= fit.iterations);
    CHECK((fit.status == FitStatus::small_gradient || fit.status == FitStatus::small_gain));
}

TEST_CASE("a fit with nonzero residuals ends where its gradient vanishes") {
    // a line through three points that are not on a line
    const FitFunction line = [](const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J) {
        f << x[0] - 1, x[0] + x[1] - 3, x[0] + 2 * x[1] - 2;
        J << 1, 0, 1, 1, 1, 2;
    };
    const FitResult fit = nonlinear_fit(line, 3, Eigen::Vector2d(0, 0), {50, 0, 1e-10, 0});
    CHECK(fit.x[0] == Approx(1.5).epsilon(1e-6));
    CHECK(fit.x[1] == Approx(0.5).epsilon(1e-6));
    CHECK(fit.half_square == Approx(0.75));
    CHECK(fit.gradient < 1e-8);
}

TEST_CASE("each fit status gives the criterion that ended the fit") {
    CHECK(nonlinear_fit(valley, 2, Eigen::Vector2d(-1.2, 1), {2, 0, 0, 0}).status == FitStatus::iterations_done);
    CHECK(nonlinear_fit(valley, 2, Eigen::Vector2d(-1.2, 1), {200, 100, 0, 0}).status == FitStatus::small_step);
    CHECK(nonlinear_fit(valley, 2, Eigen::Vector2d(-1.2, 1), {200, 0, 0, 1}).status == FitStatus::small_gain);
    CHECK(nonlinear_fit(valley, 2, Eigen::Vector2d(1, 1), {200, 0, 1e-9, 0}).status == FitStatus::small_gradient);
    // a derivative of the wrong sign: no step lowers the residual
    const FitFunction wrong = [](const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J) {
        f << x[0], 1;
        J << -1, 0;
    };
    CHECK(nonlinear_fit(wrong, 2, Eigen::VectorXd::Ones(1), {200, 0, 0, 0}).status == FitStatus::no_progress);
    CHECK(std::string(to_string(FitStatus::no_progress)) == "no_progress");
}

TEST_CASE("a fit rethrows exceptions of its function and refuses fewer residuals than parameters") {
    const FitFunction broken = [](const Eigen::VectorXd&, Eigen::Ref<Eigen::VectorXd>, Eigen::Ref<RowMatrix>) { throw MismatchError("broken"); };
    CHECK_THAT(refusal<MismatchError>([&] { nonlinear_fit(broken, 2, Eigen::Vector2d(0, 0)); }), Contains("broken"));
    CHECK_THAT(refusal<MismatchError>([] { nonlinear_fit(valley, 1, Eigen::Vector2d(0, 0)); }), Contains("2 parameters to 1 residuals"));
}

TEST_CASE("a fit rejects steps that lose a residual even where the objective falls") {
    std::vector<char> lost;
    // The first residual exists only up to x = 1. Beyond, its substitute is smaller than any of its values.
    const FitFunction cliff = [&](const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J) {
        lost.assign(2, 0);
        lost[0] = x[0] > 1;
        f << (lost[0] ? 0.1 : 10 - x[0]), 0.1 * x[0];
        J << (lost[0] ? 0.0 : -1.0), 0.1;
    };
    const FitOptions options{100, 1e-6, 0, 0};
    const Eigen::VectorXd start = Eigen::VectorXd::Zero(1);
    CHECK(nonlinear_fit(cliff, 2, start, options).x[0] > 1);  // without the rule the fit loses the residual
    const FitResult fit = nonlinear_fit(cliff, 2, start, options, &lost);
    CHECK(fit.x[0] <= 1);
    CHECK(fit.x[0] > 0.5);
    CHECK(fit.lost == 0);
    // it ends at the edge, not at a minimum
    CHECK((fit.status == FitStatus::held_back || fit.status == FitStatus::no_progress));
    const FitResult loose = nonlinear_fit(cliff, 2, start, {100, 1e-2, 0, 1e-3}, &lost);
    CHECK((loose.status == FitStatus::held_back || loose.status == FitStatus::no_progress));
    // a fit that starts without the residual may end without it
    CHECK(nonlinear_fit(cliff, 2, Eigen::VectorXd::Constant(1, 3), options, &lost).lost == 1);
}

TEST_CASE("a fit that rejects a step on its way to the minimum still converges") {
    std::vector<char> lost;
    // minimum at 0.7; the first step overshoots to beyond the edge at 1
    const FitFunction bent = [&](const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J) {
        lost.assign(1, x[0] > 1);
        f << std::tanh(3 * (x[0] - 0.7)), 0.5;
        J << 3 / std::pow(std::cosh(3 * (x[0] - 0.7)), 2), 0;
        if (lost[0]) f[0] = 0, J(0, 0) = 0;
    };
    const FitResult fit = nonlinear_fit(bent, 2, Eigen::VectorXd::Zero(1), {}, &lost);
    CHECK(fit.x[0] == Approx(0.7).epsilon(1e-2));
    CHECK((fit.status == FitStatus::small_gradient || fit.status == FitStatus::small_step || fit.status == FitStatus::small_gain));
}

TEST_CASE("an error of GSL is returned and does not end the program") {
    CHECK(std::isnan(gsl_cdf_chisq_Pinv(2, 2)));  // 2 is no probability
    gsl_rng* none = gsl_rng_alloc(gsl_rng_mt19937);
    CHECK(gsl_rng_uniform_int(none, 0) == 0);
    gsl_rng_free(none);
}
