#include <catch2/catch.hpp>
#include <cmath>

#include "../mesh/embedded_block.h"
#include "../refusal.h"
#include "../solid_model_example.h"
#include "../tolerances.h"
#include "mesh/topology.h"
#include "springs/contact_errors.h"
#include "springs/energy_model_kernel.h"
#include "springs/indentation_solver.h"
#include "springs/equilibrium_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// A homogeneous block of 240 x 80 x 40 mm in cubes of 10 mm, under discs of 7 mm.
const TissueModel& block() {
    static const TissueModel model = [] {
        TissueModel m = solid_model_example(embedded_block(Lattice{{24, 8, 4}, {0.24, 0.08, 0.04}}));
        for (Eigen::Index e = 0; e < m.energy_model->constants.size(); ++e) m.energy_model->constants[e] /= 1 + 0.3 * std::sin(1.7 * static_cast<double>(e));
        return m;
    }();
    return model;
}

Point place(double x, double y) { return Eigen::Vector3d(x, y, 0.04); }

/// The solver, for energies and derivatives.
struct Pressed {
    Pressed() : law(*block().energy_model), energy(block().mesh, law), kernel(make_contact_kernel(block().mesh, law)), solver(energy, *kernel) {}
    EquilibriumState at(const std::vector<ToolPush>& tools, const EquilibriumState* from = nullptr) {
        std::vector<DisplacedTool> pressed;
        for (const ToolPush& tool : tools) pressed.push_back({ContactSpring(kernel->rows_at(tool.contact_m), law.patch), tool.push_m});
        return solver.indent(law.constants, pressed, from);
    }

    EnergyModel law;
    TissueEnergy energy;
    std::unique_ptr<ContactKernel> kernel;
    EquilibriumSolver solver;
};

/// Two tools 25 mm apart, displaced in different directions.
std::vector<ToolPush> two() {
    return {{place(0.105, 0.042), Eigen::Vector3d(1e-3, -5e-4, -6e-3)}, {place(0.128, 0.033), Eigen::Vector3d(-5e-4, 2e-3, -4e-3)}};
}

}  // namespace

TEST_CASE("two distant tools have the forces of single tools and two near tools have smaller forces", "[solid][two_tools]") {
    const IndentationSolver solver(block());
    const Point down = Eigen::Vector3d(0, 0, -0.006), aside = Eigen::Vector3d(0.002, 0.001, -0.004);
    const ToolPush first{place(0.043, 0.041), down}, far{place(0.203, 0.038), aside}, near{place(0.061, 0.038), down};
    const Eigen::VectorXd alone = solver.at(first.contact_m, first.push_m).contact_force, far_alone = solver.at(far.contact_m, far.push_m).contact_force;
    const ToolsEquilibrium apart = solver.at({first, far});
    REQUIRE(apart);
    constexpr double felt = 5e-3;  // effect of a tool four block heights away: measured 2e-3
    CHECK((apart.contact_force[0] - alone).norm() < felt * alone.norm());
    CHECK((apart.contact_force[1] - far_alone).norm() < felt * far_alone.norm());
    const ToolsEquilibrium together = solver.at({first, near});
    REQUIRE(together);
    CHECK(together.contact_force[0].norm() < 0.97 * alone.norm());
    CHECK(together.contact_force[1].norm() < 0.97 * solver.at(near.contact_m, near.push_m).contact_force.norm());
}

TEST_CASE("a list of one tool gives the single tool's result bit by bit; the order of two has no effect", "[solid][two_tools]") {
    const IndentationSolver solver(block());
    const std::vector<ToolPush> tools = two();
    const Equilibrium one = solver.at(tools[0].contact_m, tools[0].push_m);
    const ToolsEquilibrium list = solver.at({tools[0]});
    CHECK(list.displacement == one.displacement);
    REQUIRE(list.contact_force.size() == 1);
    CHECK(list.contact_force[0] == one.contact_force);
    const ToolsEquilibrium there = solver.at(tools), back = solver.at({tools[1], tools[0]});
    REQUIRE(there);
    for (std::size_t t : {0, 1}) CHECK((there.contact_force[t] - back.contact_force[1 - t]).norm() < tolerance::newton * there.contact_force[t].norm());
    CHECK((there.displacement - back.displacement).norm() < tolerance::newton * there.displacement.norm());
}

TEST_CASE("the force of each of two tools is the derivative of the stored energy by its displacement", "[solid][two_tools]") {
    Pressed pressed;
    const std::vector<ToolPush> tools = two();
    const EquilibriumState state = pressed.at(tools);
    REQUIRE(state.status == SolverStatus::converged);
    REQUIRE(state.others.size() == 1);
    const Point force_N[] = {state.contact_force_N, state.others[0].contact_force_N};
    const double h = 1e-5;
    for (std::size_t t : {0, 1})
        for (int axis : {0, 1, 2}) {
            std::vector<ToolPush> more = tools, less = tools;
            more[t].push_m[axis] += h;
            less[t].push_m[axis] -= h;
            const double slope = (pressed.at(more, &state).energy_J - pressed.at(less, &state).energy_J) / (2 * h);
            CHECK(slope == Approx(force_N[t][axis]).epsilon(tolerance::difference).margin(tolerance::difference * force_N[t].norm()));
        }
}

TEST_CASE("support forces balance the forces of both tools on the tissue", "[solid][two_tools]") {
    Pressed pressed;
    const EquilibriumState state = pressed.at(two());
    REQUIRE(state.status == SolverStatus::converged);
    Eigen::VectorXd supports = Eigen::VectorXd::Zero(pressed.energy.constant_count());
    const auto held = static_cast<Eigen::Index>(block().mesh.fixed.size());
    supports.tail(held) = pressed.law.constants.tail(held);
    const Point carried_N = pressed.energy.force(supports, state.displacement).colwise().sum().transpose();
    // under a tapered disc the tissue bears more than the force conjugate to the tool displacement
    Point taken_N = Point::Zero(3);
    const std::vector<ToolPush> tools = two();
    for (const ToolPush& tool : tools) {
        const ContactSpring contact(pressed.kernel->rows_at(tool.contact_m), pressed.law.patch);
        const Eigen::VectorXd node_N = contact.load(tool.push_m, contact.gather(state.displacement)).node_N;
        for (Eigen::Index k = 0; k < node_N.size(); ++k) taken_N[k % 3] -= node_N[k];
    }
    CHECK((carried_N - taken_N).norm() < tolerance::newton * taken_N.norm());
    const Point pushed_N = state.contact_force_N + state.others[0].contact_force_N;
    CHECK(taken_N.norm() == Approx(1.25 * pushed_N.norm()).epsilon(0.01));
    CHECK(pushed_N.norm() > 1.2 * state.contact_force_N.norm());
}

TEST_CASE("two mirrored tools have mirrored forces", "[solid][two_tools]") {
    const IndentationSolver solver(block());
    const ToolsEquilibrium rest = solver.at({{place(0.108, 0.04), Eigen::Vector3d(1e-3, 0, -5e-3)}, {place(0.132, 0.04), Eigen::Vector3d(-1e-3, 0, -5e-3)}});
    REQUIRE(rest);
    constexpr double mirrored = 1e-5;  // the 60 points of a contact are not mirror-symmetric: measured 1e-6
    const Eigen::Vector3d left = rest.contact_force[0], right = rest.contact_force[1];
    CHECK((left - Eigen::Vector3d(-right.x(), right.y(), right.z())).norm() < mirrored * left.norm());
    CHECK(std::abs(left.y()) < mirrored * left.norm());
}

TEST_CASE("two tools reach the same equilibrium from that of the first one as from rest", "[solid][two_tools]") {
    Pressed pressed;
    const std::vector<ToolPush> tools = two();
    const EquilibriumState rest = pressed.at(tools), one = pressed.at({tools[0]}), later = pressed.at(tools, &one);
    CHECK(one.others.empty());
    CHECK(later.status == SolverStatus::converged);
    CHECK((later.displacement - rest.displacement).norm() < tolerance::newton * rest.displacement.norm());
    CHECK((later.others[0].contact_force_N - rest.others[0].contact_force_N).norm() < tolerance::newton * rest.others[0].contact_force_N.norm());
    CHECK(later.others[0].push_m == tools[1].push_m);
}

TEST_CASE("tools closer than two radii and an empty list and derivatives with two tools are refused", "[solid][two_tools]") {
    const IndentationSolver solver(block());
    const Point down = Eigen::Vector3d(0, 0, -0.003);
    const ToolPush first{place(0.1, 0.04), down};
    CHECK_THAT(refusal<OverlappingToolsError>([&] { solver.at({first, {place(0.1139, 0.04), down}}); }), Contains("two discs are 13.9 mm apart, nearer than two radii of 7 mm"));
    CHECK(solver.at({first, {place(0.114, 0.04), down}}));
    const Point towards = Eigen::Vector3d(-0.002, 0, -0.003);
    CHECK_THAT(refusal<OverlappingToolsError>([&] { solver.at({first, {place(0.115, 0.04), towards}}); }), Contains("13 mm apart under the indentation"));
    CHECK_THAT(refusal<OverlappingToolsError>([&] { solver.at({first, {place(0.15, 0.04), down}, {place(0.155, 0.04), down}}); }), Contains("5 mm apart"));
    CHECK_THAT(refusal<MismatchError>([&] { solver.at(std::vector<ToolPush>{}); }), Contains("at least one tool"));

    Pressed pressed;
    pressed.at(two());
    CHECK_THAT(refusal<MismatchError>([&] { pressed.solver.force_derivative(); }), Contains("for one tool only"));
    CHECK_THAT(refusal<MismatchError>([&] { pressed.solver.derivative({}, {}); }), Contains("for one tool only"));
    pressed.at({first});
    CHECK(pressed.solver.force_derivative().by_constant.norm() > 0);
}
