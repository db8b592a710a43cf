// The tick of an energy model that relaxes: per element, instantaneous and long-term, in the plane and in space.
#include <catch2/catch.hpp>
#include <cmath>

#include "../mesh/embedded_block.h"
#include "../allocations.h"
#include "../example.h"
#include "../mesh/disc.h"
#include "../mesh/dome.h"
#include "mesh/embedded_lattice.h"
#include "../solid_model_example.h"
#include "haptic/realtime_energy_model.h"
#include "haptic/simulation.h"
#include "haptic_example.h"
#include "tick_forces.h"
#include "mesh/free_surface.h"
#include "springs/indentation_solver.h"
#include "springs/tissue_energy.h"

using namespace tissue;

namespace {

const Eigen::Vector3d branch_times(0.004, 0.05, 2);

/// Every element with its own constant and relative moduli.
TissueModel unevenly_relaxing(TissueModel model) {
    Relaxation& r = model.energy_model->relaxation;
    const Eigen::Index E = model.energy_model->constants.size();
    r.tau_s = branch_times;
    r.share.resize(E, 3);
    for (Eigen::Index e = 0; e < E; ++e) {
        model.energy_model->constants[e] *= 1 + 0.2 * std::sin(1.3 * static_cast<double>(e));
        for (int k = 0; k < 3; ++k) r.share(e, k) = 0.2 + 0.1 * std::sin(0.7 * static_cast<double>(e) + k);
    }
    r.share.bottomRows(model.mesh.support_count()).setZero();  // supports do not relax
    r.contact_share = Eigen::Vector3d(0.3, 0.2, 0.1);
    return model;
}

/// Lattices and shapes, in the plane and in space.
std::vector<TissueModel> models() {
    std::vector<TissueModel> all;
    for (const SpringMesh& mesh : {make_lattice("grid8", 10, 10, 0.1, 0.1), make_lattice("grid8", 4, 7, 0.06, 0.1), edge_mesh(disc(24))})
        all.push_back(unevenly_relaxing(energy_model_example(mesh)));
    // the models in space have a curve as well
    for (const std::size_t k : {1, 2}) all[k].energy_model->curve = SpringCurve::mooney_rivlin(0.6, 2, 0.9, 1.05);
    for (const SpringMesh& mesh : {embedded_block(Lattice{{5, 6, 2}, {0.05, 0.06, 0.02}}), embedded_lattice(dome(6), 0.011)}) all.push_back(unevenly_relaxing(solid_model_example(mesh)));
    return all;
}

/// Energy of one element per unit of its constant.
double unit_energy(const TissueEnergy& energy, Eigen::Index element, const NodeField& u) {
    std::size_t kind = 0;
    while (element >= energy.first_of(kind) + energy.kinds()[kind]->count()) ++kind;
    return energy.kinds()[kind]->energy(static_cast<int>(element - energy.first_of(kind)), u);
}

}  // namespace

TEST_CASE("the force of each relaxing element follows from its own Maxwell branches and its own strain measure", "[law][memory]") {
    for (const TissueModel& model : models()) {
        const int D = model.mesh.dimension();
        const RealtimeMesh springs = springs_of(model);
        const RealtimeEnergyModel energy_model(model, springs);
        const TissueEnergy energy(model.mesh, *model.energy_model);
        const Eigen::Index E = energy.constant_count();
        const NodeField shape = scattered(model.mesh, 1e-4);
        const double dt = 0.002;
        BranchMemory memory = energy_model.memory(dt);
        CHECK(memory.size() >= E - model.mesh.support_count());
        NodeColumns f(model.mesh.node_count(), D);
        RealtimeEnergyModel::Scratch scratch = energy_model.scratch();
        // The whole field grows and shrinks together, so that x = sqrt(2 energy of the element).
        Eigen::VectorXd before = Eigen::VectorXd::Zero(E);
        Eigen::MatrixXd part = Eigen::MatrixXd::Zero(E, 3);
        NodeField expected;
        double stored = 0;
        for (int n = 1; n <= 12; ++n) {
            const NodeField u = (0.6 + 0.4 * std::sin(0.9 * n)) * shape;
            energy_model.force(NodeColumns(u), f, scratch, memory);
            Eigen::VectorXd scale(E);
            stored = 0;
            for (Eigen::Index e = 0; e < E; ++e) {
                const double x = std::sqrt(2 * std::max(0.0, model.energy_model->constants[e] * unit_energy(energy, e, u)));
                double y = x * (1 - model.energy_model->relaxation.share.row(e).sum()), twice = y * x;
                for (int k = 0; k < 3; ++k) {
                    const double tau = branch_times[k], decay = std::exp(-dt / tau), g = model.energy_model->relaxation.share(e, k);
                    part(e, k) = decay * part(e, k) + (1 - decay) * tau / dt * (x - before[e]);
                    y += g * part(e, k);
                    twice += g * part(e, k) * part(e, k);
                }
                before[e] = x;
                scale[e] = x > 0 ? y / x : 0;
                stored += twice / 2;
            }
            expected = energy.force(model.energy_model->constants.cwiseProduct(scale), u);
        }
        INFO(model.mesh.topology << ", " << E << " elements");
        // a few elements first shrink and then grow
        CHECK((f - NodeColumns(expected)).norm() <= 5e-5 * expected.norm());
        // One step after the state in `memory`, at the same displacement: the stored energy has only relaxed.
        BranchMemory still = memory;
        const double later = energy_model.energy(NodeColumns((0.6 + 0.4 * std::sin(0.9 * 12)) * shape), still);
        CHECK(later < stored * (1 + 1e-9));
        CHECK(later > 0.7 * stored);
        long allocations = 0;
        {
            const NodeColumns columns = shape;
            const Allocations none;
            energy_model.force(columns, f, scratch, memory);
            allocations = Allocations::count();
        }
        CHECK(allocations == 0);
    }
}

TEST_CASE("an energy model that relaxes equals its instantaneous model after 1 ns and its long-term model after 60 s", "[law][memory]") {
    for (const TissueModel& model : models()) {
        const RealtimeMesh springs = springs_of(model);
        const RealtimeEnergyModel energy_model(model, springs);
        TissueModel later = model;
        later.energy_model = long_term(*model.energy_model);
        const RealtimeEnergyModel rest(later, springs);
        CHECK(later.energy_model->relaxation.empty());
        CHECK(energy_model.slowest_s() == 2);
        CHECK(rest.slowest_s() == 0);
        const NodeColumns u = scattered(model.mesh, 2e-3);
        NodeColumns f(u.rows(), u.cols()), now = f;
        RealtimeEnergyModel::Scratch scratch = energy_model.scratch();
        energy_model.force(u, now, scratch);
        BranchMemory quick = energy_model.memory(1e-9);
        energy_model.force(u, f, scratch, quick);
        INFO(model.mesh.topology);
        CHECK((f - now).norm() < 1e-6 * now.norm());
        BranchMemory memory = energy_model.memory(1);
        for (int n = 0; n < 60; ++n) energy_model.force(u, f, scratch, memory);
        rest.force(u, now, scratch);
        CHECK((f - now).norm() < 1e-10 * now.norm());
        CHECK(energy_model.energy(u, memory) == Approx(rest.energy(u)).epsilon(1e-9));
        // the contact likewise
        ToolSpring tool, left;
        energy_model.contacts().at(0, Eigen::Vector3d(0.5, 0.5, 0), {}, tool);
        rest.contacts().at(0, Eigen::Vector3d(0.5, 0.5, 0), {}, left);
        ToolMemory of_tool = energy_model.tool_memory(1);
        Point push = 0.002 * tool.inward();
        push[0] += 0.001;
        for (int n = 0; n < 60; ++n) tool.remember(push, u, of_tool);
        CHECK((tool.tool_force_N(push, u, &of_tool) - left.tool_force_N(push, u)).norm() < 1e-10 * left.tool_force_N(push, u).norm());
    }
}

namespace {

/// A model's learned mesh under a tool with prescribed displacements.
struct HeldTool {
    explicit HeldTool(const TissueModel& model, double damping_1_s = 0)
        : springs(springs_of(model)), law(model, springs), dynamics(make_dynamics("symplectic", springs, {dt / substeps, damping_1_s, &law})),
          state(springs, Eigen::VectorXd::Zero(springs.slot_count())), memory(law.tool_memory(dt / substeps)) {
        state.memory = law.memory(dt / substeps);
    }
    Point step(const Point& push_m) {
        ContactLoad load;
        load.tool = &tool;
        load.memory = &memory;
        load.push_m = push_m;
        return dynamics->advance(state, load, dt / substeps, substeps, substeps);
    }

    static constexpr double dt = 1e-3;
    static constexpr int substeps = 3;
    RealtimeMesh springs;
    RealtimeEnergyModel law;
    std::unique_ptr<Dynamics> dynamics;
    MeshState state;
    ToolSpring tool;
    ToolMemory memory;
};

}  // namespace

TEST_CASE("tissue that relaxes returns at most the hand's work plus the sampled coupling and keeps over a fifth", "[law][memory]") {
    for (const bool solid : {false, true}) {
        const TissueModel model = relaxing(solid ? solid_model_example(embedded_block(Lattice{{5, 6, 2}, {0.05, 0.06, 0.02}})) : energy_model_example());
        const FreeSurface surface(model.mesh);
        HeldTool held(model);
        const FreeSurface::Place place = surface.nearest(solid ? Point(Eigen::Vector3d(0.026, 0.031, 0.02)) : Point(Eigen::Vector2d(0.052, 0.1)));
        Eigen::Index facet = 0;
        for (Eigen::Index b = 0; b < model.mesh.facets.rows(); ++b)
            if ((held.springs.rest_place(static_cast<int>(b), Eigen::Vector3d::Constant(1.0 / 3)) - place.point_m).norm() <
                (held.springs.rest_place(static_cast<int>(facet), Eigen::Vector3d::Constant(1.0 / 3)) - place.point_m).norm())
                facet = b;
        held.law.contacts().at(static_cast<int>(facet), solid ? Eigen::Vector3d(0.3, 0.3, 0.4) : Eigen::Vector3d(0.4, 0.6, 0), {}, held.tool);
        const Point inward = held.tool.inward();
        Point across = Point::Zero(inward.size());
        across[0] = 1;
        across -= across.dot(inward) * inward;
        const double depth = solid ? 0.004 : 0.01;
        const auto smooth = [](double x) { return x <= 0 ? 0 : x >= 1 ? 1 : x * x * (3 - 2 * x); };
        const auto push = [&](double t) {
            const double in = smooth(t / 0.4) * smooth((3 - t) / 0.4) * depth * (1 + 0.3 * std::sin(19 * t));
            return Point(in * (std::cos(0.4 * std::sin(7 * t)) * inward + std::sin(0.4 * std::sin(7 * t)) * across));
        };
        held.state.memory.book();
        double work = 0, sampled = 0, most = 0, least = 0;
        for (int k = 0; k < 3000; ++k) {
            const Point now = push(k * held.dt), next = push((k + 1) * held.dt), jump = next - now;
            work += held.step(now).dot(jump);
            sampled += jump.dot(held.tool.stiffness_N_m(now, held.state.displacement) * jump) / 2;
            most = std::max(most, work);
            least = std::min(least, work + sampled);
        }
        INFO((solid ? "solid" : "plane") << ": given " << 1e3 * most << " mJ at most, not returned " << 1e3 * work << ", sampled " << 1e3 * sampled);
        CHECK(most > 1e-4);
        CHECK(least >= 0);
        CHECK(work > 0.2 * most);
        CHECK(work < most);
        // Part of the lost energy is dissipated in the elements' branches, the rest in the contact's branches and by
        // damping.
        const BranchEnergies book = held.law.branches(held.state.memory);
        INFO("branches store " << 1e3 * book.stored_J << " mJ, have dissipated " << 1e3 * book.dissipated_J);
        CHECK(book.dissipated_J > 0.3 * work);
        CHECK(book.dissipated_J + book.stored_J < work + sampled);
    }
}

TEST_CASE("held tissue that relaxes settles at its long-term equilibrium and its imprint fades after withdrawal", "[law][memory]") {
    const TissueModel model = relaxing(energy_model_example(make_lattice("grid8", 6, 6, 0.1, 0.1)));
    TissueModel later = model;
    later.energy_model = long_term(*model.energy_model);
    HapticOptions o;
    o.heuristic_mesh = false;
    const HapticModel haptic(model, o);
    Simulation s(haptic);
    double first = 0;
    for (int k = 0; k < 100000; ++k) {
        s.tick(sample_at(0.047, 0.103 - 0.009 * std::min(1.0, k / 200.0)));
        if (k == 200) first = s.record().coupling_N.norm();
    }
    REQUIRE(s.record().mesh == 0);
    const Equilibrium rest = IndentationSolver(later).at(Eigen::Vector2d(0.047, 0.1), Eigen::Vector2d(0, -0.006));
    REQUIRE(rest);
    const Eigen::Vector2d force = -s.record().coupling_N;
    INFO("after 0.2 s " << first << " N, after 100 s " << force.norm());
    CHECK((Eigen::Vector2d(rest.contact_force) - force).norm() < 1e-4 * force.norm());
    CHECK(first > 1.8 * force.norm());

    const double imprint = s.state(0).displacement.cwiseAbs().maxCoeff();
    for (int k = 0; k < 200; ++k) s.tick(sample_at(0.047, 0.094 + 0.015 * k / 200));
    CHECK(s.record().mesh == -1);
    const double soon = s.state(0).displacement.cwiseAbs().maxCoeff();
    for (int k = 0; k < 100000; ++k) s.tick(sample_at(0.047, 0.109));
    CHECK(soon > 0.2 * imprint);  // recovery takes time
    // creep is slower than relaxation: 0.2 % are left
    CHECK(s.state(0).displacement.cwiseAbs().maxCoeff() < 0.01 * imprint);
    CHECK(s.counters().unstable == 0);
}
