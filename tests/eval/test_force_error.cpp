#include "eval/force_error.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../example.h"
#include "springs/heuristic.h"
#include "../tolerances.h"
#include "eval/statistics_json.h"

using namespace tissue;

TEST_CASE("statistics equal quantiles computed by hand") {
    const Statistics four = statistics_of({4, 1, 3, 2});
    CHECK(four.median == Approx(2.5).epsilon(tolerance::rounding));
    CHECK(four.p95 == Approx(3.85).epsilon(tolerance::rounding));  // 0.95 of the way from 1st to 4th: 3 + 0.85
    CHECK(four.max == 4);
    CHECK(four.n == 4);
    std::vector<double> ramp;
    for (int i = 100; i >= 0; --i) ramp.push_back(i);
    CHECK(statistics_of(ramp).median == Approx(50).epsilon(tolerance::rounding));
    CHECK(statistics_of(ramp).p95 == Approx(95).epsilon(tolerance::rounding));
    const Statistics one = statistics_of({7});
    CHECK(one.median == 7);
    CHECK(one.p95 == 7);
    CHECK(one.max == 7);
    CHECK(statistics_of({1, 2}).median == Approx(1.5).epsilon(tolerance::rounding));
}

TEST_CASE("a missing answer is infinite in the quantiles and a missing reference counts only in N") {
    constexpr double missing = std::numeric_limits<double>::infinity(), nothing = std::numeric_limits<double>::quiet_NaN();
    const Statistics s = statistics_of({missing, 1, nothing, 3, 2}, 4);
    CHECK(s.median == 2.5);  // of 1, 2, 3, infinity
    CHECK(std::isinf(s.p95));
    CHECK(std::isinf(s.max));
    CHECK(s.n == 3);
    CHECK(s.missing == 1);
    CHECK(s.no_reference == 5);
    CHECK(s.of() == 9);
    CHECK(n_of_N(s) == "3 of 9");
    CHECK(n_of_N(s, "contacts") == "3 of 9 contacts, 1 without an answer, 5 without a reference");

    std::vector<double> one_of_21(21, 0.5);  // the 95th percentile is the 20th of them, whatever the 21st is
    one_of_21[0] = missing;
    CHECK(statistics_of(one_of_21).p95 == 0.5);
    CHECK(std::isinf(statistics_of(one_of_21).max));
    one_of_21[1] = missing;
    CHECK(std::isinf(statistics_of(one_of_21).p95));
    const Statistics none = statistics_of({missing, missing});
    CHECK(std::isinf(none.median));
    CHECK(none.n == 0);
    CHECK(none.missing == 2);
}

TEST_CASE("JSON has null for infinite and undefined quantiles beside the number of missing answers") {
    constexpr double missing = std::numeric_limits<double>::infinity();
    const auto j = [](const Statistics& s) { return nlohmann::json::parse(to_value(s).dump()); };
    CHECK(j(statistics_of({1, 2, 3, missing}, 2)) ==
          nlohmann::json({{"median", 2.5}, {"p95", nullptr}, {"max", nullptr}, {"n", 3}, {"of", 6}, {"missing", 1}, {"no_reference", 2}}));
    CHECK(j(statistics_of({}, 2)) ==
          nlohmann::json({{"median", nullptr}, {"p95", nullptr}, {"max", nullptr}, {"n", 0}, {"of", 2}, {"missing", 0}, {"no_reference", 2}}));
}

TEST_CASE("an empty sample has n = 0 and undefined quantiles") {
    const Statistics none = statistics_of({});
    CHECK(none.n == 0);
    CHECK(std::isnan(none.median));
    CHECK(std::isnan(none.p95));
    CHECK(std::isnan(none.max));
}

TEST_CASE("springs of the reference have no nodal-force error and zero stiffness has an error of 1") {
    const Study study = example_study();
    const SpringMesh mesh = make_lattice("grid8", 4, 4, 0.1, 0.1);
    const Eigen::VectorXd theta = example_theta(mesh), weight = Eigen::VectorXd::Constant(mesh.node_count(), 0.9);
    const Cases cases = example_cases(study, theta);
    const auto law = make_spring_law("axial");
    for (const LoadCase& load : load_cases(cases)) {
        const SurfacePoint contact = locate_on_surface(mesh, load.path->contact_m);
        const ForceError exact = force_error(mesh, *law, theta, contact, weight, *load.path, *load.record);
        CHECK(exact.rel_loss <= tolerance::rounding);
        CHECK(exact.resolved_error <= tolerance::solve);
        CHECK(exact.resolved_force_N ==
              Approx(load.record->contact_force_N.dot(load.path->direction)).epsilon(tolerance::solve));
        const ForceError none = force_error(mesh, *law, 0 * theta, contact, weight, *load.path, *load.record);
        CHECK(none.rel_loss == Approx(1).epsilon(tolerance::rounding));
        CHECK(none.resolved_force_N == 0);
        CHECK(none.resolved_error == 1);
        // 1.5 times the stiffness has an error of 1/2
        const ForceError stiff = force_error(mesh, *law, 1.5 * theta, contact, weight, *load.path, *load.record);
        CHECK(stiff.rel_loss == Approx(0.5).epsilon(tolerance::solve));
        CHECK(stiff.resolved_error == Approx(0.5).epsilon(tolerance::solve));
    }
}

TEST_CASE("rel_loss is independent of the scale of Q and of nodes with zero weight") {
    const Study study = example_study();
    const SpringMesh mesh = make_lattice("grid8", 4, 4, 0.1, 0.1);
    const Cases cases = example_cases(study, example_theta(mesh));
    const LoadCase load = load_cases(cases).front();
    const auto law = make_spring_law("axial");
    const SurfacePoint contact = locate_on_surface(mesh, load.path->contact_m);
    const Eigen::VectorXd theta = heuristic_stiffness(mesh, 1.0);
    Eigen::VectorXd weight = Eigen::VectorXd::Constant(mesh.node_count(), 0.9);
    const auto loss = [&](const Eigen::VectorXd& Q, const PathRecord& record) {
        return force_error(mesh, *law, theta, contact, Q, *load.path, record).rel_loss;
    };
    CHECK(loss(weight / 3, *load.record) == Approx(loss(weight, *load.record)).epsilon(tolerance::rounding));
    weight[7] = 0;
    PathRecord other = *load.record;
    other.force.row(7) << 3, 4;
    CHECK(loss(weight, other) == loss(weight, *load.record));
}

TEST_CASE("the resolved force between two nodes is the sum over both along the direction") {
    const SpringMesh mesh = make_lattice("grid4", 2, 2, 0.1, 0.1);
    const auto law = make_spring_law("isotropic");
    NodeField u = NodeField::Zero(mesh.node_count(), 2);
    const SurfacePoint between = locate_on_surface(mesh, {0.1, 0.06}), on_node = locate_on_surface(mesh, {0.1, 0.05});
    u.row(node_at(mesh, Eigen::Vector2d(0.1, 0.05))) << -0.002, 0.001;
    u.row(node_at(mesh, Eigen::Vector2d(0.1, 0.1))) << -0.002, 0.001;
    const Eigen::VectorXd theta = Eigen::VectorXd::Constant(mesh.spring_count(), 2.0);
    // middle node: to the left and down, 2 springs moved by u; top corner: to the left, one spring
    CHECK(resolved_force(mesh, *law, theta, on_node, {-1, 0}, u) == Approx(2 * 2 * 0.002).epsilon(tolerance::rounding));
    CHECK(resolved_force(mesh, *law, theta, between, {-1, 0}, u) == Approx(3 * 2 * 0.002).epsilon(tolerance::rounding));
    CHECK(resolved_force(mesh, *law, theta, between, {0, 1}, u) == Approx(3 * 2 * 0.001).epsilon(tolerance::rounding));
}
