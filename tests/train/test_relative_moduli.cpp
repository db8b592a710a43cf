#include "train/relative_moduli.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "../haptic/haptic_example.h"
#include "../refusal.h"
#include "error.h"
#include "springs/indentation_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// A ramp with a hold, and the force of the model without relaxation.
struct Ramp {
    History course;
    NodeField now;  ///< [N] (121 x 2)
};

Ramp ramp(const TissueModel& model, double rise_s) {
    Ramp r;
    History& h = r.course;
    h.name = "ramp";
    h.role = "train";
    h.contact_m = Eigen::Vector2d(0.047, 0.1);
    h.direction = Eigen::Vector2d(0, -1);
    h.time_s = Eigen::VectorXd::LinSpaced(121, 0, 12);
    h.push_m = NodeField::Zero(121, 2);
    h.contact.assign(121, 1);
    r.now = NodeField::Zero(121, 2);
    const IndentationSolver solver(model);
    for (Eigen::Index n = 1; n < 121; ++n) {
        h.push_m(n, 1) = -0.008 * std::min(1.0, h.time_s[n] / rise_s);
        if (h.push_m.row(n) == h.push_m.row(n - 1))
            r.now.row(n) = r.now.row(n - 1);
        else
            r.now.row(n) = solver.at(h.contact_m, h.push_m.row(n).transpose()).contact_force.transpose();
    }
    return r;
}

/// The ramp with the force of tissue with these Maxwell branches, with relative noise.
History measured(const Ramp& ramp, const Eigen::VectorXd& tau_s, const Eigen::VectorXd& share, double noise, unsigned long seed) {
    History h = ramp.course;
    h.force_N = relaxed(h.time_s, ramp.now, tau_s, share);
    Draw draw(seed);
    for (Eigen::Index i = 0; i < h.force_N.size(); ++i) h.force_N.data()[i] *= 1 + noise * draw(-1.7, 1.7);
    return h;
}

}  // namespace

TEST_CASE("relative moduli are recovered from two ramps to rounding and with 2 % noise to 0.05", "[shares]") {
    const TissueModel model = energy_model_example();
    const Eigen::VectorXd tau = Eigen::Vector3d(0.3, 1.5, 8);
    const Eigen::VectorXd share = Eigen::Vector3d(0.35, 0, 0.25);
    const Ramp quick = ramp(model, 0.5), slow = ramp(model, 5);
    std::vector<History> histories = {measured(quick, tau, share, 0, 1), measured(slow, tau, share, 0, 2)};
    const FittedModuli exact = fit_relative_moduli(model, histories, "train", tau, 2);
    CHECK((exact.share - share).norm() < 1e-9);
    CHECK(exact.misfit < 1e-9);
    CHECK(exact.status == "converged");
    CHECK(exact.kkt_residual < 1e-9);

    histories = {measured(quick, tau, share, 0.02, 3), measured(slow, tau, share, 0.02, 4)};
    const FittedModuli noisy = fit_relative_moduli(model, histories, "train", tau, 1);
    CHECK((noisy.share - share).norm() < 0.05);
    CHECK(noisy.share.minCoeff() >= 0);
    CHECK(noisy.misfit > 0.01);
    CHECK(noisy.misfit < 0.03);
    CHECK(noisy.kkt_residual < 1e-9);
}

TEST_CASE("equal displacements at two contacts are distinguished in the fit of relative moduli", "[shares]") {
    const TissueModel model = energy_model_example();
    const Eigen::VectorXd tau = Eigen::VectorXd::Constant(1, 1.5), share = Eigen::VectorXd::Constant(1, 0.35);
    const IndentationSolver solver(model);
    Ramp r;
    History& h = r.course;
    h.name = "there and back";
    h.role = "train";
    h.contact_m = Eigen::Vector2d(0.047, 0.1);
    h.second_contact_m = Eigen::Vector2d(0.1, 0.062);
    h.direction = Eigen::Vector2d(0, -1);
    h.time_s = Eigen::VectorXd::LinSpaced(10, 0, 4.5);
    h.push_m = Eigen::RowVector2d(-0.004, -0.006).replicate(10, 1);
    h.push_m.row(8) *= 0.5;  // the same three times at each contact, then half of it, then the same again
    h.contact = {1, 1, 1, 2, 2, 2, 0, 1, 1, 1};
    r.now = NodeField::Zero(10, 2);
    for (Eigen::Index n = 0; n < 10; ++n)
        if (const int where = h.contact[static_cast<std::size_t>(n)]; where != 0)
            r.now.row(n) = solver.at(where == 2 ? *h.second_contact_m : h.contact_m, h.push_m.row(n).transpose()).contact_force.transpose();
    const FittedModuli fitted = fit_relative_moduli(model, {measured(r, tau, share, 0, 1)}, "train", tau, 1);
    CHECK((fitted.share - share).norm() < 1e-8);
    CHECK(fitted.misfit < 1e-8);
}

TEST_CASE("relative moduli of tissue without long-term stiffness are bounded to a sum of 0.98", "[shares]") {
    const TissueModel model = energy_model_example();
    // no long-term stiffness
    const Eigen::VectorXd tau = Eigen::Vector3d(0.3, 1.5, 8), share = Eigen::Vector3d(0.5, 0.2, 0.3);
    const FittedModuli fitted = fit_relative_moduli(model, {measured(ramp(model, 0.5), tau, share, 0, 1), measured(ramp(model, 5), tau, share, 0, 2)}, "train", tau, 2);
    CHECK(fitted.status == "bounded");
    CHECK(fitted.share.sum() == Approx(0.98).epsilon(1e-12));
    CHECK((fitted.share - 0.98 * share).norm() < 1e-8);
    CHECK(fitted.misfit > 1e-3);           // of the bounded moduli
    CHECK(fitted.kkt_residual < 1e-9);     // of the optimum before the bound
}

TEST_CASE("a fit to a long-term model gives its relative moduli and its factor to the instantaneous model", "[shares]") {
    const TissueModel at_once = energy_model_example();
    const Eigen::VectorXd tau = Eigen::Vector3d(0.3, 1.5, 8), share = Eigen::Vector3d(0.35, 0, 0.25);
    const std::vector<History> histories = {measured(ramp(at_once, 0.5), tau, share, 0, 1), measured(ramp(at_once, 5), tau, share, 0, 2)};
    TissueModel left = at_once;
    left.energy_model->constants *= 0.4;
    left.energy_model->patch.log_N_m.col(0).array() += std::log(0.4);
    const FittedModuli fitted = fit_relative_moduli(left, histories, "train", tau, 2, true);
    CHECK((fitted.share - share).norm() < 1e-8);
    CHECK(fitted.grown == Approx(2.5).epsilon(1e-8));
    CHECK(fitted.misfit < 1e-8);
    CHECK(fitted.kkt_residual < 1e-9);
}

TEST_CASE("unknown relaxation times span twice the time step to the longest history with at most eight", "[shares]") {
    History h;
    h.role = "train";
    h.time_s = Eigen::VectorXd::LinSpaced(1001, 0, 10);  // 10 ms
    const Eigen::VectorXd tau = time_ladder({h}, "train");
    CHECK(tau.size() == 6);
    CHECK(tau[5] == Approx(10));
    CHECK(tau[0] >= 0.02);
    for (int k = 1; k < 6; ++k) CHECK(tau[k] / tau[k - 1] == Approx(std::sqrt(10.0)));
    h.time_s = Eigen::VectorXd::LinSpaced(100001, 0, 100);
    CHECK(time_ladder({h}, "train").size() == 8);
    CHECK(time_ladder({h}, "train")[0] == Approx(0.002));
    CHECK_THAT(refusal<MismatchError>([&] { time_ladder({h}, "held_out"); }), Contains("no displacement history"));
}

TEST_CASE("relative moduli from two ramps with 2 % noise predict another trajectory within 3 %", "[shares][long]") {
    const TissueModel model = energy_model_example();
    const Eigen::VectorXd tau = Eigen::Vector3d(0.2, 1, 10), share = Eigen::Vector3d(0.3, 0.25, 0.2);
    // another trajectory: ramp, hold, partial release, hold
    const Ramp quick = ramp(model, 0.3), slow = ramp(model, 5);
    const History other = quick.course;
    NodeField now = NodeField::Zero(121, 2);
    for (Eigen::Index n = 1; n < 121; ++n) {
        const double t = other.time_s[n];
        now(n, 1) = -(t < 0.4 ? t / 0.4 : t < 4 ? 1 : t < 5 ? 1 - 0.6 * (t - 4) : 0.4);
    }
    const NodeField truth = relaxed(other.time_s, now, tau, share);
    const auto worst = [&](const Eigen::VectorXd& times) {
        double most = 0;
        for (unsigned long seed = 1; seed <= 4; ++seed) {
            const std::vector<History> histories = {measured(quick, tau, share, 0.02, seed), measured(slow, tau, share, 0.02, 50 + seed)};
            const FittedModuli fitted = fit_relative_moduli(model, histories, "train", times, 2);
            CHECK(fitted.kkt_residual < 1e-9);
            most = std::max(most, (relaxed(other.time_s, now, times, fitted.share) - truth).norm() / truth.norm());
        }
        return most;
    };
    CHECK(worst(tau) < 0.01);
    Eigen::VectorXd half_decades(6);
    half_decades << 0.1, 0.316, 1, 3.16, 10, 31.6;
    CHECK(worst(half_decades) < 0.015);
    CHECK(worst(Eigen::Vector3d(0.1, 1, 10)) < 0.03);
}

TEST_CASE("a fit of relative moduli without histories or energy model is refused", "[shares]") {
    const TissueModel model = energy_model_example();
    const Eigen::VectorXd tau = Eigen::Vector2d(0.3, 3);
    CHECK_THAT(refusal<MismatchError>([&] { fit_relative_moduli(model, {}, "train", tau, 1); }), Contains("no displacement history"));
    const std::vector<History> histories = {measured(ramp(model, 0.5), tau, Eigen::Vector2d(0.2, 0.2), 0, 1)};
    CHECK_THAT(refusal<MismatchError>([&] { fit_relative_moduli(model, histories, "held_out", tau, 1); }), Contains("no displacement history"));
    CHECK_THAT(refusal<MismatchError>([&] { fit_relative_moduli(haptic_example(), histories, "train", tau, 1); }), Contains("energy model"));
}
