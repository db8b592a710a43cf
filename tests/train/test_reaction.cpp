#include "train/reaction.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "../measured_example.h"
#include "../refusal.h"
#include "../tolerances.h"
#include "cases/measured_cases.h"
#include "error.h"
#include "eval/evaluation.h"
#include "mesh/outline.h"
#include "springs/equilibrium.h"
#include "springs/heuristic.h"
#include "train/certificate.h"
#include "train/train_sets.h"

using namespace tissue;

namespace {

Eigen::VectorXd closed_loop(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                            const SurfacePoint& contact, const Eigen::VectorXd& push) {
    const auto state = solve_equilibrium(mesh, law, theta, contact, push);
    REQUIRE(state);
    return state.contact_force;
}

struct Pressed {
    SpringMesh mesh = measured_mesh();
    std::unique_ptr<SpringLaw> law;
    Eigen::VectorXd truth = example_theta(mesh);
    Eigen::VectorXd start = heuristic_stiffness(mesh, 1.5);
    Box box{Eigen::VectorXd::Constant(start.size(), 0.05), Eigen::VectorXd::Constant(start.size(), 60)};
    std::vector<Reading> readings;

    explicit Pressed(const std::string& law_name) : law(make_spring_law(law_name)) {
        const Outline outline(mesh);
        for (double arc : {0.03, 0.06, 0.13, 0.15, 0.24})
            for (double angle : {-0.5, 0.3}) {
                const Reading r{locate_on_surface(mesh, outline.position(arc)), 0.006 * outline.direction(arc, angle), {}};
                readings.push_back(r);
                readings.back().force_N = closed_loop(mesh, *law, truth, r.contact, r.push_m);
            }
    }
};

/// The closed loop's forces of a known set, as an instrument without noise would give them.
MeasuredTable table_of(const Study& study, const Eigen::VectorXd& theta) {
    const SpringMesh mesh = measured_mesh();
    const auto law = make_spring_law(study.springs.law);
    const Outline outline(mesh);
    MeasuredTable table{"data.csv", "a spring mesh", {}};
    for (int i = 0; i <= 52; ++i) {
        const double arc = 0.020 + 0.005 * i;
        for (double angle : {-0.6, 0.0, 0.6}) {
            const Eigen::Vector2d contact = outline.position(arc), push = 0.005 * outline.direction(arc, angle);
            const Eigen::Vector2d force = closed_loop(mesh, *law, theta, locate_on_surface(mesh, contact), push);
            table.rows.push_back({static_cast<int>(table.rows.size()) + 2, contact, push, force, "", ""});
        }
    }
    return table;
}

}  // namespace

TEST_CASE("the answers to many contacts at once are those to each alone", "[reaction]") {
    for (const char* name : {"axial", "geometric", "isotropic"}) {
        const Pressed p(name);
        std::vector<SurfacePoint> contacts;
        std::vector<Eigen::VectorXd> pushes;
        for (const Reading& r : p.readings) contacts.push_back(r.contact), pushes.push_back(r.push_m);
        EquilibriumStatus status{};
        const auto together = contact_responses(p.mesh, *p.law, p.truth, contacts, pushes, status);
        REQUIRE(together);
        for (std::size_t i = 0; i < contacts.size(); ++i) {
            const auto alone = solve_equilibrium(p.mesh, *p.law, p.truth, contacts[i], pushes[i]);
            const auto G = contact_sensitivity(p.mesh, *p.law, p.truth, contacts[i], alone.displacement);
            const ContactResponse& r = (*together)[i];
            CHECK(r.state.contact_force.isApprox(alone.contact_force, tolerance::solve));
            CHECK(r.state.displacement.isApprox(alone.displacement, tolerance::solve));
            CHECK(r.sensitivity.isApprox(*G, tolerance::solve));
        }
    }
}

TEST_CASE("a fit's linearisation is the closed loop's own answer, and its derivative to every spring", "[reaction]") {
    for (const char* name : {"axial", "geometric"}) {
        const Pressed p(name);
        const ReactionFit fit = fit_reactions(p.mesh, *p.law, {p.readings[3]}, p.start, p.start, 1, p.box);
        const Reading& r = p.readings[3];
        const Eigen::MatrixXd GA = fit.losses[0].matrix();
        CHECK((GA * fit.theta).isApprox(closed_loop(p.mesh, *p.law, fit.theta, r.contact, r.push_m), tolerance::newton));
        for (Eigen::Index s = 0; s < fit.theta.size(); s += 7) {
            Eigen::VectorXd more = fit.theta, less = fit.theta;
            const double h = 1e-4 * fit.theta[s];
            more[s] += h, less[s] -= h;
            const Eigen::VectorXd slope = (closed_loop(p.mesh, *p.law, more, r.contact, r.push_m) -
                                           closed_loop(p.mesh, *p.law, less, r.contact, r.push_m)) / (2 * h);
            CHECK((slope - GA.col(s)).norm() <= 1e-6 * GA.norm());  // second-order difference, and Newton's 1e-10 over h
        }
    }
}

TEST_CASE("readings of a known spring set are met, inside the box", "[reaction]") {
    for (const char* name : {"axial", "geometric"}) {
        const Pressed p(name);
        const ReactionFit fit = fit_reactions(p.mesh, *p.law, p.readings, p.start, p.start, 1e-4, p.box);
        CHECK(fit.status == ReactionStatus::converged);
        CHECK(fit.theta == p.box.project(fit.theta));
        for (const Reading& r : p.readings)
            CHECK((closed_loop(p.mesh, *p.law, fit.theta, r.contact, r.push_m) - r.force_N).norm() <= 1e-3 * r.force_N.norm());
    }
}

TEST_CASE("a fit's last step is certified by its own problem, whether the box holds springs or not", "[reaction]") {
    Pressed p("axial");
    p.start = 0.9 * p.truth;
    p.box = {0.1 * p.truth, 10 * p.truth};
    for (bool tight : {false, true}) {
        if (tight) p.box = {0.98 * p.start, 1.02 * p.start};
        ReactionOptions options;
        options.tolerance = 1e-12;
        const ReactionFit fit = fit_reactions(p.mesh, *p.law, p.readings, p.start, p.start, 1, p.box, options);
        const bool held = ((fit.theta - p.box.lo).array() == 0).any() || ((fit.theta - p.box.hi).array() == 0).any();
        CHECK(held == tight);
        const double loss = fit.inner(fit.theta);
        CHECK(loss - loss_lower_bound(fit.inner, fit.theta, p.box) <= 1e-3 * loss);
    }
}

TEST_CASE("the best factor is the factor", "[reaction]") {
    const Pressed p("axial");
    CHECK(best_factor(p.mesh, *p.law, p.readings, 0.2 * p.truth) == Approx(5).epsilon(tolerance::solve));
}

TEST_CASE("a mesh with zero-energy modes cannot be trained on contact forces alone, and says why", "[reaction]") {
    Study study = measured_study();
    const Cases cases = measured_cases(study, table_of(study, example_theta(measured_mesh())));
    study.springs.topology = "grid4";
    CHECK_THAT(refusal<MismatchError>([&] { train_sets(study, cases, 2); }), Catch::Contains("zero-energy"));
}

TEST_CASE("noise-free data of a known spring model come back: trained contacts and held-out ones", "[reaction]") {
    Study study = measured_study();
    const Eigen::VectorXd heuristic = heuristic_stiffness(measured_mesh(), study.modulus_N_m());
    Eigen::VectorXd theta = heuristic;
    for (Eigen::Index s = 0; s < theta.size(); ++s) theta[s] *= 1 + 0.3 * std::sin(3.0 * static_cast<double>(s));
    study.training.ridge = study.training.one_set_ridge = 1e-7;
    const Cases cases = measured_cases(study, table_of(study, theta));
    const TrainedModel model = train_sets(study, cases, 2);
    const Evaluation e = evaluate(model, cases, 0, 1, 2);
    CHECK(e.model("learned").closed_loop().force.max < 1e-3);
    const DrawnContacts* held_out = e.held_out.role("held_out");
    REQUIRE(held_out);
    REQUIRE(e.held_out.models[0] == "learned");
    CHECK(held_out->statistics(0).force.n == 3 * 11);
    CHECK(held_out->statistics(0).force.max < 1e-3);
    CHECK(e.model("heuristic_a").closed_loop().force.median > 0.01);  // it was not there to begin with

    const nlohmann::json j = nlohmann::json::parse(to_json(e, 1));
    for (const char* role : {"trained", "held_out"})
        for (const auto& [name, entry] : j["closed_loop"][role].items()) {
            CAPTURE(role, name);
            CHECK_FALSE(entry.contains("shape"));  // nobody saw inside
            CHECK_FALSE(entry.contains("shape_max_over_depth"));
        }
    CHECK_FALSE(j["drawn"]["held_out"][0].contains("shape"));
    CHECK_FALSE(j.contains("drawn_shapes"));
    CHECK_THAT(to_markdown(e), !Catch::Contains("shape"));
}

TEST_CASE("without a ridge a fit stays inside its box to the last bit, step after step", "[reaction]") {
    int at_floor = 0;
    for (const char* name : {"axial", "geometric"})
        for (double floor : {0.03, 0.1, 0.2, 0.45}) {
            Pressed p(name);
            p.start = 1.1 * p.truth.reverse();  // far from its box: a difference added again misses by a rounding
            p.box = {floor * p.start, 9 * p.start};
            CAPTURE(name, floor);
            const ReactionFit fit = fit_reactions(p.mesh, *p.law, p.readings, p.start, p.start, 0, p.box);
            CHECK(fit.iterations > 1);
            CHECK(fit.theta == p.box.project(fit.theta));
            at_floor += static_cast<int>((fit.theta.array() == p.box.lo.array()).count());
        }
    CHECK(at_floor > 0);
}

TEST_CASE("the gap of a set trained on readings does not know their unit", "[reaction]") {
    Study study = measured_study();
    study.training.optimizer = "spsa-2008";
    study.training.iterations = 50;
    study.training.ridge = study.training.one_set_ridge = 1e-5;
    const MeasuredTable table = table_of(study, example_theta(measured_mesh()));
    const auto trained = [&](double factor) {
        Study s = study;
        s.material.C1_Pa *= factor, s.material.C2_Pa *= factor;
        MeasuredTable t = table;
        for (MeasuredRow& row : t.rows) row.force_N *= factor;
        return train_sets(s, measured_cases(s, t), 2);
    };
    constexpr double factor = 1024;  // a power of two: not even a rounding may tell
    const TrainedModel one = trained(1), other = trained(factor);
    const TrainingBook &a = one.books.trained.front(), &b = other.books.trained.front();
    CHECK(a.gap.minCoeff() > 1e-4);  // fifty iterations of a random walk have left something to gain
    for (Eigen::Index c = 0; c < a.gap.size(); ++c) {
        CHECK(b.gap[c] == Approx(a.gap[c]).epsilon(tolerance::rounding));
        CHECK(b.loss_N[c] == Approx(factor * a.loss_N[c]).epsilon(tolerance::rounding));  // newtons, as it says
        CHECK(other.books.optimum.lower_bound_N[c] == Approx(factor * one.books.optimum.lower_bound_N[c]).epsilon(tolerance::rounding));
    }
}

TEST_CASE("a fit says how it ended: at its tolerance, out of steps, or with no step that lowers the objective", "[reaction]") {
    const Pressed p("axial");
    const auto fit = [&](int max_iterations, double tolerance) {
        return fit_reactions(p.mesh, *p.law, p.readings, p.start, p.start, 0.1, p.box, {max_iterations, tolerance});
    };
    CHECK(fit(30, 1e-4).status == ReactionStatus::converged);
    CHECK(fit(1, 1e-4).status == ReactionStatus::iterations_done);
    CHECK(fit(1, 1e-4).iterations == 1);
    const ReactionFit end = fit(1000, -1);  // more than rounding gives: it stops where no step lowers the objective
    CHECK(end.status == ReactionStatus::stalled);
    CHECK(end.iterations < 1000);
}

TEST_CASE("a reading without a force does not count in a fit", "[reaction]") {
    const Pressed p("axial");
    std::vector<Reading> more = p.readings;
    more.push_back(p.readings[2]);
    more.back().force_N.setZero();
    const ReactionFit a = fit_reactions(p.mesh, *p.law, p.readings, p.start, p.start, 1e-3, p.box),
                      b = fit_reactions(p.mesh, *p.law, more, p.start, p.start, 1e-3, p.box);
    CHECK(b.theta.isApprox(a.theta, tolerance::solve));
    CHECK(best_factor(p.mesh, *p.law, more, p.start) == Approx(best_factor(p.mesh, *p.law, p.readings, p.start)));
    const std::vector<Reading> none = {more.back()};
    CHECK_THAT(refusal<MismatchError>([&] { best_factor(p.mesh, *p.law, none, p.start); }), Catch::Contains("no reading has a force"));
}
