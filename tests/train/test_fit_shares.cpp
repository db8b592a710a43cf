#include "train/fit_shares.h"

#include <catch2/catch.hpp>

#include "../haptic/haptic_example.h"
#include "../refusal.h"
#include "error.h"
#include "springs/law_press.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// A slow ramp that is held, as the law says it through these branches, with relative noise.
History measured(const TissueModel& model, double rise_s, const Eigen::VectorXd& tau_s, const Eigen::VectorXd& share, double noise, unsigned long seed) {
    History h;
    h.name = "ramp";
    h.role = "train";
    h.contact_m = Eigen::Vector2d(0.047, 0.1);
    h.direction = Eigen::Vector2d(0, -1);
    h.time_s = Eigen::VectorXd::LinSpaced(121, 0, 12);
    h.push_m = NodeField::Zero(121, 2);
    h.contact.assign(121, 1);
    NodeField now = NodeField::Zero(121, 2);
    const LawPress press(model);
    for (Eigen::Index n = 1; n < 121; ++n) {
        h.push_m(n, 1) = -0.008 * std::min(1.0, h.time_s[n] / rise_s);
        now.row(n) = press.at(h.contact_m, h.push_m.row(n).transpose()).contact_force.transpose();
    }
    h.force_N = relaxed(h.time_s, now, tau_s, share);
    Draw draw(seed);
    for (Eigen::Index i = 0; i < h.force_N.size(); ++i) h.force_N.data()[i] *= 1 + noise * draw(-1.7, 1.7);
    return h;
}

}  // namespace

TEST_CASE("shares of branches are found from two ramps, to rounding without noise, and are none where there is none", "[shares]") {
    const TissueModel model = law_example();
    const Eigen::VectorXd tau = Eigen::Vector3d(0.3, 1.5, 8);
    const Eigen::VectorXd share = Eigen::Vector3d(0.35, 0, 0.25);
    std::vector<History> histories = {measured(model, 0.5, tau, share, 0, 1), measured(model, 5, tau, share, 0, 2)};
    const FittedShares exact = fit_shares(model, histories, "train", tau, 2);
    CHECK((exact.share - share).norm() < 1e-9);
    CHECK(exact.misfit < 1e-9);
    CHECK(exact.status == "converged");
    CHECK(exact.kkt_residual < 1e-9);

    histories = {measured(model, 0.5, tau, share, 0.02, 3), measured(model, 5, tau, share, 0.02, 4)};
    const FittedShares noisy = fit_shares(model, histories, "train", tau, 1);
    CHECK((noisy.share - share).norm() < 0.05);
    CHECK(noisy.share.minCoeff() >= 0);
    CHECK(noisy.misfit > 0.01);
    CHECK(noisy.misfit < 0.03);
    CHECK(noisy.kkt_residual < 1e-9);
}

TEST_CASE("without histories, or a law, there is nothing to fit shares to", "[shares]") {
    const TissueModel model = law_example();
    const Eigen::VectorXd tau = Eigen::Vector2d(0.3, 3);
    CHECK_THAT(refusal<MismatchError>([&] { fit_shares(model, {}, "train", tau, 1); }), Contains("no history"));
    const std::vector<History> histories = {measured(model, 0.5, tau, Eigen::Vector2d(0.2, 0.2), 0, 1)};
    CHECK_THAT(refusal<MismatchError>([&] { fit_shares(model, histories, "held_out", tau, 1); }), Contains("no history"));
    CHECK_THAT(refusal<MismatchError>([&] { fit_shares(haptic_example(), histories, "train", tau, 1); }), Contains("law"));
}
