#include "springs/indentation_solver.h"

#include <catch2/catch.hpp>

#include "../mesh/embedded_block.h"
#include "../refusal.h"
#include "error.h"
#include "parallel.h"
#include "../solid_model_example.h"
#include "springs/disc_contact.h"
#include "springs/energy_model_terms.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

TissueModel plane_model(const SpringMesh& mesh, const std::string& formulation) {
    const EnergyModelTerms model_terms(mesh, energy_model_heuristic(mesh, 450, formulation, 12), {"spring.all", "contact.normal"});
    const Eigen::Vector2d p(0.1, -0.2);
    TissueModel model;
    model.mesh = mesh;
    model.energy_model = {model_terms.terms(), p, model_terms.constants(p), model_terms.patch(p), model_terms.incompressible()};
    return model;
}

}  // namespace

TEST_CASE("an energy model with too few or too many constants for its mesh is refused", "[law]") {
    for (const TissueModel& model : {plane_model(make_lattice("grid8", 3, 3, 0.1, 0.1), "plane-strain"), solid_model_example(embedded_block(Lattice{{3, 3, 2}, {0.03, 0.03, 0.02}}))}) {
        const Eigen::Index right = model.energy_model->constants.size();
        for (const Eigen::Index wrong : {right - 1, right + 1, Eigen::Index(0)}) {
            TissueModel other = model;
            other.energy_model->constants = Eigen::VectorXd::Ones(wrong);
            CHECK_THAT(refusal<MismatchError>([&] { IndentationSolver solver(other); }), Contains("has " + std::to_string(wrong) + " constants, must have " + std::to_string(right)));
        }
    }
}

TEST_CASE("IndentationSolver gives bit-identical results from several threads and from a new object", "[law]") {
    const TissueModel model = plane_model(make_lattice("grid8", 6, 6, 0.1, 0.1), "plane-strain");
    const Outline outline(model.mesh);
    constexpr int count = 24;
    const auto push = [&](int i) { return Eigen::Vector2d(0.004 * outline.direction(0.02 + 0.01 * i, 0.3)); };
    std::vector<Equilibrium> together(count);
    const IndentationSolver solver(model);
    parallel_for(count, 4, [&](int i) { together[static_cast<std::size_t>(i)] = solver.at(outline.position(0.02 + 0.01 * i), push(i)); });
    for (int i = 0; i < count; ++i) {
        const Equilibrium alone = IndentationSolver(model).at(outline.position(0.02 + 0.01 * i), push(i)), &other = together[static_cast<std::size_t>(i)];
        REQUIRE(alone);
        CHECK(other.status == alone.status);
        CHECK(other.displacement == alone.displacement);
        CHECK(other.contact_force == alone.contact_force);
    }
}

TEST_CASE("IndentationSolver returns the solver's status and a result is valid only if balanced", "[law]") {
    const TissueModel model = plane_model(make_lattice("grid8", 10, 10, 0.1, 0.1), "plane-stress");
    const IndentationSolver solver(model);
    const Outline outline(model.mesh);
    const auto status = [&](double arc, double angle, double depth) { return solver.at(outline.position(arc), depth * outline.direction(arc, angle)).status; };
    CHECK(status(0.03, 0.9, 0.01) == EquilibriumStatus::balanced);
    CHECK(status(0.03, 0.9, 0.03) == EquilibriumStatus::inverted);
    CHECK(status(0.15, 0, 0.03) == EquilibriumStatus::unstable);
    CHECK(status(0.15, 0, 0.4) == EquilibriumStatus::not_converged);
    CHECK_FALSE(solver.at(outline.position(0.03), 0.03 * outline.direction(0.03, 0.9)));
    CHECK(reason_of(EquilibriumStatus::inverted) != "");
}

TEST_CASE("a place without lattice tissue nearby has status no_contact and a rigid wall as contact", "[law][solid]") {
    TissueModel model = solid_model_example(embedded_block(Lattice{{4, 4, 2}, {0.04, 0.04, 0.02}}));
    const int own = model.mesh.embedding.node_count();
    model.mesh.nodes.topRows(own).col(2).array() += 0.05;  // moves the surface away from its lattice
    const Eigen::Vector3d contact(0.02, 0.02, 0.07), push(0, 0, -0.002);
    const IndentationSolver solver(model);
    CHECK(solver.at(contact, push).status == EquilibriumStatus::no_contact);
    // by the solver of the first call, which is idle again
    CHECK(solver.at(contact, push).status == EquilibriumStatus::no_contact);
    CHECK(reason_of(EquilibriumStatus::contact_fixed) != reason_of(EquilibriumStatus::no_contact));

    const DiscContact kernel(model.mesh, 0.007);
    ToolSpring tool;
    kernel.tool_at(0, Eigen::Vector3d::Constant(1.0 / 3), 0, model.energy_model->patch, tool);
    CHECK(tool.group_count() == 1);
    const NodeColumns u = NodeColumns::Zero(model.mesh.node_count(), 3);
    CHECK(tool.tool_force_N(push, u).norm() > 0);
}
