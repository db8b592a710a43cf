#include "train/fit_shares.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "../haptic/haptic_example.h"
#include "../refusal.h"
#include "error.h"
#include "springs/law_press.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// A slow ramp that is held, and what the law says of it at once: of tissue that does not relax.
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
    const LawPress press(model);
    for (Eigen::Index n = 1; n < 121; ++n) {
        h.push_m(n, 1) = -0.008 * std::min(1.0, h.time_s[n] / rise_s);
        if (h.push_m.row(n) == h.push_m.row(n - 1))
            r.now.row(n) = r.now.row(n - 1);
        else
            r.now.row(n) = press.at(h.contact_m, h.push_m.row(n).transpose()).contact_force.transpose();
    }
    return r;
}

/// The ramp as tissue with these branches answers it, with relative noise.
History measured(const Ramp& ramp, const Eigen::VectorXd& tau_s, const Eigen::VectorXd& share, double noise, unsigned long seed) {
    History h = ramp.course;
    h.force_N = relaxed(h.time_s, ramp.now, tau_s, share);
    Draw draw(seed);
    for (Eigen::Index i = 0; i < h.force_N.size(); ++i) h.force_N.data()[i] *= 1 + noise * draw(-1.7, 1.7);
    return h;
}

}  // namespace

TEST_CASE("shares of branches are found from two ramps, to rounding without noise, and are none where there is none", "[shares]") {
    const TissueModel model = law_example();
    const Eigen::VectorXd tau = Eigen::Vector3d(0.3, 1.5, 8);
    const Eigen::VectorXd share = Eigen::Vector3d(0.35, 0, 0.25);
    const Ramp quick = ramp(model, 0.5), slow = ramp(model, 5);
    std::vector<History> histories = {measured(quick, tau, share, 0, 1), measured(slow, tau, share, 0, 2)};
    const FittedShares exact = fit_shares(model, histories, "train", tau, 2);
    CHECK((exact.share - share).norm() < 1e-9);
    CHECK(exact.misfit < 1e-9);
    CHECK(exact.status == "converged");
    CHECK(exact.kkt_residual < 1e-9);

    histories = {measured(quick, tau, share, 0.02, 3), measured(slow, tau, share, 0.02, 4)};
    const FittedShares noisy = fit_shares(model, histories, "train", tau, 1);
    CHECK((noisy.share - share).norm() < 0.05);
    CHECK(noisy.share.minCoeff() >= 0);
    CHECK(noisy.misfit > 0.01);
    CHECK(noisy.misfit < 0.03);
    CHECK(noisy.kkt_residual < 1e-9);
}

TEST_CASE("a push that is held is the same push at one place alone", "[shares]") {
    const TissueModel model = law_example();
    const Eigen::VectorXd tau = Eigen::VectorXd::Constant(1, 1.5), share = Eigen::VectorXd::Constant(1, 0.35);
    const LawPress press(model);
    Ramp r;
    History& h = r.course;
    h.name = "there and back";
    h.role = "train";
    h.contact_m = Eigen::Vector2d(0.047, 0.1);
    h.second_contact_m = Eigen::Vector2d(0.1, 0.062);
    h.direction = Eigen::Vector2d(0, -1);
    h.time_s = Eigen::VectorXd::LinSpaced(10, 0, 4.5);
    h.push_m = Eigen::RowVector2d(-0.004, -0.006).replicate(10, 1);
    h.push_m.row(8) *= 0.5;  // held three times at each place, then less, then held as before
    h.contact = {1, 1, 1, 2, 2, 2, 0, 1, 1, 1};
    r.now = NodeField::Zero(10, 2);
    for (Eigen::Index n = 0; n < 10; ++n)
        if (const int where = h.contact[static_cast<std::size_t>(n)]; where != 0)
            r.now.row(n) = press.at(where == 2 ? *h.second_contact_m : h.contact_m, h.push_m.row(n).transpose()).contact_force.transpose();
    const FittedShares fitted = fit_shares(model, {measured(r, tau, share, 0, 1)}, "train", tau, 1);
    CHECK((fitted.share - share).norm() < 1e-8);
    CHECK(fitted.misfit < 1e-8);
}

TEST_CASE("of a tissue that flows shares keep something of the law for ever, and their status says that they are bounded", "[shares]") {
    const TissueModel model = law_example();
    const Eigen::VectorXd tau = Eigen::Vector3d(0.3, 1.5, 8), share = Eigen::Vector3d(0.5, 0.2, 0.3);  // nothing is left
    const FittedShares fitted = fit_shares(model, {measured(ramp(model, 0.5), tau, share, 0, 1), measured(ramp(model, 5), tau, share, 0, 2)}, "train", tau, 2);
    CHECK(fitted.status == "bounded");
    CHECK(fitted.share.sum() == Approx(0.98).epsilon(1e-12));
    CHECK((fitted.share - 0.98 * share).norm() < 1e-8);
    CHECK(fitted.misfit > 1e-3);           // of the shares as they are
    CHECK(fitted.kkt_residual < 1e-9);     // of the optimum before
}

TEST_CASE("of a law that is what is left after all time, shares are those of the law at once, and it grows to that", "[shares]") {
    const TissueModel at_once = law_example();
    const Eigen::VectorXd tau = Eigen::Vector3d(0.3, 1.5, 8), share = Eigen::Vector3d(0.35, 0, 0.25);
    const std::vector<History> histories = {measured(ramp(at_once, 0.5), tau, share, 0, 1), measured(ramp(at_once, 5), tau, share, 0, 2)};
    TissueModel left = at_once;
    left.energy_law->constants *= 0.4;
    left.energy_law->patch.log_N_m.col(0).array() += std::log(0.4);
    const FittedShares fitted = fit_shares(left, histories, "train", tau, 2, true);
    CHECK((fitted.share - share).norm() < 1e-8);
    CHECK(fitted.grown == Approx(2.5).epsilon(1e-8));
    CHECK(fitted.misfit < 1e-8);
    CHECK(fitted.kkt_residual < 1e-9);
}

TEST_CASE("times of branches that nobody knows are half decades from the readings' step to the longest history", "[shares]") {
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
    CHECK_THAT(refusal<MismatchError>([&] { time_ladder({h}, "held_out"); }), Contains("no history"));
}

TEST_CASE("2 % of noise on two ramps leaves shares that are right to a per cent on another course, also where the times are not known", "[shares][long]") {
    const TissueModel model = law_example();
    const Eigen::VectorXd tau = Eigen::Vector3d(0.2, 1, 10), share = Eigen::Vector3d(0.3, 0.25, 0.2);
    // another course: in, held, half out, held
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
            const FittedShares fitted = fit_shares(model, histories, "train", times, 2);
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

TEST_CASE("without histories, or a law, there is nothing to fit shares to", "[shares]") {
    const TissueModel model = law_example();
    const Eigen::VectorXd tau = Eigen::Vector2d(0.3, 3);
    CHECK_THAT(refusal<MismatchError>([&] { fit_shares(model, {}, "train", tau, 1); }), Contains("no history"));
    const std::vector<History> histories = {measured(ramp(model, 0.5), tau, Eigen::Vector2d(0.2, 0.2), 0, 1)};
    CHECK_THAT(refusal<MismatchError>([&] { fit_shares(model, histories, "held_out", tau, 1); }), Contains("no history"));
    CHECK_THAT(refusal<MismatchError>([&] { fit_shares(haptic_example(), histories, "train", tau, 1); }), Contains("law"));
}
