#include "adapt/adaptation.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "adapt_example.h"
#include "error.h"
#include "../haptic/haptic_example.h"
#include "springs/indentation_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

AdaptOptions options(const std::string& unknowns = "field") {
    AdaptOptions o;
    o.unknowns = unknowns;
    return o;
}

/// An energy model whose left part (x < 45 mm) is four times as stiff.
TissueModel half_stiff() {
    const TissueModel model = energy_model_example();
    const Unknowns field = make_unknowns(model, "field");
    Eigen::VectorXd x = Eigen::VectorXd::Zero(model.mesh.node_count());
    for (int n = 0; n < model.mesh.node_count(); ++n)
        if (model.mesh.nodes(n, 0) < 0.045) x[n] = std::log(4.0);
    TissueModel target = model;
    target.energy_model = with_unknowns(*model.energy_model, field, x);
    return target;
}

}  // namespace

TEST_CASE("one measurement corrects the force at its contact and a uniform scale corrects it everywhere", "[adapt]") {
    const TissueModel model = energy_model_example(), target = stiffer(model, std::log(1.5));
    const std::vector<ForceMeasurement> pokes = pokes_of(target, 12);
    for (const std::string kind : {"scale", "terms", "field", "elements"}) {
        Adaptation adaptation(model, options(kind));
        CHECK(worst_error(adaptation.model(), pokes) > 0.3);
        const UpdateResult answer = adaptation.learn(pokes[0]);
        CHECK(answer.status == UpdateStatus::learned);
        CHECK(answer.error_before == Approx(1 / 3.0).epsilon(1e-4));
        CHECK(answer.error_after < 0.03);
        CHECK(worst_error(adaptation.model(), {pokes.begin(), pokes.begin() + 1}) < 0.03);
        if (kind == "scale") CHECK(worst_error(adaptation.model(), pokes) < 0.01);
        if (kind == "scale") CHECK(adaptation.state().x[0] == Approx(std::log(1.5)).epsilon(0.01));
    }
}

TEST_CASE("equal unknowns multiply all forces by their exponential including contacts", "[adapt]") {
    const TissueModel model = energy_model_example();
    const std::vector<ForceMeasurement> pokes = pokes_of(model, 4);
    for (const std::string kind : {"scale", "field", "elements"}) {
        const Unknowns u = make_unknowns(model, kind);
        TissueModel twice = model;
        twice.energy_model = with_unknowns(*model.energy_model, u, Eigen::VectorXd::Constant(u.size(), std::log(2.0)));
        for (const ForceMeasurement& poke : pokes) CHECK((IndentationSolver(twice).at(poke.contact_m, poke.push_m).contact_force - 2 * poke.force_N).norm() < 1e-8 * poke.force_N.norm());
    }
}

TEST_CASE("the derivative of a predicted force agrees with differences for every kind of unknowns", "[adapt]") {
    const TissueModel model = half_stiff();
    const std::vector<ForceMeasurement> pokes = pokes_of(model, 3, 5);
    for (const std::string& kind : unknown_kinds()) {
        Adaptation adaptation(model, options(kind));
        const Eigen::Index P = adaptation.unknowns().size();
        for (const ForceMeasurement& poke : pokes) {
            const Expected at = adaptation.expect(poke.contact_m, poke.push_m);
            REQUIRE(at.status == SolverStatus::converged);
            Draw draw(3);
            Eigen::VectorXd way(P);
            for (double& w : way) w = draw(-1, 1);
            constexpr double h = 1e-4;
            const auto force = [&](double step) {
                TissueModel there = model;
                there.energy_model = with_unknowns(*model.energy_model, adaptation.unknowns(), step * way);
                return Point(IndentationSolver(there).at(poke.contact_m, poke.push_m).contact_force);
            };
            const Point by_differences = (force(h) - force(-h)) / (2 * h);
            CHECK((at.by_x * way * at.force_N.norm() - by_differences).norm() < 1e-5 * at.force_N.norm());
        }
    }
}

TEST_CASE("measurements find a stiffer half and each reduces the posterior variance", "[adapt]") {
    const TissueModel model = energy_model_example(), target = half_stiff();
    const std::vector<ForceMeasurement> pokes = pokes_of(target, 40), held_out = pokes_of(target, 20, 77);
    Adaptation adaptation(model, options());
    const double before = worst_error(model, held_out);
    double variance = adaptation.state().P.trace();
    for (const ForceMeasurement& poke : pokes) {
        CHECK(adaptation.learn(poke).status == UpdateStatus::learned);
        CHECK(adaptation.state().P.trace() < variance);
        variance = adaptation.state().P.trace();
    }
    CHECK(worst_error(adaptation.model(), held_out) < 0.2 * before);
    const Expected known = adaptation.expect(pokes[0].contact_m, pokes[0].push_m);
    CHECK(std::sqrt(adaptation.covariance(known, false).trace() / 2) < 0.03);
    // P stays symmetric with a positive diagonal
    CHECK(adaptation.state().P.diagonal().minCoeff() > 0);
    CHECK(adaptation.state().P == adaptation.state().P.transpose());
}

TEST_CASE("a uniform scale is used while it explains all measurements and the field afterwards", "[adapt]") {
    const TissueModel model = energy_model_example(), same = stiffer(model, 0.5);
    AdaptOptions alone = options();
    alone.rival = false;
    Adaptation with_rival(model, options()), without(model, alone);
    CHECK_FALSE(with_rival.single_scale_in_use());
    const std::vector<ForceMeasurement> held_out = pokes_of(same, 20, 77);
    for (const ForceMeasurement& poke : pokes_of(same, 5)) {
        with_rival.learn(poke);
        without.learn(poke);
    }
    CHECK(with_rival.single_scale_in_use());
    CHECK_FALSE(without.single_scale_in_use());
    CHECK((with_rival.state().x - without.state().x).norm() < 1e-4);  // the field does not depend on the scale
    CHECK(with_rival.state().scale == Approx(0.5).epsilon(0.01));
    CHECK((with_rival.sd().array() - std::sqrt(with_rival.state().scale_variance)).abs().maxCoeff() < 1e-12);
    CHECK((without.sd().array().square() - without.state().P.diagonal().array()).abs().maxCoeff() < 1e-12);
    CHECK(worst_error(with_rival.model(), held_out) < 0.01);
    CHECK(worst_error(with_rival.model(), held_out) < 0.5 * worst_error(without.model(), held_out));
    const Expected e = with_rival.expect(held_out[0].contact_m, held_out[0].push_m);
    CHECK((e.force_N - held_out[0].force_N).norm() < 0.01 * e.force_N.norm());

    // another place of the tissue is stiffer still
    ForceMeasurement poke = held_out[3];
    poke.force_N *= 1.5;
    const UpdateResult answer = with_rival.learn(poke);
    CHECK(answer.error_before == Approx(1 / 3.0).epsilon(0.03));
    if (answer.status == UpdateStatus::learned) CHECK_FALSE(with_rival.single_scale_in_use());

    Adaptation halves(model, options());
    for (const ForceMeasurement& p : pokes_of(half_stiff(), 12)) halves.learn(p);
    CHECK_FALSE(halves.single_scale_in_use());
    for (const std::string kind : {"scale", "terms"}) CHECK_FALSE(Adaptation(model, options(kind)).has_single_scale());
}

TEST_CASE("an invalid measurement is refused and leaves the state unchanged bit for bit", "[adapt]") {
    const TissueModel model = energy_model_example(), target = stiffer(model, 0.3);
    const std::vector<ForceMeasurement> pokes = pokes_of(target, 6);
    Adaptation adaptation(model, options());
    adaptation.learn(pokes[0]);
    const Eigen::VectorXd x = adaptation.state().x;
    const Eigen::MatrixXd P = adaptation.state().P;
    const auto refused = [&](ForceMeasurement poke, const std::string& why) {
        const UpdateResult answer = adaptation.learn(poke);
        CHECK(answer.status == UpdateStatus::refused);
        CHECK_THAT(answer.why, Contains(why));
        CHECK(adaptation.state().x == x);
        CHECK(adaptation.state().P == P);
    };
    refused(pokes[0], "identical to the measurement before it");
    ForceMeasurement poke = pokes[1];
    poke.force_N = pokes[0].force_N;
    refused(poke, "exactly the force");
    poke = pokes[1];
    poke.force_N[0] = std::numeric_limits<double>::quiet_NaN();
    refused(poke, "number that is not finite");
    poke = pokes[1];
    poke.contact_m = Eigen::Vector2d(0.05, 0.05);
    refused(poke, "off the surface");
    poke = pokes[1];
    poke.push_m *= 1e-3;
    refused(poke, "are needed");
    poke.push_m = pokes[1].push_m * 1e3;  // millimetres taken for metres
    refused(poke, "half of the tissue's");
    poke.push_m = -pokes[1].push_m;
    refused(poke, "must point into the tissue");
    poke = pokes[1];
    poke.force_N *= -1;
    refused(poke, "against its tool displacement");
    poke.force_N.setZero();
    refused(poke, "may be disconnected");
    poke = pokes[1];
    poke.contact_m = Point::Zero(3);
    refused(poke, "2 axes");
    CHECK(adaptation.learn(pokes[1]).status == UpdateStatus::learned);
    CHECK(adaptation.state().refused == 10);
    Adaptation fresh(model, options());
    CHECK_THAT(fresh.learn({Eigen::Vector2d(0.05, 0.1), Eigen::Vector2d(0, -0.03), Eigen::Vector2d(0, -2)}).why,
               Contains("the model has no equilibrium there: the spring mesh is unstable under the indentation"));
}

TEST_CASE("a force ten times too large is gated and four in a row cause a warning", "[adapt]") {
    const TissueModel model = energy_model_example();
    const std::vector<ForceMeasurement> pokes = pokes_of(model, 10);
    Adaptation adaptation(model, options());
    for (int i = 0; i < 4; ++i) adaptation.learn(pokes[static_cast<std::size_t>(i)]);
    const Eigen::VectorXd x = adaptation.state().x;
    for (int i = 4; i < 8; ++i) {
        ForceMeasurement poke = pokes[static_cast<std::size_t>(i)];
        poke.force_N *= 10;
        const UpdateResult answer = adaptation.learn(poke);
        CHECK(answer.status == UpdateStatus::gated);
        CHECK(answer.chi2 > answer.gate);
        CHECK(adaptation.state().x == x);
        CHECK(answer.warning.empty() == (i < 7));
    }
    CHECK(adaptation.state().gated == 4);
    // a wrong unit: a thousand times too small
    ForceMeasurement poke = pokes[8];
    poke.force_N *= 1e-3;
    CHECK(adaptation.learn(poke).status == UpdateStatus::gated);
    CHECK(adaptation.learn(pokes[9]).status == UpdateStatus::learned);
    CHECK(adaptation.state().gated_in_a_row == 0);
}

TEST_CASE("a drifting force sensor causes a warning in adaptation and a steady one none", "[adapt]") {
    const TissueModel model = energy_model_example();
    const std::vector<ForceMeasurement> pokes = pokes_of(model, 40);
    Adaptation adaptation(model, options("scale"));
    bool warned = false;
    for (std::size_t i = 0; i < pokes.size(); ++i) {
        ForceMeasurement poke = pokes[i];
        poke.force_N *= 1 + 0.03 * static_cast<double>(i);
        warned = warned || !adaptation.learn(poke).warning.empty();
    }
    CHECK(warned);
    // no warning without drift
    Adaptation steady(model, options("scale"));
    for (const ForceMeasurement& poke : pokes) CHECK(steady.learn(poke).warning.empty());
}

TEST_CASE("at least 85 % of test measurements lie within their predicted 95 % ellipse, which is at most twice too wide", "[adapt][long]") {
    const TissueModel model = energy_model_example();
    AdaptOptions o = options();
    o.model_error = 0.005;  // the references are models on the same mesh
    int inside = 0, all = 0;
    double squares = 0;
    for (unsigned long seed = 1; seed <= 6; ++seed) {
        // tissues drawn from the prior
        const Unknowns u = make_unknowns(model, "field", o.prior);
        const Eigen::LLT<Eigen::MatrixXd> root(u.prior + 1e-9 * Eigen::MatrixXd::Identity(u.size(), u.size()));
        Draw draw(seed);
        Eigen::VectorXd z(u.size());
        for (double& value : z) value = std::sqrt(-2 * std::log(draw(1e-12, 1))) * std::cos(6.283185307179586 * draw(0, 1));
        TissueModel target = model;
        target.energy_model = with_unknowns(*model.energy_model, u, (root.matrixL() * z).eval());
        Adaptation adaptation(model, o);
        for (const ForceMeasurement& poke : pokes_of(target, 8, seed)) adaptation.learn(poke);
        for (const ForceMeasurement& poke : pokes_of(target, 15, 100 + seed)) {
            const Expected e = adaptation.expect(poke.contact_m, poke.push_m);
            const Point off = (poke.force_N - e.force_N) / e.force_N.norm();
            const Eigen::MatrixXd S = adaptation.covariance(e);
            const double square = off.dot(S.ldlt().solve(off));
            inside += square < 5.991;  // 95 % quantile of chi-squared with two degrees of freedom
            squares += square;
            ++all;
        }
    }
    CHECK(inside >= 0.85 * all);
    CHECK(squares / all > 2 / 4.0);  // 2 where S is the covariance of `off`; a quarter of it where S is four times that
}

TEST_CASE("a place error of the contact increases the posterior variance", "[adapt]") {
    const TissueModel model = energy_model_example(), target = stiffer(model, 0.4);
    const ForceMeasurement poke = pokes_of(target, 1, 4)[0];
    AdaptOptions o = options("scale");
    Adaptation sure(model, o);
    o.place_error_m = 0.003;
    Adaptation unsure(model, o);
    sure.learn(poke);
    unsure.learn(poke);
    CHECK(unsure.state().P(0, 0) > sure.state().P(0, 0));
}

TEST_CASE("measurements on relaxing tissue update the long-term or the instantaneous model as selected", "[adapt][memory]") {
    const TissueModel model = relaxing(energy_model_example()), target = relaxing(stiffer(energy_model_example(), 0.4));
    for (bool at_rest : {true, false}) {
        TissueModel read = target, known = model;
        read.energy_model = at_rest ? long_term(*target.energy_model) : instantaneous(*target.energy_model);
        AdaptOptions o = options("scale");
        o.at_rest = at_rest;
        Adaptation adaptation(model, o);
        for (const ForceMeasurement& poke : pokes_of(read, 3)) CHECK(adaptation.learn(poke).status == UpdateStatus::learned);
        CHECK(adaptation.state().x[0] == Approx(0.4).epsilon(0.02));
        CHECK(adaptation.model().energy_model->relaxation.branches() == 3);
    }
}

TEST_CASE("adaptation refuses spring sets and an unknown kind of unknowns", "[adapt]") {
    CHECK_THROWS_WITH(Adaptation(haptic_example()), Contains("only an energy model learns"));
    CHECK_THROWS_WITH(Adaptation(energy_model_example(), options("colour")), Contains("'colour'") && Contains("field"));
}

TEST_CASE("a prediction off the tissue's surface or for an invalid displacement is refused", "[adapt]") {
    Adaptation adaptation(energy_model_example());
    const Point contact = Eigen::Vector2d(0.05, 0.1), push = Eigen::Vector2d(0, -0.004);
    CHECK(adaptation.expect(contact, push).status == SolverStatus::converged);
    for (const Point& wrong : {Point(Eigen::Vector2d(std::nan(""), 0.1)), Point(Eigen::Vector2d(5, 5)), Point(Eigen::Vector2d(0.05, 0)), Point(Eigen::Vector3d(0.05, 0.1, 0))})
        CHECK_THROWS_AS(adaptation.expect(wrong, push), MismatchError);
    CHECK_THROWS_AS(adaptation.expect(contact, -push), MismatchError);
    CHECK_THROWS_AS(adaptation.expect(contact, Point(Eigen::Vector2d(0, std::nan("")))), MismatchError);
}
