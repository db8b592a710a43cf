#include "springs/equilibrium.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "../example.h"
#include "springs/heuristic.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const Eigen::Vector2d push(0.004, -0.001);

const SpringMesh& block() {
    static const SpringMesh mesh = make_lattice("grid8", 6, 6, 0.1, 0.1);
    return mesh;
}

Equilibrium rest(const std::string& law, const Eigen::Vector2d& contact_m, const Eigen::VectorXd& d = push,
                 const SpringMesh& mesh = block()) {
    const Equilibrium state =
        solve_equilibrium(mesh, *make_spring_law(law), example_theta(mesh), locate_on_surface(mesh, contact_m), d);
    INFO(reason_of(state.status));
    REQUIRE(state);
    return state;
}

NodeField nodal_force(const std::string& law, const NodeField& u) {
    const Eigen::VectorXd f = make_spring_law(law)->force_matrix(block(), u) * example_theta(block());
    return Eigen::Map<const NodeField>(f.data(), u.rows(), 2);
}

double slack(const std::string& law) {
    return !make_spring_law(law)->linear_in_displacement() ? tolerance::newton : tolerance::solve;
}

/// Energy of geometric springs of the block [J].
double geometric_energy(const NodeField& u) {
    double sum = 0;
    const Eigen::VectorXd theta = example_theta(block());
    for (int s = 0; s < block().spring_count(); ++s) {
        const int i = block().springs(s, 0), j = block().springs(s, 1);
        const double length = (block().nodes.row(i) + u.row(i) - block().nodes.row(j) - u.row(j)).norm();
        sum += theta[s] / 2 * std::pow(length - block().rest_length(s), 2);
    }
    return sum;
}

}  // namespace

TEST_CASE("springs in series between support and contact stretch in inverse proportion to their stiffness") {
    // A column of two cells. Only its vertical springs are loaded: nodes 0 and 1 are fixed, and the contact displaces
    // both top nodes upwards.
    const SpringMesh cell = make_lattice("grid4", 1, 2, 0.1, 0.2);
    Eigen::VectorXd theta = Eigen::VectorXd::Ones(cell.spring_count());
    for (int s = 0; s < cell.spring_count(); ++s)
        if (cell.nodes(cell.springs(s, 0), 0) == cell.nodes(cell.springs(s, 1), 0))
            theta[s] = cell.nodes(cell.springs(s, 0), 1) == 0 ? 3.0 : 1.0;  // lower springs 3 N/m, upper ones 1 N/m
    const auto state = solve_equilibrium(cell, *make_spring_law("isotropic"), theta,
                                         locate_on_surface(cell, {0.05, 0.2}), Eigen::Vector2d(0, 0.004));
    REQUIRE(state);
    // two columns in parallel, each 3 and 1 N/m in series: 2 * 0.75 N/m * 4 mm
    CHECK(state.contact_force.y() == Approx(2 * 0.75 * 0.004).epsilon(tolerance::solve));
    CHECK(state.displacement(node_at(cell, Eigen::Vector2d(0, 0.1)), 1) == Approx(0.001).epsilon(tolerance::solve));
}

TEST_CASE("the contact has the prescribed displacement and fixed nodes have none") {
    for (const std::string& law : spring_laws().names()) {
        for (const Eigen::Vector2d& at : {Eigen::Vector2d(0, 0.05), Eigen::Vector2d(0.1, 0.061)}) {
            const Equilibrium state = rest(law, at);
            const SurfacePoint p = locate_on_surface(block(), at);
            const Eigen::RowVector2d moved =
                p.weight[0] * state.displacement.row(p.node[0]) + p.weight[1] * state.displacement.row(p.node[1]);
            CHECK((moved.transpose() - push).norm() <= slack(law) * push.norm());
            for (int node : block().fixed) CHECK(state.displacement.row(node).norm() == 0);
        }
    }
}

TEST_CASE("contact force and support forces sum to zero; other nodes have no net force") {
    for (const std::string& law : spring_laws().names()) {
        INFO(law);
        const Eigen::Vector2d at(0.1, 0.061);
        const Equilibrium state = rest(law, at);
        const NodeField f = nodal_force(law, state.displacement);
        const SurfacePoint p = locate_on_surface(block(), at);
        Eigen::RowVector2d support = Eigen::RowVector2d::Zero();
        double stray = 0;
        for (int i = 0; i < block().node_count(); ++i) {
            const bool fixed = std::count(block().fixed.begin(), block().fixed.end(), i) > 0;
            if (fixed) support += f.row(i);
            else if (i != p.node[0] && i != p.node[1]) stray = std::max(stray, f.row(i).norm());
        }
        CHECK((state.contact_force.transpose() + support).norm() <= slack(law) * support.norm());
        CHECK(stray <= slack(law) * support.norm());
    }
}

TEST_CASE("a contact between two nodes distributes its force by their weights") {
    for (const std::string& law : spring_laws().names()) {
        const Eigen::Vector2d at(0.0, 0.1 * 4.25 / 6);
        const Equilibrium state = rest(law, at);
        const NodeField f = nodal_force(law, state.displacement);
        const SurfacePoint p = locate_on_surface(block(), at);
        for (int end : {0, 1})
            CHECK((f.row(p.node[end]).transpose() - p.weight[end] * state.contact_force).norm() <=
                  slack(law) * state.contact_force.norm());
        CHECK(std::min(p.weight[0], p.weight[1]) == Approx(0.25).epsilon(tolerance::solve));
    }
}

TEST_CASE("linear spring laws: contact force times tool displacement is u'Ku; twice the springs' energy") {
    for (const char* law : {"isotropic", "axial"}) {
        const Equilibrium state = rest(law, {0.05, 0.1});
        const SparseMatrix K = make_spring_law(law)->stiffness(block(), example_theta(block()), state.displacement);
        const Eigen::VectorXd u = as_vector(state.displacement);
        CHECK(state.contact_force.dot(push) == Approx(u.dot(K * u)).epsilon(tolerance::solve));
    }
}

TEST_CASE("geometric springs: the derivative of the energy along the tool displacement is the contact force") {
    const Eigen::Vector2d at(0.05, 0.1);
    const double work = rest("geometric", at).contact_force.dot(push);
    const auto error = [&](double h) {
        const double slope = (geometric_energy(rest("geometric", at, (1 + h) * push).displacement) -
                              geometric_energy(rest("geometric", at, (1 - h) * push).displacement)) / (2 * h);
        return std::abs(slope - work) / work;
    };
    CHECK(error(0.01) < 1e-4);
    // coarse steps, beside which solver errors of 1e-8 are small
    CHECK(std::log2(error(0.4) / error(0.2)) == Approx(2).margin(4 * tolerance::order));
}

TEST_CASE("forces of linear laws are proportional to tool displacement; a stiffness factor scales forces alone") {
    const Equilibrium once = rest("axial", {0, 0.05}), twice = rest("axial", {0, 0.05}, 2 * push);
    CHECK(twice.contact_force.isApprox(2 * once.contact_force, tolerance::solve));
    CHECK(twice.displacement.isApprox(2 * once.displacement, tolerance::solve));
    for (const std::string& name : spring_laws().names()) {
        const Eigen::VectorXd theta = 7 * example_theta(block());
        const auto stiffer = solve_equilibrium(block(), *make_spring_law(name), theta,
                                               locate_on_surface(block(), {0, 0.05}), push);
        REQUIRE(stiffer);
        const Equilibrium soft = rest(name, {0, 0.05});
        CHECK(stiffer.contact_force.isApprox(7 * soft.contact_force, slack(name)));
        CHECK(stiffer.displacement.isApprox(soft.displacement, 10 * slack(name)));
    }
}

TEST_CASE("uniform scaling: twice the size and twice the tool displacement give twice the contact force") {
    const SpringMesh large = make_lattice("grid8", 6, 6, 0.2, 0.2);
    for (const std::string& law : spring_laws().names()) {
        const Equilibrium small = rest(law, {0, 0.05}), big = rest(law, {0, 0.1}, 2 * push, large);
        CHECK(big.contact_force.isApprox(2 * small.contact_force, slack(law)));
    }
}

TEST_CASE("mirrored tool displacements on a mirror-symmetric mesh have mirrored contact forces") {
    const Eigen::VectorXd theta = heuristic_stiffness(block(), 1.0);
    for (const std::string& name : spring_laws().names()) {
        const auto force = [&](double x, double dx) {
            const auto state = solve_equilibrium(block(), *make_spring_law(name), theta,
                                                 locate_on_surface(block(), {x, 0.071}), Eigen::Vector2d(dx, -0.002));
            REQUIRE(state);
            return state.contact_force;
        };
        const Eigen::VectorXd left = force(0, 0.005), right = force(0.1, -0.005);
        CHECK(left.x() == Approx(-right.x()).epsilon(slack(name)));
        CHECK(left.y() == Approx(right.y()).epsilon(slack(name)));
    }
}

TEST_CASE("geometric springs approach axial ones in proportion to the tool displacement") {
    const auto difference = [](double scale) {
        const Eigen::VectorXd d = scale * push;
        return (rest("geometric", {0, 0.05}, d).contact_force - rest("axial", {0, 0.05}, d).contact_force).norm() /
               scale;
    };
    // the relative difference is proportional to the tool displacement
    CHECK(std::log2(difference(0.02) / difference(0.01)) == Approx(1).margin(tolerance::order));
}

TEST_CASE("a mesh with zero-energy modes has no equilibrium and the reason names the modes") {
    const SpringMesh grid4 = make_lattice("grid4", 10, 10, 0.1, 0.1);
    const SurfacePoint contact = locate_on_surface(grid4, {0, 0.05});
    for (const char* law : {"axial", "geometric"}) {  // each free row slides without energy; the contact fixes one row
        const auto state = solve_equilibrium(grid4, *make_spring_law(law), heuristic_stiffness(grid4, 1.0), contact, push);
        CHECK(state.status == EquilibriumStatus::zero_energy_modes);
        CHECK_THAT(reason_of(state.status), Contains("zero-energy modes"));
    }
    CHECK(solve_equilibrium(grid4, *make_spring_law("isotropic"), heuristic_stiffness(grid4, 1.0), contact, push));
}

TEST_CASE("a node without stiffness or springs of negative stiffness leave no equilibrium") {
    const auto law = make_spring_law("isotropic");
    const SurfacePoint contact = locate_on_surface(block(), {0, 0.05});
    Eigen::VectorXd theta = example_theta(block());
    const int corner = node_at(block(), Eigen::Vector2d(0.1, 0.1));
    for (int s = 0; s < theta.size(); ++s)
        if (block().springs(s, 0) == corner || block().springs(s, 1) == corner) theta[s] = 0;
    CHECK(solve_equilibrium(block(), *law, theta, contact, push).status == EquilibriumStatus::zero_energy_modes);
    theta = -example_theta(block());
    CHECK(solve_equilibrium(block(), *law, theta, contact, push).status == EquilibriumStatus::unstable_at_rest);
}

TEST_CASE("a contact on the fixed edge has no equilibrium and the reason names the edge") {
    const auto state = solve_equilibrium(block(), *make_spring_law("axial"), example_theta(block()),
                                         locate_on_surface(block(), {0.05, 0}), push);
    CHECK(state.status == EquilibriumStatus::contact_fixed);
    CHECK_THAT(reason_of(state.status), Contains("fixed edge"));
}

TEST_CASE("a mesh that only the contact stabilises has the constrained energy minimum as equilibrium") {
    // A corner node on one axial spring has a zero-energy mode; on a spring of negative stiffness it is unstable. Its
    // weight in the contact is 3/4.
    const int corner = node_at(block(), Eigen::Vector2d(0.1, 0.1)), left = node_at(block(), Eigen::Vector2d(0.1 * 5 / 6, 0.1));
    const SurfacePoint contact{{left, corner}, {0.25, 0.75}};
    for (const auto& [law, stiffness] : {std::pair("axial", 0.5), std::pair("axial", -0.05), std::pair("isotropic", -0.05)}) {
        INFO(law << " " << stiffness);
        Eigen::VectorXd theta = example_theta(block());
        for (int s = 0; s < theta.size(); ++s)
            if (block().springs(s, 0) == corner || block().springs(s, 1) == corner)
                theta[s] = block().springs(s, 0) == left || block().springs(s, 1) == left ? stiffness : 0;
        const auto spring_law = make_spring_law(law);
        const Equilibrium state = solve_equilibrium(block(), *spring_law, theta, contact, push);
        REQUIRE(state.status == EquilibriumStatus::balanced);

        // reference: the dense saddle-point system K u - W r = 0, W'u = push, u = 0 at fixed nodes
        const Eigen::Index n = 2 * block().node_count(), fixed = 2 * static_cast<Eigen::Index>(block().fixed.size());
        Eigen::MatrixXd saddle = Eigen::MatrixXd::Zero(n + 2 + fixed, n + 2 + fixed);
        saddle.topLeftCorner(n, n) = spring_law->stiffness(block(), theta, NodeField::Zero(n / 2, 2));
        Eigen::Index row = n;
        for (int d : {0, 1}) {
            for (int end : {0, 1}) saddle(row + d, 2 * contact.node[end] + d) = contact.weight[end];
        }
        row += 2;
        for (int node : block().fixed)
            for (int d : {0, 1}) saddle(row++, 2 * node + d) = 1;
        saddle.topRightCorner(n, 2 + fixed) = -saddle.bottomLeftCorner(2 + fixed, n).transpose();
        Eigen::VectorXd right = Eigen::VectorXd::Zero(saddle.rows());
        right[n] = push[0];
        right[n + 1] = push[1];
        const Eigen::VectorXd dense = saddle.fullPivLu().solve(right);
        CHECK(as_vector(state.displacement).isApprox(dense.head(n), tolerance::solve));
        CHECK((state.contact_force - dense.segment(n, 2)).norm() <= tolerance::solve * 0.05 * push.norm());

        // contact_sensitivity: the same system with a force residual
        const auto G = contact_sensitivity(block(), *spring_law, theta, contact, state.displacement);
        REQUIRE(G);
        right.setZero();
        right.head(n) = -as_vector(scattered(block(), 1e-3));
        const Eigen::VectorXd change = saddle.fullPivLu().solve(right);
        CHECK((*G * -right.head(n) - change.segment(n, 2)).norm() <= tolerance::solve * change.norm());
    }
}

TEST_CASE("a shallow arch snapped through by a strut of prescribed displacement has its one equilibrium") {
    // two inclined springs, 10 mm high over 40 mm each; a vertical spring on their joint, with the contact at its top
    SpringMesh arch;
    arch.nodes.resize(4, 2);
    arch.nodes << -0.04, 0, 0.04, 0, 0, 0.01, 0, 0.05;
    arch.springs.resize(3, 2);
    arch.springs << 0, 2, 1, 2, 2, 3;
    arch.fixed = {0, 1};
    const Eigen::Vector3d theta(10, 10, 2);
    const SurfacePoint top{{3, 2}, {1, 0}};
    const double span = 0.04, length = std::hypot(span, 0.01);
    const auto arch_force = [&](double height) {  // upward force that keeps the crown at this height
        const double now = std::hypot(span, height);
        return 2 * theta[0] * (now - length) * height / now;
    };
    const auto law = make_spring_law("geometric");
    for (double depth : {0.002, 0.006, 0.010, 0.014, 0.022}) {
        INFO(depth);
        // bounds of the crown's height; the strut's stiffness exceeds the arch's negative one, so there is one root
        double low = -0.05, high = 0.05;
        for (int k = 0; k < 100; ++k) {
            const double crown = (low + high) / 2, strut = theta[2] * ((0.05 - depth - crown) - 0.04);
            (arch_force(crown) - strut > 0 ? high : low) = crown;
        }
        const Equilibrium state = solve_equilibrium(arch, *law, theta, top, Eigen::Vector2d(0, -depth));
        REQUIRE(state.status == EquilibriumStatus::balanced);
        CHECK(state.displacement(2, 1) == Approx(low - 0.01).epsilon(tolerance::newton));
        CHECK(state.contact_force.y() == Approx(arch_force(low)).epsilon(tolerance::newton).margin(1e-12));
        CHECK(std::abs(state.contact_force.x()) <= tolerance::newton);
    }
}

TEST_CASE("geometric springs indented deep beside a corner rest at an energy minimum with the contact fixed") {
    for (const Eigen::Vector2d& d : {Eigen::Vector2d(-0.012, -0.020), Eigen::Vector2d(0.006, -0.022)}) {
        const Eigen::Vector2d at(0.09, 0.1);
        const SurfacePoint p = locate_on_surface(block(), at);
        const Equilibrium state = rest("geometric", at, d);
        const double least = geometric_energy(state.displacement);
        for (int k = 0; k < 200; ++k) {
            NodeField v = scattered(block(), 1e-5);  // the same pattern, moved to other nodes
            for (int i = 0; i < v.rows(); ++i) v.row(i) = (i * (k + 3)) % 7 < 3 ? Eigen::RowVector2d(v.row((i + k) % v.rows())) : Eigen::RowVector2d(0, 0);
            for (int node : block().fixed) v.row(node).setZero();
            v.row(p.node[0]) = -p.weight[1] / p.weight[0] * v.row(p.node[1]);
            if (v.norm() > 0) CHECK(geometric_energy(state.displacement + v) > least);
        }
    }
}

TEST_CASE("geometric springs under extreme displacement have a balanced equilibrium or a status with a reason") {
    const auto state = solve_equilibrium(block(), *make_spring_law("geometric"), example_theta(block()),
                                         locate_on_surface(block(), {0, 0.05}), Eigen::Vector2d(0.3, 0));
    if (state) {
        const NodeField f = nodal_force("geometric", state.displacement);
        Eigen::RowVector2d support = Eigen::RowVector2d::Zero();
        for (int node : block().fixed) support += f.row(node);
        CHECK((state.contact_force.transpose() + support).norm() <= tolerance::newton * support.norm());
    } else {
        CHECK_FALSE(reason_of(state.status).empty());
    }
}
