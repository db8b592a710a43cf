#include "springs/law_press.h"

#include <catch2/catch.hpp>

#include "../mesh/embedded_block.h"
#include "parallel.h"
#include "../solid_law_example.h"
#include "springs/disc_contact.h"
#include "springs/energy_law.h"

using namespace tissue;

namespace {

TissueModel law_model(const SpringMesh& mesh, const std::string& formulation) {
    const EnergyLaw law(mesh, law_heuristic(mesh, 450, formulation, 12), {"spring.all", "contact.normal"});
    const Eigen::Vector2d p(0.1, -0.2);
    TissueModel model;
    model.mesh = mesh;
    model.energy_law = {law.terms(), p, law.constants(p), law.patch(p), law.incompressible()};
    return model;
}

}  // namespace

TEST_CASE("a law pressed from many threads gives to the last bit what it gives alone, whatever came before", "[law]") {
    const TissueModel model = law_model(make_lattice("grid8", 6, 6, 0.1, 0.1), "plane-strain");
    const Outline outline(model.mesh);
    constexpr int count = 24;
    const auto push = [&](int i) { return Eigen::Vector2d(0.004 * outline.direction(0.02 + 0.01 * i, 0.3)); };
    std::vector<Equilibrium> together(count);
    const LawPress press(model);
    parallel_for(count, 4, [&](int i) { together[static_cast<std::size_t>(i)] = press.at(outline.position(0.02 + 0.01 * i), push(i)); });
    for (int i = 0; i < count; ++i) {
        const Equilibrium alone = LawPress(model).at(outline.position(0.02 + 0.01 * i), push(i)), &other = together[static_cast<std::size_t>(i)];
        REQUIRE(alone);
        CHECK(other.status == alone.status);
        CHECK(other.displacement == alone.displacement);
        CHECK(other.contact_force == alone.contact_force);
    }
}

TEST_CASE("a law's answer says what its press ended as, and is none unless that is held", "[law]") {
    const TissueModel model = law_model(make_lattice("grid8", 10, 10, 0.1, 0.1), "plane-stress");
    const LawPress press(model);
    const Outline outline(model.mesh);
    const auto status = [&](double arc, double angle, double depth) { return press.at(outline.position(arc), depth * outline.direction(arc, angle)).status; };
    CHECK(status(0.03, 0.9, 0.01) == EquilibriumStatus::balanced);
    CHECK(status(0.03, 0.9, 0.03) == EquilibriumStatus::inside_out);
    CHECK(status(0.15, 0, 0.03) == EquilibriumStatus::unstable);
    CHECK(status(0.15, 0, 0.4) == EquilibriumStatus::not_converged);
    CHECK_FALSE(press.at(outline.position(0.03), 0.03 * outline.direction(0.03, 0.9)));
    CHECK(reason_of(EquilibriumStatus::inside_out) != "");
}

TEST_CASE("of a solid whose lattice has no tissue near a place a law's answer says so, and a tool meets a wall there", "[law][solid]") {
    TissueModel model = solid_law_example(embedded_block(Lattice{{4, 4, 2}, {0.04, 0.04, 0.02}}));
    const int own = model.mesh.embedding.node_count();
    model.mesh.nodes.topRows(own).col(2).array() += 0.05;  // the surface, away from its lattice
    const Eigen::Vector3d contact(0.02, 0.02, 0.07), push(0, 0, -0.002);
    const LawPress press(model);
    CHECK(press.at(contact, push).status == EquilibriumStatus::no_contact);
    CHECK(press.at(contact, push).status == EquilibriumStatus::no_contact);  // by the solver that the first has given back
    CHECK(reason_of(EquilibriumStatus::contact_fixed) != reason_of(EquilibriumStatus::no_contact));

    const DiscContact kernel(model.mesh, 0.007);
    ToolSpring tool;
    kernel.tool_at(0, Eigen::Vector3d::Constant(1.0 / 3), 0, model.energy_law->patch, tool);
    CHECK(tool.group_count() == 1);
    const NodeColumns u = NodeColumns::Zero(model.mesh.node_count(), 3);
    CHECK(tool.hand_N(push, u).norm() > 0);
}
