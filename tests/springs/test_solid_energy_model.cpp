#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "../mesh/embedded_block.h"
#include "error.h"
#include "mesh/embedded_lattice.h"
#include "mesh/solid_block.h"
#include "mesh/topology.h"
#include "springs/cell_volumes.h"
#include "springs/disc_contact.h"
#include "springs/energy_model_terms.h"
#include "springs/heuristic.h"
#include "springs/indentation_solver.h"
#include "../tolerances.h"

using namespace tissue;
using Approx = Catch::Detail::Approx;
using Catch::Matchers::Contains;

namespace {

SpringMesh block(int x = 4, int y = 4, int z = 2) {
    return embedded_block(Lattice{{x, y, z}, {0.01 * x, 0.01 * y, 0.01 * z}});
}

/// A displacement field without symmetry. size_m: amplitude [m].
NodeField crooked(const SpringMesh& mesh, double size_m) {
    NodeField u(mesh.node_count(), 3);
    for (int i = 0; i < mesh.node_count(); ++i)
        for (int d = 0; d < 3; ++d) u(i, d) = size_m * std::sin(1.7 * i + 0.9 * d * d + 0.3);
    return u;
}

/// One point of different stiffness under the top of block().
NodeField nodule() {
    NodeField points(1, 4);
    points << 0.03, 0.03, 0.01, 3e-6;
    return points;
}

EnergyModelTerms energy_model_on(const SpringMesh& mesh, const std::vector<std::string>& terms) {
    const Eigen::VectorXd E = Eigen::VectorXd::Constant(mesh.spring_count(), 4524), cells = Eigen::VectorXd::Constant(mesh_cells(mesh).rows(), 4524);
    EnergyModelHeuristic heuristic = solid_heuristic(mesh, E, cells, 4524, 12, 0.007);
    heuristic.ground = nodule();
    return {mesh, heuristic, terms};
}

const std::vector<std::string> some_terms = {"spring.all", "spring.face.top", "cell.all", "spring.upright", "contact.normal",
    "contact.normal.edge", "contact.tangent.ground", "contact.tangent", "contact.imprint_normal", "contact.imprint_tangent.edge", "contact.hardening", "contact.saturation", "contact.coupling"};

}  // namespace

TEST_CASE("volume cells have consistent energy and force and tangent; a rotation stores no energy", "[solid]") {
    const SpringMesh mesh = block(2, 2, 1);
    const CellVolumes cells(mesh);
    CHECK(cells.volumes().sum() == Approx(0.02 * 0.02 * 0.01).epsilon(tolerance::rounding));
    const NodeField u = crooked(mesh, 1e-3);
    for (int e = 0; e < cells.count(); ++e) {
        ElementVector force, before, after;
        ElementMatrix tangent;
        cells.force(e, u, force);
        cells.tangent(e, u, tangent);
        for (Eigen::Index k = 0; k < 24; ++k) {
            NodeField low = u, high = u;
            const double h = 1e-7;
            low(cells.nodes()(e, k / 3), k % 3) -= h;
            high(cells.nodes()(e, k / 3), k % 3) += h;
            CHECK(force[k] == Approx((cells.energy(e, high) - cells.energy(e, low)) / (2 * h)).epsilon(1e-6).margin(1e-12));
            cells.force(e, low, before);
            cells.force(e, high, after);
            CHECK((tangent.col(k) - (after - before) / (2 * h)).norm() < 1e-6 * tangent.norm());
        }
    }
    Eigen::Matrix3d turn;
    turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
    const NodeField turned = mesh.nodes * turn.transpose() - mesh.nodes;
    for (int e = 0; e < cells.count(); ++e) CHECK(std::abs(cells.energy(e, turned)) < 1e-25);
    CHECK(cells.volume_ratio(0, 0.1 * mesh.nodes) == Approx(1.331).epsilon(tolerance::rounding));
}

TEST_CASE("a disc's profile is 1 at its centre and 1/2 at its edge; far away it is a point force's", "[solid]") {
    CHECK(disc_profile(0) == 1);
    CHECK(disc_profile(1) == Approx(0.5));
    CHECK(disc_profile(1 + 1e-9) == Approx(0.5).epsilon(1e-4));
    CHECK(disc_profile(100) == Approx(4 / (3 * 3.14159265358979 * 100)).epsilon(1e-4));  // a point force
}

TEST_CASE("a disc's inclusion factor is 1 on a half space of unit log stiffness and falls away from an inclusion", "[long]") {
    const SpringMesh mesh = block(6, 6, 2);
    const double radius_m = 0.007, step_m = 0.004;
    const Eigen::Vector3d at(0.0312, 0.0277, 0.02), down(0, 0, -1);
    constexpr int side = 150, deep = 75;
    NodeField half_space(side * side * deep, 4);
    for (Eigen::Index i = 0; i < half_space.rows(); ++i) {
        const Eigen::Vector3d cell(static_cast<double>(i % side) - side / 2, static_cast<double>(i / side % side) - side / 2, -static_cast<double>(i / (side * side)) - 1);
        half_space.row(i) << (at + step_m * (cell + Eigen::Vector3d::Constant(0.5))).transpose(), std::pow(step_m, 3);
    }
    const DiscContact over_all(mesh, radius_m, {std::move(half_space)});
    // the rest of the half space is farther than 0.3 m
    CHECK(over_all.ground_at(at, down) == Approx(1 - 0.04).margin(0.01));
    CHECK(over_all.ground_at(at + Eigen::Vector3d(0, 0, -0.4), down) == 0);  // all points are behind the surface
    CHECK(DiscContact(mesh, radius_m).rows_at(at).factors[2] == 0);
    NodeField nodule(1, 4);
    nodule << 0.0312, 0.0277, 0.008, 2e-6;
    const DiscContact kernel(mesh, radius_m, {nodule});
    const double over = kernel.rows_at(at).factors[2], beside = kernel.rows_at(at + Eigen::Vector3d(0.008, 0, 0)).factors[2];
    CHECK(over == Approx(2e-6 * 8 * 0.007 / 9.8696044 * 0.000144 / std::pow(0.000193, 3)).epsilon(1e-6));
    CHECK(beside < 0.6 * over);
    CHECK(beside > 0);
}

TEST_CASE("forces of a hardening contact are derivatives of its energy; its tangents are those of the forces", "[solid]") {
    const SpringMesh mesh = block(6, 6, 2);
    const auto [curve, depth_m] = GENERATE(table<const char*, double>({{"hardening", 6e-3}, {"compression", 6e-3}, {"compression", -6e-3}}));
    std::vector<std::string> terms = some_terms;
    for (std::string& term : terms)
        if (term.find("hardening") != std::string::npos) term.replace(term.find("hardening"), 9, curve);
    const EnergyModelTerms model_terms = energy_model_on(mesh, terms);
    Eigen::VectorXd p = Eigen::VectorXd::LinSpaced(model_terms.size(), -0.4, 0.5);
    const ContactRows rows = DiscContact(mesh, 0.007, {nodule()}).rows_at(Eigen::Vector3d(0.0312, 0.0277, 0.02));
    const ContactSpring spring(rows, model_terms.patch(p));
    const Eigen::Vector3d push(1e-3, -2e-3, -depth_m);
    const Eigen::VectorXd u = spring.gather(crooked(mesh, 1e-3));
    const ContactSpring::Load load = spring.load(push, u);
    const double h = 1e-7;
    for (int d = 0; d < 3; ++d) {
        const Eigen::Vector3d by = h * Eigen::Vector3d::Unit(d);
        CHECK(load.tool_force_N[d] == Approx((spring.load(push + by, u).energy_J - spring.load(push - by, u).energy_J) / (2 * h)).epsilon(1e-6));
    }
    const Eigen::MatrixXd tangent = spring.tangent(push, u), hand_by = spring.tool_force_by_nodes(push, u), hand_by_push = spring.tool_force_by_push(push, u);
    for (int d = 0; d < 3; ++d) {
        const Eigen::Vector3d by = h * Eigen::Vector3d::Unit(d);
        CHECK((hand_by_push.col(d) - Eigen::VectorXd((spring.load(push + by, u).tool_force_N - spring.load(push - by, u).tool_force_N) / (2 * h))).norm() < 1e-6 * hand_by_push.norm());
    }
    for (Eigen::Index k = 0; k < u.size(); k += 5) {
        Eigen::VectorXd low = u, high = u;
        low[k] -= h;
        high[k] += h;
        const auto a = spring.load(push, low), b = spring.load(push, high);
        CHECK(load.node_N[k] == Approx((b.energy_J - a.energy_J) / (2 * h)).epsilon(1e-6).margin(1e-9));
        CHECK((tangent.col(k) - (b.node_N - a.node_N) / (2 * h)).norm() < 1e-6 * tangent.norm());
        CHECK((hand_by.col(k) - Eigen::VectorXd((b.tool_force_N - a.tool_force_N) / (2 * h))).norm() < 1e-6 * hand_by.norm());
    }
    const Eigen::MatrixXd by = model_terms.stiffness_by(p, rows.factors);
    for (Eigen::Index t = 0; t < p.size(); ++t) {
        Eigen::VectorXd low = p, high = p;
        low[t] -= 1e-6;
        high[t] += 1e-6;
        const auto a = ContactSpring(rows, model_terms.patch(low)).load(push, u), b = ContactSpring(rows, model_terms.patch(high)).load(push, u);
        Eigen::Vector3d hand = Eigen::Vector3d::Zero();
        Eigen::VectorXd node = Eigen::VectorXd::Zero(u.size());
        for (int m = 0; m < by.rows(); ++m) {
            const auto one = spring.by_parameter_row(m, push, u);
            hand += by(m, t) * one.tool_force_N;
            node += by(m, t) * one.node_N;
        }
        CHECK((hand - Eigen::Vector3d((b.tool_force_N - a.tool_force_N) / 2e-6)).norm() < 1e-6 * load.tool_force_N.norm());
        CHECK((node - (b.node_N - a.node_N) / 2e-6).norm() < 1e-6 * load.node_N.norm());
    }
}

TEST_CASE("a contact that hardens in compression is linear where the tool pulls or goes along the surface", "[solid]") {
    const SpringMesh mesh = block(6, 6, 2);
    const ContactRows rows = DiscContact(mesh, 0.007).rows_at(Eigen::Vector3d(0.0312, 0.0277, 0.02));
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * rows.nodes.size()));
    const auto stiffness = [&](const char* term, const Eigen::Vector3d& push) {
        ContactSpring spring(rows, energy_model_on(mesh, {term}).patch(Eigen::VectorXd::Zero(1)));
        spring.coupling_N_m2 = 0;
        return spring.load(push, rest).tool_force_N.dot(push) / push.squaredNorm();
    };
    const Eigen::Vector3d in(0, 0, -0.006), along(0.006, 0, 0);
    for (const Eigen::Vector3d& push : {Eigen::Vector3d(-in), along, Eigen::Vector3d(along - in)})
        CHECK(stiffness("contact.compression", push) == Approx(stiffness("contact.compression", 1e-6 * push)).epsilon(1e-9));
    CHECK(stiffness("contact.compression", in) == Approx(stiffness("contact.hardening", in)).epsilon(1e-9));
    CHECK(stiffness("contact.compression", in) > 1.05 * stiffness("contact.compression", 1e-6 * in));
    CHECK(stiffness("contact.hardening", -in) > 1.05 * stiffness("contact.compression", -in));
    CHECK_THROWS_WITH(energy_model_on(mesh, {"contact.compression", "contact.hardening"}), Catch::Matchers::Contains("`compression` replaces `hardening`"));
    CHECK_THROWS_WITH(energy_model_on(mesh, {"contact.softening", "contact.compression.edge"}), Catch::Matchers::Contains("or `softening`"));
}

TEST_CASE("an untrained disc on a lattice has the half space's stiffness for radii of 0.1 to 1.6 cube edges", "[solid][long]") {
    constexpr double E = 4524, h = 0.01;
    // of blocks, in edges; effects of floor and sides are proportional to 1 / size
    constexpr double sizes[] = {10, 14};
    std::vector<SpringMesh> meshes;
    for (const double n : sizes) meshes.push_back(embedded_lattice(solid_block(Lattice{{static_cast<int>(n), static_cast<int>(n), static_cast<int>(n / 2)}, {n * h, n * h, n / 2 * h}}), h));
    // beyond 1.6 blocks of 14 edges are too small for the extrapolation to the half space: error 5 % at 2.4
    for (const double times : {0.1, 0.3, 0.7, 1.0, 1.15, 1.6}) {
        const double R = times * h;
        for (const double tilt : {0.0, 1.0}) {
            const Eigen::Vector3d push = 1e-4 * h * (tilt > 0 ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d(0, 0, -1));
            double log_sum = 0, share_sum = 0;
            for (const double part : {0.0, 0.25, 0.5}) {
                double compliance[2], share = 0;
                for (const int k : {0, 1}) {
                    const SpringMesh& mesh = meshes[static_cast<std::size_t>(k)];
                    const EnergyModelHeuristic heuristic = solid_heuristic(mesh, Eigen::VectorXd::Constant(mesh.spring_count(), E), Eigen::VectorXd::Constant(mesh_cells(mesh).rows(), E), E, 12, R);
                    const EnergyModelTerms model_terms(mesh, heuristic, {"contact.normal"});
                    const TissueEnergy energy = model_terms.energy(mesh);
                    const DiscContact kernel(mesh, R);
                    EquilibriumSolver solver(energy, kernel);
                    const Eigen::VectorXd p = Eigen::VectorXd::Zero(1);
                    const ContactSpring contact(kernel.rows_at(Eigen::Vector3d((sizes[k] / 2 + part) * h, (sizes[k] / 2 + part) * h, sizes[k] / 2 * h)), model_terms.patch(p));
                    const EquilibriumState state = solver.indent(model_terms.constants(p), contact, push);
                    REQUIRE(state.status == SolverStatus::converged);
                    compliance[k] = push.norm() / state.contact_force_N.norm();
                    const Eigen::VectorXd stretch = contact.rows.push * push - contact.rows.pull * contact.gather(state.displacement);
                    share = contact.k_N_m.head(3).cwiseProduct(stretch.head(3)).norm() / state.contact_force_N.norm();
                }
                const double half_space = (sizes[1] * compliance[1] - sizes[0] * compliance[0]) / (sizes[1] - sizes[0]);
                const double ratio = 1 / half_space / (64.0 / 45 * E * R * (tilt > 0 ? 2.0 / 3 : 1));
                INFO("R = " << times << " h, " << part << " of an edge from a node, " << (tilt > 0 ? "along" : "into") << " the surface");
                CHECK(ratio == Approx(1).epsilon(0.08));
                log_sum += std::log(ratio), share_sum += share;
            }
            INFO("R = " << times << " h, " << (tilt > 0 ? "along" : "into") << " the surface");
            CHECK(std::exp(log_sum / 3) == Approx(1).epsilon(0.03));
            CHECK(share_sum / 3 == Approx(tilt > 0 ? 0.36 : 0.55).margin(0.03));
        }
    }
}

TEST_CASE("an indented solid hardens with depth and its implicit derivatives agree with finite differences", "[solid]") {
    const SpringMesh mesh = block(6, 6, 3);
    const EnergyModelTerms model_terms = energy_model_on(mesh, some_terms);
    const TissueEnergy energy = model_terms.energy(mesh);
    const DiscContact kernel(mesh, 0.007, {nodule()});
    EquilibriumSolver solver(energy, kernel);
    Eigen::VectorXd p = Eigen::VectorXd::LinSpaced(model_terms.size(), -0.2, 0.2);
    p[10] = 2;  // hardening, seven times its heuristic
    const Eigen::Vector3d at(0.0312, 0.0277, 0.03), push = 6e-3 * Eigen::Vector3d(0.3, 0.2, -1).normalized();
    const auto pressed = [&](const Eigen::VectorXd& q, const Eigen::Vector3d& d) {
        return solver.indent(model_terms.constants(q), ContactSpring(kernel.rows_at(at), model_terms.patch(q)), d);
    };
    const EquilibriumState half = pressed(p, push / 2), state = pressed(p, push);
    REQUIRE(half.status == SolverStatus::converged);
    REQUIRE(state.status == SolverStatus::converged);
    CHECK(state.contact_force_N.norm() > 2 * half.contact_force_N.norm());
    CHECK(state.contact_force_N.dot(push) > 0);
    const EquilibriumDerivative by = solver.derivative(model_terms.constants_by(p), model_terms.stiffness_by(p, kernel.rows_at(at).factors));
    for (Eigen::Index t = 0; t < p.size(); ++t) {
        Eigen::VectorXd low = p, high = p;
        low[t] -= 1e-4;
        high[t] += 1e-4;
        const EquilibriumState a = pressed(low, push), b = pressed(high, push);
        CHECK((by.contact_force.col(t) - Eigen::VectorXd((b.contact_force_N - a.contact_force_N) / 2e-4)).norm() < 1e-5 * state.contact_force_N.norm());
        const NodeField moved = (b.displacement - a.displacement) / 2e-4;
        CHECK((by.displacement.col(t) - as_vector(moved)).norm() < 1e-5 * state.displacement.norm());
    }
    // a solution at another contact in between makes a new matrix pattern; the result is the same
    solver.indent(model_terms.constants(p), ContactSpring(kernel.rows_at(Eigen::Vector3d(0.03, 0.04, 0.03)), model_terms.patch(p)), push);
    CHECK((pressed(p, push).displacement - state.displacement).norm() < 1e-9 * state.displacement.norm());
}

TEST_CASE("a block has the expected numbers of tetrahedra and facets and springs; its lattice has whole cubes", "[solid]") {
    const SpringMesh mesh = block(3, 2, 2);
    CHECK(mesh.embedding.node_count() == 4 * 3 * 3);
    CHECK(mesh.node_count() == 2 * 4 * 3 * 3);  // whole cubes: the lattice's nodes are at the block's
    CHECK(mesh.facets.rows() == 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2));
    CHECK(mesh.simplices.rows() == 6 * 12);
    CHECK(mesh.fixed.size() == 12);
    CHECK(mesh.node_measure.sum() == Approx(0.03 * 0.02 * 0.02).epsilon(tolerance::rounding));
    // edges, two diagonals of each face, four body diagonals of each cube
    const int edges = 3 * 9 + 2 * 12 + 2 * 12, faces = 2 * (3 * 2 * 3 + 3 * 2 * 3 + 2 * 2 * 4), bodies = 4 * 12;
    CHECK(mesh.spring_count() == edges + faces + bodies);
    CHECK(mesh.incident_measure.sum() == Approx(6 * mesh.node_measure.sum()).epsilon(tolerance::rounding));
    const Cells cells = mesh_cells(mesh);
    REQUIRE(cells.rows() == 12);
    for (int k = 0; k < 8; ++k)
        for (int d = 0; d < 3; ++d)
            CHECK(mesh.nodes(cells(0, k), d) == Approx((k >> d & 1) ? 0.01 : 0.0));
    CHECK_THROWS_WITH(make_lattice("embedded", 3, 3, 0.1, 0.1), Contains("topology 'embedded' is not possible on the lattice of a block"));
    for (const Lattice& lattice : {Lattice{{0, 1, 1}, {1, 1, 1}}, Lattice{{1, 1, 1}, {1, 0, 1}}})
        CHECK_THROWS_WITH(embedded_block(lattice), Contains("not possible"));
    CHECK_THROWS_AS(block(0, 1, 1), MismatchError);
}
