#include "springs/branch_memory.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "../allocations.h"
#include "../haptic/haptic_example.h"
#include "error.h"
#include "springs/tool_spring.h"

using namespace tissue;

namespace {

const Eigen::Vector3d tau(0.05, 1, 10), g(0.30, 0.25, 0.20);

/// s of one branch at time t, from the differential equation. Up to `rise` x increases linearly, then it is constant.
double ramp_held(double x, double rise, double t, double tau_s) {
    return x / rise * tau_s * (1 - std::exp(-rise / tau_s)) * std::exp(-(t - rise) / tau_s);
}

}  // namespace

TEST_CASE("a Maxwell branch is exact for any step length where the measure changes linearly", "[memory]") {
    for (double dt : {0.001, 0.1, 0.5})
        for (int branches : {1, 2, 3, 5}) {
            Eigen::VectorXd times(branches), shares(branches);
            for (int k = 0; k < branches; ++k) {
                times[k] = 0.03 * std::pow(7.0, k);
                shares[k] = 0.8 / branches;
            }
            BranchMemory memory(times, shares.transpose().replicate(300, 1), dt);
            Eigen::VectorXd x(7), y(7);
            const double rise = 0.5;
            for (int n = 1; n * dt < 2.001; ++n) {
                x.setConstant(0.01 * std::min(1.0, n * dt / rise));
                memory.step(13, 7, x.data(), y.data());
            }
            double expected = 0.01 * (1 - shares.sum());
            for (int k = 0; k < branches; ++k) expected += shares[k] * ramp_held(0.01, rise, 2, times[k]);
            INFO("dt " << dt << ", " << branches << " Maxwell branches");
            CHECK(y[0] == Approx(expected).epsilon(1e-12));
            CHECK(y[6] == y[0]);
        }
}

TEST_CASE("each element relaxes by its own relative moduli and equal elements relax equally", "[memory]") {
    Eigen::MatrixXd own(40, 3), same(40, 3);
    for (int i = 0; i < 40; ++i) {
        same.row(i) = g.transpose();
        own.row(i) = g.transpose() * (i == 17 ? 0.3 : 1);
    }
    BranchMemory alike(tau, same, 0.001), different(tau, own, 0.001);
    Draw draw(3);
    Eigen::VectorXd x(40), y(40), z(40);
    for (int n = 0; n < 500; ++n) {
        for (int i = 0; i < 40; ++i) x[i] = draw(-1, 1);
        alike.step(0, 40, x.data(), y.data());
        different.step(0, 40, x.data(), z.data());
    }
    for (int i = 0; i < 40; ++i)
        if (i != 17) CHECK(z[i] == Approx(y[i]).epsilon(1e-13));
    CHECK(std::abs(z[17] - y[17]) > 1e-3);
    CHECK(z[17] == Approx(x[17] * 0.7 + 0.3 * y[17]).epsilon(1e-12));
}

TEST_CASE("one element with three Maxwell branches relaxes as each of five equal elements", "[memory]") {
    BranchMemory alone(tau, g.transpose(), 0.01), many(tau, g.transpose().replicate(5, 1), 0.01);
    for (int n = 0; n < 200; ++n) {
        const double x = std::sin(0.1 * n);
        Eigen::VectorXd five = Eigen::VectorXd::Constant(5, x), y(5);
        double own = 0;
        alone.step(0, 1, &x, &own);
        many.step(0, 5, five.data(), y.data());
        CHECK(own == Approx(y[3]).margin(1e-15));
    }
}

TEST_CASE("an element with a Maxwell branch is passive at any ratio of step to relaxation time", "[memory]") {
    for (double ratio : {1e-6, 1e-3, 0.1, 1.0, 3.0, 30.0, 1e3}) {
        const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
        const Eigen::MatrixXd share = Eigen::MatrixXd::Constant(1, 1, 0.9);
        BranchMemory memory(one, share, ratio);
        Draw draw(11);
        double before = 0, x = 0, worst = 0, size = 0;
        for (int n = 0; n < 20000; ++n) {
            const double next = draw.below(5) ? draw(-1, 1) : x;
            double y = 0;
            memory.step(0, 1, &next, &y);
            const double stored = memory.stored(0) / 2;
            worst = std::max(worst, stored - before - y * (next - x));
            size = std::max(size, stored);
            before = stored;
            x = next;
        }
        INFO("dt / tau " << ratio);
        CHECK(worst <= 1e-12 * size);
    }
}

TEST_CASE("recording dissipated energy leaves forces unchanged; work equals stored plus dissipated energy", "[memory]") {
    for (int branches : {1, 3, 4}) {
        Eigen::VectorXd times(branches), shares(branches);
        for (int k = 0; k < branches; ++k) {
            times[k] = 0.01 * std::pow(9.0, k);
            shares[k] = 0.15 + 0.02 * k;
        }
        BranchMemory plain(times, shares.transpose().replicate(20, 1), 0.002), booked = plain;
        booked.book();
        CHECK(booked.booked());
        Draw draw(17);
        Eigen::VectorXd x = Eigen::VectorXd::Zero(20), y(20), z(20), work = Eigen::VectorXd::Zero(20), dissipated = work;
        for (int n = 0; n < 3000; ++n) {
            Eigen::VectorXd next = x;
            for (int i = 0; i < 20; ++i) next[i] += draw(-0.1, 0.1);
            plain.step(0, 20, next.data(), y.data());
            booked.step(0, 20, next.data(), z.data());
            REQUIRE((y - z).cwiseAbs().maxCoeff() <= 1e-13);
            work += (z - (1 - shares.sum()) * next).cwiseProduct(next - x);
            x = next;
            for (int i = 0; i < 20; ++i) {
                CHECK(booked.branches_dissipated(i) >= dissipated[i]);
                dissipated[i] = booked.branches_dissipated(i);
            }
        }
        for (int i = 0; i < 20; ++i) CHECK(booked.branches_stored(i) + booked.branches_dissipated(i) == Approx(work[i]).epsilon(1e-10));
        booked.forget();
        CHECK(booked.branches_stored(3) == 0);
        CHECK(booked.branches_dissipated(3) == dissipated[3]);
        CHECK(plain.branches_dissipated(3) == 0);
    }
}

TEST_CASE("forget restores the state of rest and a step allocates nothing", "[memory]") {
    BranchMemory memory(tau, g.transpose().replicate(256, 1), 0.001);
    Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(256, -1, 1), first(256), again(256);
    memory.step(0, 256, x.data(), first.data());
    long allocations = 0;
    {
        const Allocations none;
        memory.step(0, 256, x.data(), again.data());
        memory.forget();
        memory.step(0, 256, x.data(), again.data());
        allocations = Allocations::count();
    }
    CHECK(again == first);
    CHECK(allocations == 0);
}

TEST_CASE("invalid relative moduli or relaxation times or step lengths are refused", "[memory]") {
    CHECK_THROWS_AS(BranchMemory(tau, Eigen::MatrixXd::Constant(2, 2, 0.1), 0.001), MismatchError);
    CHECK_THROWS_AS(BranchMemory(tau, Eigen::MatrixXd::Constant(2, 3, 0.34), 0.001), MismatchError);
    CHECK_THROWS_AS(BranchMemory(tau, Eigen::MatrixXd::Constant(2, 3, -0.1), 0.001), MismatchError);
    CHECK_THROWS_AS(BranchMemory(-tau, Eigen::MatrixXd::Constant(2, 3, 0.1), 0.001), MismatchError);
    CHECK_THROWS_AS(BranchMemory(tau, Eigen::MatrixXd::Constant(2, 3, 0.1), 0), MismatchError);
    CHECK_THROWS_AS(ToolMemory(Eigen::VectorXd::Constant(9, 1.0), Eigen::VectorXd::Constant(9, 0.1), 0.001), MismatchError);
    // the largest number of branches
    CHECK_NOTHROW(std::make_unique<ToolMemory>(Eigen::VectorXd::Constant(8, 1.0), Eigen::VectorXd::Constant(8, 0.1), 0.001));
}

namespace {

/// A contact of one node. Its normal and its tangential stiffness increase with the normal displacement.
ToolSpring hardening_contact() {
    ToolSpring tool;
    tool.begin(3, Eigen::Vector3d(0, 0, -1));
    tool.add_group(Eigen::Matrix3d::Identity(), Eigen::Vector3d(20, 20, 50).asDiagonal());
    tool.add_node(0, 1);
    tool.harden(150, 100, 0);
    return tool;
}

}  // namespace

TEST_CASE("a contact that hardens and relaxes is passive at any step length", "[memory]") {
    const ToolSpring tool = hardening_contact();
    const NodeColumns u = NodeColumns::Zero(1, 3);
    for (double dt : {1e-4, 0.01, 0.3, 5.0, 200.0}) {
        ToolMemory memory(tau, g, dt);
        Draw draw(5);
        Eigen::Vector3d x = Eigen::Vector3d::Zero();
        double work = 0, least = 0, most = 0;
        // The work so far is the stored and dissipated energy, never negative. Every seventh step ends at rest.
        for (int n = 0; n < 4000; ++n) {
            const Eigen::Vector3d next = n % 7 == 6 ? Eigen::Vector3d::Zero().eval() : Eigen::Vector3d(draw(-0.01, 0.01), draw(-0.01, 0.01), draw(-0.01, 0.01));
            NodeColumns f = NodeColumns::Zero(1, 3);
            const Eigen::Vector3d hand = tool.put_on(next, u, f, &memory);
            CHECK((f.row(0).transpose() + hand).norm() < 1e-12);
            work += hand.dot(next - x);
            least = std::min(least, work);
            most = std::max(most, work);
            x = next;
        }
        INFO("dt " << dt);
        CHECK(least >= -1e-12);
        CHECK(most > 1e-3);
    }
}

TEST_CASE("a contact relaxes from its instantaneous force by its Maxwell branches to 1 - sum g of it", "[memory]") {
    const ToolSpring tool = hardening_contact();
    const NodeColumns u = NodeColumns::Zero(1, 3);
    NodeColumns f = NodeColumns::Zero(1, 3);
    const Eigen::Vector3d push(0.001, 0.002, -0.009);
    const Eigen::Vector3d now = tool.tool_force_N(push, u);
    ToolMemory quick(tau, g, 1e-9);
    CHECK((Eigen::Vector3d(tool.put_on(push, u, f, &quick)) - now).norm() < 1e-7 * now.norm());
    ToolMemory memory(tau, g, 0.5);
    tool.put_on(push, u, f, &memory);
    for (int n = 2; n <= 20; ++n) tool.remember(push, u, memory);
    double expected = 1 - g.sum();
    for (int k = 0; k < 3; ++k) expected += g[k] * ramp_held(1, 0.5, 10.5, tau[k]);
    CHECK((Eigen::Vector3d(tool.tool_force_N(push, u, &memory)) - expected * now).norm() < 1e-12 * now.norm());
    CHECK(Eigen::Vector3d(tool.push_at(expected * now, u, &memory) - push).norm() < 1e-10);
    for (int n = 0; n < 1000; ++n) tool.remember(push, u, memory);
    CHECK((Eigen::Vector3d(tool.tool_force_N(push, u, &memory)) - (1 - g.sum()) * now).norm() < 1e-12 * now.norm());
    // within a step the force is the derivative of energy_J, and stiffness_N_m that of the force
    const double h = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
        Point up = push, down = push;
        up[axis] += h;
        down[axis] -= h;
        CHECK((tool.energy_J(up, u, &memory) - tool.energy_J(down, u, &memory)) / (2 * h) == Approx(tool.tool_force_N(push, u, &memory)[axis]).epsilon(1e-5).margin(1e-7));
        const Point slope = (tool.tool_force_N(up, u, &memory) - tool.tool_force_N(down, u, &memory)) / (2 * h);
        CHECK((slope - tool.stiffness_N_m(push, u, &memory).col(axis)).norm() < 1e-4 * slope.norm());
    }
}

TEST_CASE("a contact that moves along the surface keeps its groups' branch states; new groups start at rest", "[memory]") {
    const auto contact = [](std::vector<int> imprint) {
        ToolSpring tool;
        tool.begin(3, Eigen::Vector3d(0, 0, -1));
        tool.add_group(Eigen::Matrix3d::Identity(), 10 * Eigen::Matrix3d::Identity());
        tool.add_node(0, 0.5);
        tool.add_node(1, 0.5);
        for (int node : imprint) {
            tool.add_group(Eigen::Matrix3d::Identity(), (1 + node) * Eigen::Matrix3d::Identity());
            tool.add_node(node, 1);
        }
        return tool;
    };
    const ToolSpring disc = contact({2, 3, 4}), on = contact({5, 4, 3}), wall = contact({});
    const NodeColumns u = NodeColumns::Zero(6, 3);
    const Eigen::Vector3d push(0, 0, -0.01);
    ToolMemory memory(tau, g, 0.001);
    for (int n = 0; n < 200; ++n) disc.remember(push, u, memory);
    ToolMemory gone = memory;
    gone.follow(disc, on);
    for (int group = 0; group < 4; ++group) {
        REQUIRE(memory.known_N(group).norm() > 0);
        CHECK(gone.known_N(group) == memory.known_N(group));
    }
    gone.follow(disc, wall);
    gone.follow(wall, on);  // back from a fixed facet
    CHECK(gone.known_N(0) == memory.known_N(0));
    for (int group = 1; group < 4; ++group) CHECK(gone.known_N(group).norm() == 0);
    on.remember(push, u, gone);
    ToolMemory anew(tau, g, 0.001);
    on.remember(push, u, anew);
    CHECK(gone.known_N(1) == anew.known_N(1));
}
