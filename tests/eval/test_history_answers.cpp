#include "eval/history_answers.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../haptic/haptic_example.h"
#include "../refusal.h"
#include "error.h"
#include "springs/indentation_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

double smooth(double s) { return s <= 0 ? 0 : s >= 1 ? 1 : s * s * s * (10 - 15 * s + 6 * s * s); }

/// A ramp of duration rise_s and a hold, in steps of 5 ms.
History ramp(double depth_m, double rise_s, double duration_s) {
    History h;
    h.name = "ramp-0001";
    h.group = h.kind = "ramp";
    h.role = "held_out";
    h.contact_m = Eigen::Vector2d(0.047, 0.1);
    h.direction = Eigen::Vector2d(0, -1);
    const auto T = static_cast<Eigen::Index>(std::lround(duration_s / 0.005)) + 1;
    h.time_s = Eigen::VectorXd::LinSpaced(T, 0, duration_s);
    h.push_m.resize(T, 2);
    for (Eigen::Index n = 0; n < T; ++n) h.push_m.row(n) << 0, -depth_m * smooth(h.time_s[n] / rise_s);
    h.contact.assign(static_cast<std::size_t>(T), 1);
    h.force_N = NodeField::Zero(T, 2);
    return h;
}

HapticOptions alone() {
    HapticOptions o;
    o.heuristic_mesh = false;
    return o;
}

}  // namespace

TEST_CASE("rms error of a force history weights time and peak error is over the largest force", "[histories]") {
    Eigen::VectorXd t(5);
    t << 0, 1, 1.5, 2, 4;
    NodeField truth(5, 2), answer(5, 2);
    truth << 3, 4, 3, 4, 3, 4, 3, 4, 3, 4;
    answer = truth;
    answer.row(4) << 3, 6;
    const HistoryError e = history_error(t, truth, answer);
    CHECK(e.rms == Approx(std::sqrt(4.0 * 1 / (25.0 * 4))));
    CHECK(e.peak == Approx(2.0 / 5));
}

TEST_CASE("a force history that is not finite to its end counts as missing with infinite error", "[histories]") {
    const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(3, 0, 1);
    const NodeField truth = NodeField::Ones(3, 2);
    NodeField answer = truth;
    answer(2, 1) = std::numeric_limits<double>::quiet_NaN();
    const HistoryError e = history_error(t, truth, answer);
    CHECK(std::isinf(e.rms));
    CHECK(std::isinf(e.peak));
    for (const NodeField& said : {truth, answer}) {  // no error is relative to a zero force, whatever the answer
        CHECK(std::isnan(history_error(t, NodeField::Zero(3, 2), said).rms));
        CHECK(std::isnan(history_error(t, NodeField::Zero(3, 2), said).peak));
    }
    HistoryTable table;
    table.models = {"learned"};
    for (const HistoryError& error : {HistoryError{0.1, 0.2}, HistoryError{0.2, 0.3}, e}) table.answers.push_back({"h", "ramp", "ramp", {}, {}, {}, {}, {0, 0}, {error}});
    const Statistics s = table.rms(0, "ramp");
    CHECK(s.median == 0.2);
    CHECK(std::isinf(s.p95));
    CHECK(s.n == 2);
    CHECK(s.missing == 1);
}

TEST_CASE("a force relaxed by Maxwell branches equals the closed form for unequal time steps", "[histories]") {
    Eigen::VectorXd t(6);
    t << 0, 0.1, 0.15, 0.5, 3, 10;
    NodeField force(6, 1);
    for (Eigen::Index n = 0; n < 6; ++n) force(n, 0) = 2 * std::min(1.0, t[n] / 0.5);
    const Eigen::Vector2d tau(0.3, 7), g(0.5, 0.2);
    const NodeField out = relaxed(t, force, tau, g);
    for (Eigen::Index n = 3; n < 6; ++n) {
        double expected = 2 * 0.3;
        for (int k = 0; k < 2; ++k) expected += 2 * g[k] * tau[k] / 0.5 * (1 - std::exp(-0.5 / tau[k])) * std::exp(-(t[n] - 0.5) / tau[k]);
        CHECK(out(n, 0) == Approx(expected).epsilon(1e-12));
    }
}

TEST_CASE("the dynamic force of a relaxing model is its static force relaxed by its Maxwell branches", "[histories][long]") {
    const TissueModel model = relaxing(energy_model_example());
    const HapticModel haptic(model, alone());
    const History h = ramp(0.008, 2, 6);
    const NodeField answer = play_history(haptic, h);
    const IndentationSolver solver(model);  // of the instantaneous model
    NodeField statics(h.time_s.size(), 2);
    for (Eigen::Index n = 0; n < statics.rows(); ++n)
        if (n > 0 && h.push_m.row(n) == h.push_m.row(n - 1))  // held
            statics.row(n) = statics.row(n - 1);
        else
            statics.row(n) = solver.at(h.contact_m, h.push_m.row(n).transpose()).contact_force.transpose();
    const NodeField expected = relaxed(h.time_s, statics, model.energy_model->relaxation.tau_s, model.energy_model->relaxation.contact_share);
    // cells keep their area while springs relax, so that the shape changes slightly
    CHECK(history_error(h.time_s, expected, answer).rms < 0.01);
    CHECK(history_error(h.time_s, statics, answer).rms > 0.3);
}

TEST_CASE("force is zero while the tool is away and a second indentation at the contact is softer", "[histories]") {
    const TissueModel model = relaxing(energy_model_example());
    const HapticModel haptic(model, alone());
    History h = ramp(0.008, 0.3, 2);
    for (std::size_t n = 150; n < 250; ++n) h.contact[n] = 0;
    h.second_contact_m = h.contact_m;
    for (std::size_t n = 250; n < h.contact.size(); ++n) {
        h.contact[n] = 2;
        h.push_m.row(static_cast<Eigen::Index>(n)) << 0, -0.008 * smooth((h.time_s[static_cast<Eigen::Index>(n)] - 1.25) / 0.3);
    }
    const NodeField answer = play_history(haptic, h);
    CHECK(answer(140, 1) < -0.5);
    for (Eigen::Index n = 152; n < 249; ++n) REQUIRE(answer.row(n).norm() == 0);
    History fresh = ramp(0.008, 0.3, 0.75);
    fresh.contact_m = *h.second_contact_m;
    const NodeField first = play_history(haptic, fresh), second = answer.bottomRows(151);
    CHECK(second(150, 1) < -0.5);
    const double less = std::abs(second(150, 1) / first(150, 1));
    CHECK(less < 0.97);  // the tissue has not recovered
    CHECK(less > 0.6);
    History beside = h;
    beside.second_contact_m = Eigen::Vector2d(0.067, 0.1);
    CHECK(std::abs(play_history(haptic, beside)(400, 1) / answer(400, 1)) > 1.01);  // it is less soft 20 mm away
}

TEST_CASE("baselines of a relaxing model have the expected errors and recover references of their own kind", "[histories][long]") {
    const TissueModel model = relaxing(energy_model_example(make_lattice("grid8", 6, 6, 0.1, 0.1)));
    HapticOptions still = alone();
    const HapticModel haptic(model, still);
    still.damping_ratio = haptic.options.damping_ratio;
    TissueModel elastic = model;
    elastic.energy_model = instantaneous(*model.energy_model);
    const HapticModel at_once(elastic, still);
    std::vector<History> histories;
    for (double depth : {0.004, 0.008}) {
        histories.push_back(ramp(depth, depth * 100, 4));
        histories.back().name = "ramp-000" + std::to_string(histories.size());
        histories.back().force_N = play_history(haptic, histories.back());
        histories.back().elastic_N = play_history(at_once, histories.back());
    }
    histories.push_back(histories.front());
    histories.back().name = "gone";
    histories.back().lost = "no equilibrium";
    histories.push_back(histories.back());
    histories.back().name = "gone-too";
    histories.back().group = "sine";
    histories.push_back(histories.front());
    histories.back().role = "train";
    const HistoryTable table = evaluate_histories(model, histories, "held_out", 2);
    REQUIRE(table.answers.size() == 2);
    CHECK(table.lost == std::vector<std::string>{"gone: no equilibrium", "gone-too: no equilibrium"});
    // a group without any finished history is listed too
    CHECK(table.groups() == std::vector<std::string>{"ramp", "sine"});
    CHECK(n_of_N(table.rms(0, "ramp")) == "2 of 3");
    CHECK(n_of_N(table.rms(0, "sine")) == "0 of 1");
    CHECK(n_of_N(table.peak(0, "")) == "2 of 4");
    CHECK(table.elastic_rms("").no_reference == 2);
    const auto rms = [&](const std::string& name) {
        const auto m = static_cast<std::size_t>(std::find(table.models.begin(), table.models.end(), name) - table.models.begin());
        REQUIRE(m < table.models.size());
        return table.rms(m, "").max;
    };
    CHECK(rms("learned") == 0);
    CHECK(table.elastic_rms("").max == 0);
    CHECK(rms("prony") < 0.02);
    CHECK(rms("instantaneous") > 0.5);
    CHECK(rms("long_term") > 0.3);
    CHECK(rms("best_factor") < rms("instantaneous"));
    CHECK(rms("kelvin_voigt") < 1.05 * rms("best_factor"));
    CHECK(rms("one_branch") < 0.5 * rms("best_factor"));
    CHECK(table.factor > 0.25);
    CHECK(table.factor < 1);

    // without an elastic solve no slow histories are selected, and the factor is fitted to all
    std::vector<History> plain(histories.begin(), histories.begin() + 2);
    plain[1].force_N *= 0.5;
    for (History& h : plain) h.elastic_N.resize(0, h.elastic_N.cols());
    const HistoryTable both = evaluate_histories(model, plain, "held_out", 1);
    const double of_both = both.factor;
    CHECK(both.fitted_to_all);
    CHECK_FALSE(evaluate_histories(model, histories, "held_out", 1).fitted_to_all);
    for (History& h : plain) CHECK(std::abs(evaluate_histories(model, {h}, "held_out", 1).factor / of_both - 1) > 0.1);

    // a reference of one branch is recovered
    for (History& h : histories) h.force_N = relaxed(h.time_s, h.elastic_N, Eigen::VectorXd::Constant(1, 0.5), Eigen::VectorXd::Constant(1, 0.6));
    const HistoryTable one = evaluate_histories(model, histories, "held_out", 1);
    CHECK(one.branch[0] == Approx(0.6).epsilon(0.02));
    CHECK(one.branch[1] == Approx(0.5).epsilon(0.06));

    // so is a reference of springs beside a damper, at every step including the first and the last
    for (History& h : histories) {
        const Eigen::Index last = h.time_s.size() - 1;
        for (Eigen::Index n = 0; n <= last; ++n) {
            const Eigen::Index from = n > 0 ? n - 1 : n, to = n < last ? n + 1 : n;
            h.force_N.row(n) = 0.7 * h.elastic_N.row(n) + 0.05 * (h.elastic_N.row(to) - h.elastic_N.row(from)) / (h.time_s[to] - h.time_s[from]);
        }
    }
    const HistoryTable damped = evaluate_histories(model, histories, "held_out", 1);
    CHECK(damped.kelvin_voigt[0] == Approx(0.7).epsilon(1e-9));
    CHECK(damped.kelvin_voigt[1] == Approx(0.05).epsilon(1e-9));
    CHECK(damped.rms(static_cast<std::size_t>(std::find(damped.models.begin(), damped.models.end(), "kelvin_voigt") - damped.models.begin()), "").max < 1e-9);
    CHECK(evaluate_histories(model, histories, "validation", 1).empty());
    TissueModel sets = haptic_example();
    CHECK_THAT(refusal<MismatchError>([&] { evaluate_histories(sets, histories, "held_out", 1); }), Contains("energy model"));
}

TEST_CASE("test histories within 2 mm of a training contact of the energy model are counted", "[histories]") {
    Cases cases;
    for (const auto& [x, role] : {std::pair(0.040, "train"), std::pair(0.046, "validation"), std::pair(0.060, "train")}) {
        cases.paths.emplace_back();
        cases.paths.back().contact_m = Eigen::Vector2d(x, 0.1);
        cases.paths.back().role = role;
    }
    for (const double x : {0.0385, 0.0425, 0.047, 0.061}) {
        cases.histories.push_back(ramp(0.004, 0.4, 1));
        cases.histories.back().contact_m = Eigen::Vector2d(x, 0.1);
    }
    CHECK(near_training(cases, "held_out") == 2);
    cases.histories[0].lost = "no equilibrium";  // gives no error
    cases.histories[3].role = "train";
    CHECK(near_training(cases, "held_out") == 0);
    CHECK(near_training(cases, "train") == 1);
}

TEST_CASE("force is full in the last step in contact and zero at both ends of an absence", "[histories]") {
    const TissueModel model = relaxing(energy_model_example());
    const HapticModel haptic(model, alone());
    History h = ramp(0.008, 0.3, 1.2);
    for (Eigen::Index n = 0; n < h.time_s.size(); ++n) h.time_s[n] += 0.0004 * (n > 0);  // between ticks
    for (std::size_t n = 150; n < 200; ++n) h.contact[n] = 0;
    const NodeField answer = play_history(haptic, h);
    CHECK(answer.row(149).norm() == Approx(answer.row(148).norm()).epsilon(0.02));  // the last step in contact
    CHECK(answer.row(150).norm() == 0);
    CHECK(answer.row(199).norm() == 0);
    CHECK(answer.row(200).norm() > 0.1);
}
