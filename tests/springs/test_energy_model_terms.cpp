#include "springs/energy_model_terms.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "error.h"
#include "springs/heuristic.h"
#include "mesh/shape.h"
#include "../mesh/disc.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const SpringMesh& block() {
    static const SpringMesh mesh = make_lattice("grid8", 10, 10, 0.1, 0.1);
    return mesh;
}

EnergyModelHeuristic heuristic() { return energy_model_heuristic(block(), 450, "plane-strain", 12); }

EnergyModelTerms energy_model_of(const std::vector<std::string>& terms) { return {block(), heuristic(), terms}; }

/// Logarithm of the constants with a term's coefficient 1, over those with coefficient 0.
Eigen::VectorXd effect(const SpringMesh& mesh, const std::string& term) {
    const EnergyModelTerms model_terms(mesh, energy_model_heuristic(mesh, 450, "plane-stress", 1e9), {term});
    return (model_terms.constants(Eigen::VectorXd::Ones(1)).array() / model_terms.constants(Eigen::VectorXd::Zero(1)).array()).log();
}

int spring_between(const SpringMesh& mesh, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const int i = node_at(mesh, a), j = node_at(mesh, b);
    for (int s = 0; s < mesh.spring_count(); ++s)
        if ((mesh.springs(s, 0) == i && mesh.springs(s, 1) == j) || (mesh.springs(s, 0) == j && mesh.springs(s, 1) == i)) return s;
    return -1;
}

}  // namespace

TEST_CASE("with zero coefficients springs are 2/3 of Van Gelder's and the first cell has its start value") {
    for (const char* formulation : {"plane-strain", "plane-stress"}) {
        const EnergyModelTerms model_terms(block(), energy_model_heuristic(block(), 450, formulation, 12), {"spring.all"});
        const Eigen::VectorXd c = model_terms.constants(Eigen::VectorXd::Zero(1));
        CHECK((c.head(block().spring_count()) - 2.0 / 3 * heuristic_stiffness(block(), 450)).norm() <= tolerance::rounding * c.norm());
        CHECK(c[block().spring_count()] == Approx(std::string(formulation) == "plane-strain" ? 0.95 * 12 * 450 : 150).epsilon(tolerance::rounding));
    }
}

TEST_CASE("heuristic springs have shear modulus E2/3 on squares and on equilateral triangles") {
    // equilateral triangles: rows shifted by half a side
    Shape shape;
    const int n = 12;
    const double side = 0.01, height = side * std::sqrt(3.0) / 2;
    shape.nodes.resize((n + 1) * (n + 1), 2);
    shape.simplices.resize(2 * n * n, 3);
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) shape.nodes.row(j * (n + 1) + i) << side * (i + 0.5 * j), height * j;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const int a = j * (n + 1) + i;
            shape.simplices.row(2 * (j * n + i)) << a, a + 1, a + n + 1;
            shape.simplices.row(2 * (j * n + i) + 1) << a + 1, a + n + 2, a + n + 1;
        }
    shape.region.assign(static_cast<std::size_t>(2 * n * n), 0);
    for (int i = 0; i < n; ++i) shape.fixed_edges.push_back({i, i + 1});
    for (const SpringMesh& mesh : {block(), edge_mesh(shape)}) {
        Eigen::VectorXd springs = energy_model_heuristic(mesh, 450, "plane-stress", 12).constants.head(mesh.spring_count());
        const TissueEnergy energy(mesh, false);
        Eigen::VectorXd c = Eigen::VectorXd::Zero(energy.constant_count());
        c.head(springs.size()) = springs;
        const double small = 1e-5, area = cell_areas(mesh, mesh_cells(mesh)).sum();
        NodeField stretched = small * mesh.nodes, sheared(mesh.node_count(), 2);
        stretched.col(1) *= -1;
        sheared.col(0) = small * mesh.nodes.col(1);
        sheared.col(1) = small * mesh.nodes.col(0);
        for (const NodeField& u : {stretched, sheared}) CHECK(energy.energy(c, u) / (area * small * small) == Approx(2 * 150).epsilon(1e-3));
    }
}

TEST_CASE("constants are positive and cells do not exceed their cap for any coefficients") {
    const EnergyModelTerms model_terms = energy_model_of({"spring.all", "spring.layer", "cell.all", "cell.y2"});
    for (double size : {-20.0, -3.0, 3.0, 20.0}) {
        const Eigen::VectorXd c = model_terms.constants(Eigen::Vector4d(size, -size / 2, size, size / 3));
        CHECK(c.minCoeff() > 0);
        CHECK(c.tail(105).maxCoeff() <= 12 * 450);
    }
}

TEST_CASE("derivatives of constants and contact stiffness by the coefficients agree with finite differences") {
    const EnergyModelTerms model_terms = energy_model_of({"spring.diagonal.y", "cell.layer", "cell.all", "contact.normal", "contact.normal.phase",
                                  "contact.tangent.corner", "contact.rotation.edge", "contact.stretch"});
    Eigen::VectorXd p(8);
    for (int i = 0; i < 8; ++i) p[i] = 0.3 * std::sin(2.0 * i);
    const ContactSurface surface(block());
    const ContactPatch patch = surface.at(0.0963);
    const auto stiffness = [&](const Eigen::VectorXd& q) {
        const PatchStiffness k = model_terms.patch(q).at(patch);
        return Eigen::Vector4d(k.normal, k.tangent, k.rotation, k.stretch);
    };
    const double h = 1e-4;
    for (int t = 0; t < 8; ++t) {
        const Eigen::VectorXd e = h * Eigen::VectorXd::Unit(8, t);
        const Eigen::VectorXd constants = (model_terms.constants(p + e) - model_terms.constants(p - e)) / (2 * h);
        const Eigen::Vector4d contact = (stiffness(p + e) - stiffness(p - e)) / (2 * h);
        CHECK((constants - model_terms.constants_by(p).col(t)).norm() <= tolerance::difference * model_terms.constants(p).norm());
        CHECK((contact - model_terms.stiffness_by(p, ContactParameters::factors_at(patch)).col(t)).norm() <= tolerance::difference * stiffness(p).norm());
    }
}

TEST_CASE("spring terms act on their surface or layer or fixed part or family of springs") {
    const SpringMesh& mesh = block();
    const int top = spring_between(mesh, {0.05, 0.1}, {0.06, 0.1}), side = spring_between(mesh, {0, 0.05}, {0, 0.06}),
              below = spring_between(mesh, {0.05, 0.1}, {0.05, 0.09}), inner = spring_between(mesh, {0.05, 0.05}, {0.06, 0.05}),
              foot = spring_between(mesh, {0.05, 0}, {0.05, 0.01}), slanted = spring_between(mesh, {0.05, 0}, {0.06, 0.01}),
              bottom = spring_between(mesh, {0.05, 0}, {0.06, 0});
    const Eigen::VectorXd surface = effect(mesh, "spring.surface"), held = effect(mesh, "spring.held"), layer = effect(mesh, "spring.layer"),
                          along = effect(mesh, "spring.along"), upright = effect(mesh, "spring.upright"), slant = effect(mesh, "spring.diagonal");
    CHECK(surface[top] == Approx(1));
    CHECK(surface[side] == Approx(1));
    CHECK(surface[below] == Approx(0).margin(1e-9));
    CHECK(surface[bottom] == Approx(0).margin(1e-9));  // fixed springs are not on the free surface
    CHECK(held[foot] == Approx(1));
    CHECK(held[slanted] == Approx(1));
    CHECK(held[bottom] == Approx(0).margin(1e-9));
    CHECK(layer[top] == Approx(1));
    CHECK(layer[below] == Approx(std::exp(-0.5)));
    CHECK(layer[inner] == Approx(std::exp(-4.5)).epsilon(1e-6));  // the sides are nearer than the top
    CHECK(along[top] == Approx(1));
    CHECK(along[side] == Approx(1));
    CHECK(along[below] == Approx(0).margin(1e-9));
    CHECK(upright[foot] == Approx(1));
    CHECK(upright[slanted] == Approx(0.5));
    CHECK(slant[slanted] == Approx(1));
    CHECK(slant[foot] == Approx(0).margin(1e-9));
    const Eigen::VectorXd product = effect(mesh, "spring.held.upright");
    CHECK(product[slanted] == Approx(0.5));
    CHECK(product[below] == Approx(0).margin(1e-9));
}

TEST_CASE("spring terms are mirror-symmetric on a mirror-symmetric block") {
    const SpringMesh& mesh = block();
    for (const char* term : {"spring.layer", "spring.along", "spring.across.layer", "spring.held", "spring.x2.y", "spring.x4", "spring.y3", "spring.upright"}) {
        INFO(term);
        const Eigen::VectorXd value = effect(mesh, term);
        for (int s = 0; s < mesh.spring_count(); ++s) {
            const auto mirror = [&](int node) { return Eigen::Vector2d(0.1 - mesh.nodes(node, 0), mesh.nodes(node, 1)); };
            const int other = spring_between(mesh, mirror(mesh.springs(s, 0)), mirror(mesh.springs(s, 1)));
            REQUIRE(other >= 0);
            CHECK(value[other] == Approx(value[s]).margin(1e-9));
        }
    }
}

TEST_CASE("terms without x and y are accepted on a shape that is no block") {
    const SpringMesh mesh = edge_mesh(disc(16));
    const EnergyModelTerms model_terms(mesh, energy_model_heuristic(mesh, 450, "plane-strain", 12),
                        {"spring.all", "spring.surface", "spring.along.layer", "spring.across.layer", "spring.held", "cell.layer", "contact.normal"});
    CHECK(model_terms.size() == 7);
    CHECK(effect(mesh, "spring.surface").sum() == Approx(12));  // a quarter of sixteen sides is fixed
}

TEST_CASE("a modulus per triangle scales the adjacent cells and its maximum sets the contact stiffness") {
    const SpringMesh mesh = edge_mesh(disc(12));
    Eigen::VectorXd modulus = Eigen::VectorXd::Constant(12, 100.0);
    modulus[3] = 400;
    const EnergyModelHeuristic h = energy_model_heuristic(mesh, modulus, "plane-stress", 12), even = energy_model_heuristic(mesh, 100.0, "plane-stress", 12);
    // cells are nodal areas: nodes 3 and 4 have one stiff triangle of two, node 8 none, the centre one of twelve
    const auto ratio = [&](int node) { return h.constants[24 + node] / even.constants[24 + node]; };
    CHECK(ratio(3) == Approx(2.5));
    CHECK(ratio(8) == Approx(1));
    CHECK(ratio(12) == Approx(1.25));
    CHECK(std::exp(h.patch.log_N_m(0, 0)) == Approx(1600));
}

TEST_CASE("terms that are unknown or repeated or do not fit the mesh are refused by name") {
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"spring.all", "spring.all"}); }), Contains("spring.all") && Contains("twice"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"bolt.all"}); }), Contains("bolt.all") && Contains("spring., cell. or contact."));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"spring"}); }), Contains("spring"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"spring.shiny"}); }), Contains("spring.shiny") && Contains("layer"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"cell.along"}); }), Contains("cell.along"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"spring.x"}); }), Contains("spring.x"));  // not mirror-symmetric
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"spring.diagonal.surface"}); }), Contains("zero everywhere"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"contact"}); }), Contains("normal, tangent, rotation, stretch"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"contact.normal.shiny"}); }), Contains("shiny") && Contains("phase"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"contact.normal."}); }), Contains("phase"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_of({"contact.shiny"}); }), Contains("shiny"));
    const SpringMesh shape = edge_mesh(disc(12));
    CHECK_THAT(refusal<MismatchError>([&] { EnergyModelTerms(shape, energy_model_heuristic(shape, 1, "plane-stress", 12), {"spring.diagonal"}); }), Contains("diagonal"));
    CHECK_THAT(refusal<MismatchError>([&] { EnergyModelTerms(shape, heuristic(), {"spring.all"}); }), Contains("mesh"));
    EnergyModelHeuristic fewer = heuristic(), uncapped = heuristic();
    fewer.constants.conservativeResize(fewer.constants.size() - 1);
    uncapped.cap.conservativeResize(uncapped.cap.size() - 1);
    for (const EnergyModelHeuristic& h : {fewer, uncapped})
        CHECK_THAT(refusal<MismatchError>([&] { EnergyModelTerms(block(), h, {"spring.all"}); }), Contains("constants of the heuristic do not match the mesh"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_heuristic(block(), 450, "plane", 12); }), Contains("plane-stress, plane-strain"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_heuristic(block(), 450, "plane-strain", 0.2); }), Contains("E2 / 3"));
    CHECK_THAT(refusal<MismatchError>([] { energy_model_heuristic(block(), Eigen::VectorXd::Ones(200), "plane-strain", 12); }), Contains("triangle"));
}
