#include "springs/law_press.h"

#include <catch2/catch.hpp>

#include "parallel.h"
#include "../solid_law_example.h"
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

TEST_CASE("a law's answer tells a contact on fixed nodes alone from one that has no nodes near it", "[law]") {
    // all nodes are fixed but two corners of the top: facets there are free, and a corner of one triangle alone does not face the disc
    TissueModel held = solid_law_example(make_lattice("grid26", Lattice{{5, 5, 3}, {0.1, 0.1, 0.06}}));
    held.mesh.fixed.clear();
    for (int node = 0; node < held.mesh.node_count(); ++node)
        if ((held.mesh.nodes.row(node) - Eigen::RowVector3d(0, 0.1, 0.06)).norm() > 0.001 && (held.mesh.nodes.row(node) - Eigen::RowVector3d(0.1, 0, 0.06)).norm() > 0.001)
            held.mesh.fixed.push_back(node);
    const Equilibrium fixed = LawPress(held).at(Eigen::Vector3d(0.012, 0.088, 0.06), Eigen::Vector3d(0, 0, -0.004));
    CHECK(fixed.status == EquilibriumStatus::contact_fixed);
    CHECK(fixed.displacement.isZero(0));
    CHECK(fixed.contact_force.isZero(0));

    // one cell: all nodes are corners, and no side has three that face it
    const TissueModel coarse = solid_law_example(make_lattice("grid26", Lattice{{1, 1, 1}, {0.1, 0.1, 0.1}}));
    const LawPress press(coarse);
    const Eigen::Vector3d contact(0.05, 0.05, 0.1), push(0, 0, -0.004);
    CHECK(press.at(contact, push).status == EquilibriumStatus::no_contact);
    CHECK(press.at(contact, push).status == EquilibriumStatus::no_contact);  // by the solver that the first has given back
    CHECK(reason_of(EquilibriumStatus::contact_fixed) != reason_of(EquilibriumStatus::no_contact));
}
