#include "springs/skin.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../mesh/embedded_block.h"
#include "../refusal.h"
#include "../tolerances.h"
#include "error.h"
#include "mesh/free_surface.h"
#include "mesh/topology.h"
#include "springs/disc_contact.h"
#include "springs/energy_model_terms.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

constexpr double radius_m = 0.007;

SpringMesh block() { return embedded_block(Lattice{{8, 8, 3}, {0.08, 0.08, 0.03}}); }

const SkinParameters some_skin(0.3, -0.2, 0.4, 0.5);
const Eigen::Vector3d push(0.001, -0.0005, -0.004);

/// The node at a position [m].
int node_at(const SpringMesh& mesh, const Eigen::Vector3d& place_m) {
    Eigen::Index node = 0;
    const double away_m = (mesh.nodes.rowwise() - place_m.transpose()).rowwise().norm().minCoeff(&node);
    REQUIRE(away_m < 1e-9);
    return static_cast<int>(node);
}

/// Displayed displacement of a node with the lattice's displacement u.
Eigen::Vector3d shown(const DiscContact& disc, int node, const Eigen::Vector3d& contact_m, const Eigen::Vector3d& u) {
    for (const SkinNode& at : disc.skin_at(contact_m))
        if (at.node == node) return at.shown(u, some_skin, push);
    return u;
}

}  // namespace

TEST_CASE("the displayed surface follows the tool under a disc and the lattice beyond 2.5 radii", "[solid][skin]") {
    const SpringMesh mesh = block();
    const DiscContact disc(mesh, radius_m);
    const Eigen::Vector3d contact(0.041, 0.038, 0.03), u(0.002, 0.001, -0.001);
    int under = 0, beside = 0;
    for (int node = 0; node < mesh.embedding.node_count(); ++node) {
        const double x = (mesh.nodes.row(node).transpose() - contact).norm() / radius_m;
        const Eigen::Vector3d seen = shown(disc, node, contact, u);
        if (mesh.nodes(node, 2) == 0.03 && x <= 1) {
            CHECK((seen - disc_profile(x) * push).norm() < tolerance::rounding * push.norm());
            ++under;
        } else if (mesh.nodes(node, 2) < 0.03 || x >= 2.5) {
            CHECK(seen == u);
        } else {
            CHECK(seen != u);
            ++beside;
        }
    }
    CHECK(under >= 1);
    CHECK(beside >= 8);
}

TEST_CASE("the displayed displacement of a node is continuous at 1 and 2.5 radii from the contact", "[solid][skin]") {
    const SpringMesh mesh = block();
    const DiscContact disc(mesh, radius_m);
    const Eigen::Vector3d u(0.002, 0.001, -0.001);
    const int node = node_at(mesh, Eigen::Vector3d(0.04, 0.04, 0.03));
    for (double x : {1.0, 2.5}) {
        const auto at = [&](double away) { return shown(disc, node, {0.04 + away * radius_m, 0.04, 0.03}, u); };
        CHECK((at(x + 1e-7) - at(x - 1e-7)).norm() < 1e-5 * push.norm());
        CHECK((at(x + 0.1) - at(x - 0.1)).norm() > 1e-3 * push.norm());
    }
}

TEST_CASE("each skin parameter couples one component of the tool displacement to one direction", "[solid][skin]") {
    const SpringMesh mesh = block();
    const DiscContact disc(mesh, radius_m);
    const int node = node_at(mesh, Eigen::Vector3d(0.05, 0.04, 0.03));  // beside the contact, along x
    for (const SkinNode& at : disc.skin_at(Eigen::Vector3d(0.04, 0.04, 0.03))) {
        if (at.node != node) continue;
        const double x = 0.01 / radius_m, w = std::pow((2.5 - x) / 1.5, 2) * (x - 1);
        const Eigen::Vector3d X = Eigen::Vector3d::UnitX(), Y = Eigen::Vector3d::UnitY(), Z = Eigen::Vector3d::UnitZ(), none = Eigen::Vector3d::Zero();
        const auto moved = [&](int k, const Eigen::Vector3d& d) { return Eigen::Vector3d(at.by[static_cast<std::size_t>(k)] * d); };
        const auto is = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return (a - b).norm() < tolerance::rounding; };
        CHECK((is(moved(0, Z), w * Z) && is(moved(0, X), none) && is(moved(0, Y), none)));
        CHECK((is(moved(1, X), w * X) && is(moved(1, Y), w * Y) && is(moved(1, Z), none)));
        CHECK((is(moved(2, X), -w * Z) && is(moved(2, Y), none) && is(moved(2, Z), none)));  // inwards ahead of the tool, n = -z
        CHECK((is(moved(3, Z), -w * X) && is(moved(3, X), none)));  // outwards from the contact
        return;
    }
    FAIL("the node is not in the skin");
}

TEST_CASE("skin terms are refused in the plane and found by name among a model's terms", "[solid][skin]") {
    const SpringMesh plane = make_lattice("grid8", 4, 4, 0.1, 0.1);
    CHECK_THAT(refusal<MismatchError>([&] { EnergyModelTerms(plane, energy_model_heuristic(plane, 450, "plane-strain", 12), {"spring.all", "skin.normal"}); }), Contains("skin.normal"));
    CHECK(skin_of({"spring.all", "skin.radial", "skin.normal"}, Eigen::Vector3d(7, 8, 9)) == SkinParameters(9, 0, 0, 8));
}
