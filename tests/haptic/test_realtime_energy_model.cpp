#include "haptic/realtime_energy_model.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>

#include "../example.h"
#include "../mesh/disc.h"
#include "../refusal.h"
#include "error.h"
#include "haptic/dynamics.h"
#include "haptic/energy_model_spectrum.h"
#include "haptic/spectrum.h"
#include "haptic_example.h"
#include "tick_forces.h"
#include "springs/equilibrium_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

std::vector<SpringMesh> meshes() { return {make_lattice("grid8", 10, 10, 0.1, 0.1), make_lattice("grid8", 4, 7, 0.06, 0.1), edge_mesh(disc(24))}; }

/// An energy model with different constants in all elements, so that no element can replace another.
TissueModel uneven(const SpringMesh& mesh) {
    TissueModel model = energy_model_example(mesh);
    for (Eigen::Index e = 0; e < model.energy_model->constants.size(); ++e)
        model.energy_model->constants[e] *= 1 + 0.3 * std::sin(1.7 * static_cast<double>(e));
    return model;
}

}  // namespace

TEST_CASE("forces and energy in the tick equal those of the trained energy model", "[law]") {
    for (const SpringMesh& mesh : meshes())
        for (double size : {1e-6, 1e-3, 4e-3}) {
            const TissueModel model = uneven(mesh);
            INFO(mesh.topology << " " << size);
            // l - L cancels in the tick's springs
            check_tick_forces(model, TissueEnergy(mesh, true), scattered(mesh, size), size < 1e-5 ? 1e-9 : 1e-12, 1e-8);
        }
}

TEST_CASE("the contact in the tick equals the trained one and acts on fixed nodes only at the fixed boundary", "[law]") {
    for (const SpringMesh& mesh : meshes()) {
        const TissueModel model = uneven(mesh);
        const RealtimeMesh springs = springs_of(model);
        const RealtimeEnergyModel energy_model(model, springs);
        const ContactSurface surface(mesh);
        const std::size_t M = mesh.loop().size();
        int held = 0;
        for (std::size_t b = 0; b < M; ++b)
            for (double w : {0.0, 0.3, 0.99}) {
                const int i = mesh.loop()[b], j = mesh.loop()[(b + 1) % M];
                const Eigen::Vector2d place = (1 - w) * mesh.nodes.row(i) + w * mesh.nodes.row(j);
                ToolSpring now;
                energy_model.contacts().at(static_cast<int>(b), {1 - w, w, 0}, {}, now);
                const NodeColumns u = scattered(mesh, 1e-3);
                const Eigen::Vector2d push(0.002, -0.001);
                NodeColumns asked = NodeColumns::Zero(u.rows(), 2);
                const Point hand = now.put_on(push, u, asked);
                CHECK((now.tool_force_N(push, u) - hand).norm() == 0);
                CHECK((now.tool_force_N(now.push_at(hand, u), u) - hand).norm() <= 1e-12 * hand.norm());
                if (springs.fixed(i) && springs.fixed(j)) {
                    ++held;
                    const Eigen::MatrixXd wall = now.stiffness_N_m(push, u);
                    CHECK(wall.isDiagonal(1e-9 * wall.norm()));
                    CHECK(wall(0, 0) == Approx(wall(1, 1)));
                    for (int node = 0; node < mesh.node_count(); ++node) CHECK((springs.fixed(node) || asked.row(node).isZero(0)));
                    continue;
                }
                const ContactPatch patch = surface.at(surface.outline().arc_of(place));
                const PatchSpring expected(patch, model.energy_model->patch.at(patch));
                Eigen::Vector2d at[ContactPatch::size];
                gather(patch, u, at);
                const PatchSpring::Load load = expected.load(push, at);
                NodeColumns by_node = NodeColumns::Zero(u.rows(), 2);
                for (int k = 0; k < ContactPatch::size; ++k) by_node.row(patch.node[k]) += load.node_N[k].transpose();
                CHECK((hand - load.tool_force_N).norm() <= 1e-9 * load.tool_force_N.norm());
                CHECK((asked - by_node).norm() <= 1e-9 * by_node.norm());
                CHECK(now.energy_J(push, u) == Approx(load.energy_J).epsilon(1e-9));
            }
        CHECK(held > 0);
    }
}

TEST_CASE("the spectrum of an energy model is that of its tangents at rest and indented", "[law]") {
    TissueModel model = energy_model_example();
    model.magnitude_m *= 2;  // 20 mm: deep enough that springs and cells stiffen, not only the contact
    const SpringMesh& mesh = model.mesh;
    const RealtimeMesh springs = springs_of(model);
    const EnergyModelSpectrum spectrum = energy_model_spectrum(model, springs);

    const TissueEnergy energy(mesh, true);
    const ContactSurface surface(mesh);
    const auto eigenvalues = [&](const NodeField& u, const PatchSpring* contact) {
        Eigen::MatrixXd K = energy.tangent(model.energy_model->constants, u);
        for (int i = 0; contact && i < ContactPatch::size; ++i)
            for (int j = 0; j < ContactPatch::size; ++j)
                K.block<2, 2>(2 * contact->patch.node[i], 2 * contact->patch.node[j]) += contact->tangent(i, j);
        std::vector<int> free;
        for (int node = 0; node < mesh.node_count(); ++node)
            for (int axis = 0; axis < 2 && !springs.fixed(node); ++axis) free.push_back(2 * node + axis);
        Eigen::MatrixXd A = K(free, free);
        for (std::size_t i = 0; i < free.size(); ++i)
            for (std::size_t j = 0; j < free.size(); ++j)
                A(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) *=
                    std::sqrt(springs.inverse_mass()[free[i] / 2] * springs.inverse_mass()[free[j] / 2]);
        return Eigen::VectorXd(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A).eigenvalues());
    };
    const Eigen::VectorXd rest = eigenvalues(NodeField::Zero(mesh.node_count(), 2), nullptr);
    CHECK(spectrum.smallest == Approx(rest[0]).epsilon(1e-4));
    CHECK(spectrum.largest >= rest[rest.size() - 1]);

    // Indentations at other places, as deep as the deepest load case: none is much stiffer.
    EquilibriumSolver solver(energy, surface);
    double stiffest = 0;
    for (int k = 0; k <= 10; ++k) {
        const double arc = k / 10.0 * surface.outline().length();
        const ContactPatch patch = surface.at(arc);
        const PatchSpring contact(patch, model.energy_model->patch.at(patch));
        const EquilibriumState state = solver.indent(model.energy_model->constants, contact, 0.020 * surface.outline().direction(arc, 0.3));
        if (state.status != SolverStatus::no_equilibrium) stiffest = std::max(stiffest, eigenvalues(state.displacement, &contact).maxCoeff());
    }
    CHECK(stiffest > rest[rest.size() - 1]);
    CHECK(spectrum.largest > 0.98 * stiffest);
    CHECK(spectrum.largest < 1.2 * stiffest);
}

TEST_CASE("the contact stiffness of an energy model is that of its stiffest direction", "[law]") {
    TissueModel across = energy_model_example(), in = across;
    auto stiffness = across.energy_model->patch.log_N_m;
    stiffness.row(1) = stiffness.row(0);
    stiffness(1, 0) += 1;  // e times as stiff along the surface as straight in
    across.energy_model->patch.log_N_m = stiffness;
    stiffness.row(0).swap(stiffness.row(1));
    in.energy_model->patch.log_N_m = stiffness;
    const double straight_N_m = energy_model_spectrum(in, springs_of(in)).contact_N_m;
    CHECK(energy_model_spectrum(across, springs_of(across)).contact_N_m == Approx(straight_N_m).epsilon(1e-9));
}

TEST_CASE("for very small masses the highest frequency of an energy model is right or not finite", "[law][long]") {
    TissueModel model = energy_model_example();
    const double largest = energy_model_spectrum(model, springs_of(model)).largest;
    const Eigen::VectorXd mass_kg = model.node_mass_kg;
    int right = 0, none = 0;
    // Here squares overflow, first in indented states and then at rest.
    for (double decade = 154.5; decade < 154.8; decade += 0.02) {
        const double lighter = std::pow(10.0, decade) / largest;
        model.node_mass_kg = mass_kg / lighter;
        const double here = energy_model_spectrum(model, springs_of(model)).largest;
        if (std::isfinite(here)) {
            CHECK(here / lighter == Approx(largest).epsilon(1e-6));
            ++right;
        } else
            ++none;
    }
    CHECK(right > 0);
    CHECK(none > 0);
}

TEST_CASE("an energy model refuses spring sets and springs that do not turn and steps other than symplectic", "[law]") {
    const TissueModel model = energy_model_example(), sets = haptic_example();
    const RealtimeMesh springs = springs_of(model), axial(model.mesh, "axial", model.node_mass_kg);
    CHECK_THAT(refusal<MismatchError>([&] { RealtimeEnergyModel(sets, springs); }), Contains("not an energy model"));
    CHECK_THAT(refusal<MismatchError>([&] { RealtimeEnergyModel(model, axial); }), Contains("geometric"));
    CHECK_THAT(refusal<MismatchError>([&] { energy_model_spectrum(sets, springs); }), Contains("not an energy model"));
    const RealtimeEnergyModel energy_model(model, springs);
    for (const char* name : {"implicit", "paper"})
        CHECK_THAT(refusal<MismatchError>([&] { make_dynamics(name, springs, {1e-3, 1, &energy_model}); }), Contains(name));
}
