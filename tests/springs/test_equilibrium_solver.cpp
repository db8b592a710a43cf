#include "springs/equilibrium_solver.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "error.h"
#include "springs/energy_model_terms.h"
#include "../example.h"
#include "../mesh/disc.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// Incompressible tissue, a block of 10 x 10 cells unless given. Its constants vary by up to 20 %.
struct Tissue {
    explicit Tissue(SpringMesh m = make_lattice("grid8", 10, 10, 0.1, 0.1)) : mesh(std::move(m)), energy(mesh, true), surface(mesh) {
        constants = energy_model_heuristic(mesh, 450, "plane-strain", 12).constants;
        for (Eigen::Index i = 0; i < constants.size(); ++i) constants[i] *= 1 + 0.2 * std::sin(static_cast<double>(i));
    }
    PatchSpring contact(double arc_m, const PatchStiffness& k = {3600, 1700, 400, 300}) const { return {surface.at(arc_m), k}; }
    double total_energy(const PatchSpring& contact, const Eigen::Vector2d& push_m, const NodeField& u) const {
        Eigen::Vector2d at[ContactPatch::size];
        gather(contact.patch, u, at);
        return energy.energy(constants, u) + contact.load(push_m, at).energy_J;
    }

    SpringMesh mesh;
    TissueEnergy energy;
    ContactSurface surface;
    Eigen::VectorXd constants;
};

const Tissue& block() {
    static const Tissue tissue;
    return tissue;
}

}  // namespace

TEST_CASE("indented tissue rests at an energy minimum: displacing free nodes increases the energy") {
    EquilibriumSolver solver(block().energy, block().surface);
    const PatchSpring contact = block().contact(0.047);
    const Eigen::Vector2d push(-0.008, 0.003);
    const EquilibriumState state = solver.indent(block().constants, contact, push);
    REQUIRE(state.status == SolverStatus::converged);
    CHECK(state.energy_J == Approx(block().total_energy(contact, push, state.displacement)).epsilon(tolerance::rounding));
    for (double size : {1e-5, 1e-3}) {
        NodeField other = state.displacement + scattered(block().mesh, size);
        for (int node : block().mesh.fixed) other.row(node).setZero();
        CHECK(block().total_energy(contact, push, other) > state.energy_J);
    }
    for (int node : block().mesh.fixed) CHECK(state.displacement.row(node).norm() == 0);
}

TEST_CASE("the contact force is the derivative of the stored energy by the tool displacement") {
    EquilibriumSolver solver(block().energy, block().surface);
    for (double arc : {0.047, 0.1, 0.152}) {
        const PatchSpring contact = block().contact(arc);
        const Eigen::Vector2d push = 0.008 * block().surface.outline().direction(arc, 0.4);
        const EquilibriumState state = solver.indent(block().constants, contact, push);
        const double h = 1e-5;
        for (int axis : {0, 1}) {
            const Eigen::Vector2d e = h * Eigen::Vector2d::Unit(axis);
            const double slope = (solver.indent(block().constants, contact, push + e).energy_J -
                                  solver.indent(block().constants, contact, push - e).energy_J) / (2 * h);
            CHECK(slope == Approx(state.contact_force_N[axis]).epsilon(tolerance::difference).margin(tolerance::difference * state.contact_force_N.norm()));
        }
    }
}

TEST_CASE("the net work over a closed path of the tool is zero") {
    EquilibriumSolver solver(block().energy, block().surface);
    const PatchSpring contact = block().contact(0.13);
    const auto work = [&](int steps) {
        double sum = 0, stored = 0;
        EquilibriumState state = solver.indent(block().constants, contact, Eigen::Vector2d(0.0025, -0.007));
        for (int i = 1; i <= steps; ++i) {
            const double angle = 2 * std::acos(-1.0) * i / steps;
            const EquilibriumState before = state;
            state = solver.indent(block().constants, contact, Eigen::Vector2d(0.0025 * std::cos(angle), -0.007 + 0.0025 * std::sin(angle)), &before);
            sum += (state.contact_force_N + before.contact_force_N).dot(state.push_m - before.push_m) / 2;
            stored = std::max(stored, state.energy_J);
        }
        return std::abs(sum) / stored;
    };
    CHECK(work(64) <= tolerance::newton);  // the trapezoidal rule converges fast on a smooth closed path
    CHECK(work(256) <= tolerance::newton);
}

TEST_CASE("the equilibrium does not depend on the path of the tool") {
    EquilibriumSolver solver(block().energy, block().surface);
    const PatchSpring contact = block().contact(0.192);
    const Eigen::Vector2d push(-0.004, -0.009);
    const EquilibriumState straight = solver.indent(block().constants, contact, push);
    const EquilibriumState aside = solver.indent(block().constants, contact, Eigen::Vector2d(0.005, -0.002));
    const EquilibriumState round = solver.indent(block().constants, contact, push, &aside);
    CHECK((straight.displacement - round.displacement).norm() <= tolerance::newton * straight.displacement.norm());
    CHECK((straight.contact_force_N - round.contact_force_N).norm() <= tolerance::newton * straight.contact_force_N.norm());
    const EquilibriumState back = solver.indent(block().constants, contact, Eigen::Vector2d(0, 0), &straight);
    CHECK(back.status == SolverStatus::converged);
    CHECK(back.displacement.norm() <= tolerance::newton * straight.displacement.norm());
}

TEST_CASE("a mirrored indentation of a symmetric block has the mirrored force and the same energy") {
    Tissue even;
    even.constants = energy_model_heuristic(even.mesh, 450, "plane-strain", 12).constants;
    EquilibriumSolver solver(even.energy, even.surface);
    const EquilibriumState one = solver.indent(even.constants, even.contact(0.043), Eigen::Vector2d(-0.007, 0.002));
    const EquilibriumState other = solver.indent(even.constants, even.contact(0.3 - 0.043), Eigen::Vector2d(0.007, 0.002));
    CHECK(one.contact_force_N.x() == Approx(-other.contact_force_N.x()).epsilon(tolerance::newton));
    CHECK(one.contact_force_N.y() == Approx(other.contact_force_N.y()).epsilon(tolerance::newton));
    CHECK(one.energy_J == Approx(other.energy_J).epsilon(tolerance::newton));
}

TEST_CASE("implicit derivatives of force and displacement by constants and contact stiffness agree with differences") {
    for (const Tissue& tissue : {Tissue(), Tissue(edge_mesh(disc(16)))}) {
        EquilibriumSolver solver(tissue.energy, tissue.surface, {0.25, 1e-3, 15, 1e-12});
        const PatchStiffness k{3600, 1700, 400, 300};
        const double arc = 0.38 * tissue.surface.outline().length();
        const Eigen::Vector2d push = 0.006 * tissue.surface.outline().direction(arc, 0.3);
        // two directions in the constants, four stiffnesses
        Eigen::MatrixXd constants_by = Eigen::MatrixXd::Zero(tissue.constants.size(), 6), stiffness_by = Eigen::MatrixXd::Zero(4, 6);
        for (Eigen::Index e = 0; e < tissue.constants.size(); ++e)
            constants_by.row(e) << tissue.constants[e] * std::cos(3.0 * static_cast<double>(e)), tissue.constants[e] * (e % 3 == 0), 0, 0, 0, 0;
        stiffness_by.diagonal(2) << k.normal, k.tangent, k.rotation, k.stretch;
        solver.indent(tissue.constants, tissue.contact(arc, k), push);
        const EquilibriumDerivative by = solver.derivative(constants_by, stiffness_by);
        const double h = 1e-4;
        for (Eigen::Index p = 0; p < 6; ++p) {
            const auto at = [&](double step) {
                const Eigen::Vector4d dk = step * stiffness_by.col(p);
                return solver.indent(tissue.constants + step * constants_by.col(p),
                                    tissue.contact(arc, {k.normal + dk[0], k.tangent + dk[1], k.rotation + dk[2], k.stretch + dk[3]}), push);
            };
            // fourth order: exact to the solver's own rounding
            const EquilibriumState a = at(h), b = at(-h), c = at(2 * h), d = at(-2 * h);
            const Eigen::Vector2d force = (8 * (a.contact_force_N - b.contact_force_N) - (c.contact_force_N - d.contact_force_N)) / (12 * h);
            const NodeField shape = (8 * (a.displacement - b.displacement) - (c.displacement - d.displacement)) / (12 * h);
            CHECK((force - by.contact_force.col(p)).norm() <= tolerance::difference * by.contact_force.col(p).norm());
            CHECK((as_vector(shape) - by.displacement.col(p)).norm() <= tolerance::difference * by.displacement.col(p).norm());
        }
    }
}

TEST_CASE("an indentation without equilibrium has status lost and returns the displacement reached") {
    EquilibriumSolver solver(block().energy, block().surface, {0.25, 1e-2, 15, 1e-10});
    const EquilibriumState state = solver.indent(block().constants, block().contact(0.15), Eigen::Vector2d(0, -0.4));  // four times the block's height
    CHECK(state.status == SolverStatus::no_equilibrium);
    CHECK(state.push_m.norm() < 0.4);
    CHECK(state.displacement.allFinite());
    CHECK(std::string(to_string(state.status)) == "lost");
}

TEST_CASE("a displacement of 1e5 node spacings ends within the limit on Newton iterations") {
    constexpr int steps = 2, iterations = 15;
    EquilibriumSolver solver(block().energy, block().surface, {0.25, 1.0 / steps, iterations, 1e-10});
    const EquilibriumState state = solver.indent(block().constants, block().contact(0.15), Eigen::Vector2d(0, 1e3));
    CHECK(state.newton <= steps * iterations);
    CHECK(state.displacement.allFinite());
}

TEST_CASE("tissue with almost no shear stiffness has no equilibrium under indentation from above") {
    Tissue column(make_lattice("grid8", 10, 10, 0.1, 0.1));
    // cells only keep their area, so shear has almost no stiffness
    column.constants.head(column.mesh.spring_count()) *= 1e-6;
    for (int s = 0; s < column.mesh.spring_count(); ++s)
        if (column.mesh.nodes(column.mesh.springs(s, 0), 0) == column.mesh.nodes(column.mesh.springs(s, 1), 0)) column.constants[s] = 400;
    EquilibriumSolver solver(column.energy, column.surface);
    const EquilibriumState state = solver.indent(column.constants, column.contact(0.15), Eigen::Vector2d(0, -0.002));
    CHECK(state.status == SolverStatus::no_equilibrium);
}

TEST_CASE("an indentation that inverts a cell ends with status inside_out instead of held") {
    for (const SpringMesh& mesh : {make_lattice("grid8", 10, 10, 0.1, 0.1), edge_mesh(disc(16))}) {
        const EnergyModelHeuristic soft = energy_model_heuristic(mesh, 450, "plane-stress", 12);  // compressible cells
        const TissueEnergy energy(mesh, soft.incompressible);
        const ContactSurface surface(mesh);
        EquilibriumSolver solver(energy, surface);
        const double arc = 0.1 * surface.outline().length();
        const ContactPatch patch = surface.at(arc);
        const auto pressed = [&](double depth_m) {
            return solver.indent(soft.constants, PatchSpring(patch, soft.patch.at(patch)), depth_m * surface.outline().direction(arc, 0.9));
        };
        const EquilibriumState shallow = pressed(0.01), deep = pressed(0.03);
        CHECK(shallow.status == SolverStatus::converged);
        CHECK(energy.smallest_ratio(shallow.displacement) > 0);
        CHECK(deep.status == SolverStatus::inverted);
        CHECK(energy.smallest_ratio(deep.displacement) <= 0);
        CHECK(deep.push_m.norm() == Approx(0.03));
        CHECK(std::string(to_string(deep.status)) == "inside_out");
    }
}

TEST_CASE("a contact whose nodes are all fixed is refused") {
    SpringMesh mesh = make_lattice("grid8", 10, 10, 0.1, 0.1);
    const ContactSurface surface(mesh);
    mesh.fixed.clear();
    for (int node = 0; node < mesh.node_count(); ++node) mesh.fixed.push_back(node);
    const TissueEnergy energy(mesh, false);
    EquilibriumSolver solver(energy, surface);
    CHECK_THAT(refusal<MismatchError>([&] { solver.indent(Eigen::VectorXd::Ones(energy.constant_count()), PatchSpring(surface.at(0.1), {1, 1, 1, 1}), Eigen::Vector2d(0.001, 0)); }),
               Contains("fixed edge"));
}
