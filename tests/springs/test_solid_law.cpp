#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "../mesh/embedded_block.h"
#include "error.h"
#include "mesh/embedded_lattice.h"
#include "mesh/solid_block.h"
#include "mesh/topology.h"
#include "springs/cell_volumes.h"
#include "springs/disc_contact.h"
#include "springs/energy_law.h"
#include "springs/heuristic.h"
#include "springs/law_press.h"
#include "../tolerances.h"

using namespace tissue;
using Approx = Catch::Detail::Approx;
using Catch::Matchers::Contains;

namespace {

SpringMesh block(int x = 4, int y = 4, int z = 2) {
    return embedded_block(Lattice{{x, y, z}, {0.01 * x, 0.01 * y, 0.01 * z}});
}

/// A field without any symmetry, of a size [m].
NodeField crooked(const SpringMesh& mesh, double size_m) {
    NodeField u(mesh.node_count(), 3);
    for (int i = 0; i < mesh.node_count(); ++i)
        for (int d = 0; d < 3; ++d) u(i, d) = size_m * std::sin(1.7 * i + 0.9 * d * d + 0.3);
    return u;
}

/// One point of other stiffness under the top of block().
NodeField nodule() {
    NodeField points(1, 4);
    points << 0.03, 0.03, 0.01, 3e-6;
    return points;
}

EnergyLaw law_on(const SpringMesh& mesh, const std::vector<std::string>& terms) {
    const Eigen::VectorXd E = Eigen::VectorXd::Constant(mesh.spring_count(), 4524), cells = Eigen::VectorXd::Constant(mesh_cells(mesh).rows(), 4524);
    LawHeuristic heuristic = solid_heuristic(mesh, E, cells, 4524, 12, 0.007);
    heuristic.ground = nodule();
    return {mesh, heuristic, terms};
}

const std::vector<std::string> some_terms = {"spring.all", "spring.face.top", "cell.all", "spring.upright", "contact.normal",
    "contact.normal.edge", "contact.tangent.ground", "contact.tangent", "contact.imprint_normal", "contact.imprint_tangent.edge", "contact.hardening", "contact.saturation", "contact.coupling"};

}  // namespace

TEST_CASE("cells in space keep their volume: energy, force and tangent agree, and a rotation costs nothing", "[solid]") {
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

TEST_CASE("a disc presses a parabola in, and beside it what the half space has", "[solid]") {
    CHECK(disc_profile(0) == 1);
    CHECK(disc_profile(1) == Approx(0.5));
    CHECK(disc_profile(1 + 1e-9) == Approx(0.5).epsilon(1e-4));
    CHECK(disc_profile(100) == Approx(4 / (3 * 3.14159265358979 * 100)).epsilon(1e-4));  // a force on a point
}

TEST_CASE("a disc's ground is 1 on a half space of one log of stiffness, 0 on none, and falls with the way to a nodule", "[long]") {
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
    CHECK(over_all.ground_at(at, down) == Approx(1 - 0.04).margin(0.01));  // what is left lies farther away than 0.3 m
    CHECK(over_all.ground_at(at + Eigen::Vector3d(0, 0, -0.4), down) == 0);  // all behind it
    CHECK(DiscContact(mesh, radius_m).rows_at(at).factors[2] == 0);
    NodeField nodule(1, 4);
    nodule << 0.0312, 0.0277, 0.008, 2e-6;
    const DiscContact kernel(mesh, radius_m, {nodule});
    const double over = kernel.rows_at(at).factors[2], beside = kernel.rows_at(at + Eigen::Vector3d(0.008, 0, 0)).factors[2];
    CHECK(over == Approx(2e-6 * 8 * 0.007 / 9.8696044 * 0.000144 / std::pow(0.000193, 3)).epsilon(1e-6));
    CHECK(beside < 0.6 * over);
    CHECK(beside > 0);
}

TEST_CASE("a contact that hardens derives from its energy, and its derivatives are those of its force", "[solid]") {
    const SpringMesh mesh = block(6, 6, 2);
    const EnergyLaw law = law_on(mesh, some_terms);
    Eigen::VectorXd p = Eigen::VectorXd::LinSpaced(law.size(), -0.4, 0.5);
    const ContactRows rows = DiscContact(mesh, 0.007, {nodule()}).rows_at(Eigen::Vector3d(0.0312, 0.0277, 0.02));
    const ContactSpring spring(rows, law.patch(p));
    const Eigen::Vector3d push(1e-3, -2e-3, -6e-3);
    const Eigen::VectorXd u = spring.gather(crooked(mesh, 1e-3));
    const ContactSpring::Load load = spring.load(push, u);
    const double h = 1e-7;
    for (int d = 0; d < 3; ++d) {
        const Eigen::Vector3d by = h * Eigen::Vector3d::Unit(d);
        CHECK(load.hand_N[d] == Approx((spring.load(push + by, u).energy_J - spring.load(push - by, u).energy_J) / (2 * h)).epsilon(1e-6));
    }
    const Eigen::MatrixXd tangent = spring.tangent(push, u), hand_by = spring.hand_by_nodes(push, u);
    for (Eigen::Index k = 0; k < u.size(); k += 5) {
        Eigen::VectorXd low = u, high = u;
        low[k] -= h;
        high[k] += h;
        const auto a = spring.load(push, low), b = spring.load(push, high);
        CHECK(load.node_N[k] == Approx((b.energy_J - a.energy_J) / (2 * h)).epsilon(1e-6).margin(1e-9));
        CHECK((tangent.col(k) - (b.node_N - a.node_N) / (2 * h)).norm() < 1e-6 * tangent.norm());
        CHECK((hand_by.col(k) - Eigen::VectorXd((b.hand_N - a.hand_N) / (2 * h))).norm() < 1e-6 * hand_by.norm());
    }
    const Eigen::MatrixXd by = law.stiffness_by(p, rows.factors);
    for (Eigen::Index t = 0; t < p.size(); ++t) {
        Eigen::VectorXd low = p, high = p;
        low[t] -= 1e-6;
        high[t] += 1e-6;
        const auto a = ContactSpring(rows, law.patch(low)).load(push, u), b = ContactSpring(rows, law.patch(high)).load(push, u);
        Eigen::Vector3d hand = Eigen::Vector3d::Zero();
        Eigen::VectorXd node = Eigen::VectorXd::Zero(u.size());
        for (int m = 0; m < by.rows(); ++m) {
            const auto one = spring.by_law_row(m, push, u);
            hand += by(m, t) * one.hand_N;
            node += by(m, t) * one.node_N;
        }
        CHECK((hand - Eigen::Vector3d((b.hand_N - a.hand_N) / 2e-6)).norm() < 1e-6 * load.hand_N.norm());
        CHECK((node - (b.node_N - a.node_N) / 2e-6).norm() < 1e-6 * load.node_N.norm());
    }
}

TEST_CASE("a disc's untrained contact on a lattice is as stiff as on the tissue, from a tenth of a cube's edge to 1.6, wherever it stands between the nodes", "[solid][long]") {
    constexpr double E = 4524, h = 0.01;
    constexpr double sizes[] = {10, 14};  // of blocks, in edges; what floor and sides are worth goes with 1 / size
    std::vector<SpringMesh> meshes;
    for (const double n : sizes) meshes.push_back(embedded_lattice(solid_block(Lattice{{static_cast<int>(n), static_cast<int>(n), static_cast<int>(n / 2)}, {n * h, n * h, n / 2 * h}}), h));
    for (const double times : {0.1, 0.3, 0.7, 1.0, 1.15, 1.6}) {  // beyond, blocks of 14 edges are too small for the half space to be read off them: 5 % at 2.4
        const double R = times * h;
        for (const double tilt : {0.0, 1.0}) {
            const Eigen::Vector3d push = 1e-4 * h * (tilt > 0 ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d(0, 0, -1));
            double log_sum = 0, share_sum = 0;
            for (const double part : {0.0, 0.25, 0.5}) {
                double compliance[2], share = 0;
                for (const int k : {0, 1}) {
                    const SpringMesh& mesh = meshes[static_cast<std::size_t>(k)];
                    const LawHeuristic heuristic = solid_heuristic(mesh, Eigen::VectorXd::Constant(mesh.spring_count(), E), Eigen::VectorXd::Constant(mesh_cells(mesh).rows(), E), E, 12, R);
                    const EnergyLaw law(mesh, heuristic, {"contact.normal"});
                    const TissueEnergy energy = law.energy(mesh);
                    const DiscContact kernel(mesh, R);
                    PressSolver solver(energy, kernel);
                    const Eigen::VectorXd p = Eigen::VectorXd::Zero(1);
                    const ContactSpring contact(kernel.rows_at(Eigen::Vector3d((sizes[k] / 2 + part) * h, (sizes[k] / 2 + part) * h, sizes[k] / 2 * h)), law.patch(p));
                    const PressState state = solver.press(law.constants(p), contact, push);
                    REQUIRE(state.status == PressStatus::held);
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

TEST_CASE("a pressed solid rests in balance, harder the deeper, and its derivatives are those of its rest", "[solid]") {
    const SpringMesh mesh = block(6, 6, 3);
    const EnergyLaw law = law_on(mesh, some_terms);
    const TissueEnergy energy = law.energy(mesh);
    const DiscContact kernel(mesh, 0.007, {nodule()});
    PressSolver solver(energy, kernel);
    Eigen::VectorXd p = Eigen::VectorXd::LinSpaced(law.size(), -0.2, 0.2);
    p[10] = 2;  // hardens, by seven times its heuristic
    const Eigen::Vector3d at(0.0312, 0.0277, 0.03), push = 6e-3 * Eigen::Vector3d(0.3, 0.2, -1).normalized();
    const auto pressed = [&](const Eigen::VectorXd& q, const Eigen::Vector3d& d) {
        return solver.press(law.constants(q), ContactSpring(kernel.rows_at(at), law.patch(q)), d);
    };
    const PressState half = pressed(p, push / 2), state = pressed(p, push);
    REQUIRE(half.status == PressStatus::held);
    REQUIRE(state.status == PressStatus::held);
    CHECK(state.contact_force_N.norm() > 2 * half.contact_force_N.norm());
    CHECK(state.contact_force_N.dot(push) > 0);
    const PressDerivative by = solver.derivative(law.constants_by(p), law.stiffness_by(p, kernel.rows_at(at).factors));
    for (Eigen::Index t = 0; t < p.size(); ++t) {
        Eigen::VectorXd low = p, high = p;
        low[t] -= 1e-4;
        high[t] += 1e-4;
        const PressState a = pressed(low, push), b = pressed(high, push);
        CHECK((by.contact_force.col(t) - Eigen::VectorXd((b.contact_force_N - a.contact_force_N) / 2e-4)).norm() < 1e-5 * state.contact_force_N.norm());
        const NodeField moved = (b.displacement - a.displacement) / 2e-4;
        CHECK((by.displacement.col(t) - as_vector(moved)).norm() < 1e-5 * state.displacement.norm());
    }
    // with another contact in between the pattern is laid out anew, and comes back to the same
    solver.press(law.constants(p), ContactSpring(kernel.rows_at(Eigen::Vector3d(0.03, 0.04, 0.03)), law.patch(p)), push);
    CHECK((pressed(p, push).displacement - state.displacement).norm() < 1e-9 * state.displacement.norm());
}

TEST_CASE("a block divides into tetrahedra that fit, its surface is closed, and its lattice has whole cubes", "[solid]") {
    const SpringMesh mesh = block(3, 2, 2);
    CHECK(mesh.embedding.node_count() == 4 * 3 * 3);
    CHECK(mesh.node_count() == 2 * 4 * 3 * 3);  // whole cubes: the lattice's nodes stand where the block's do
    CHECK(mesh.facets.rows() == 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2));
    CHECK(mesh.simplices.rows() == 6 * 12);
    CHECK(mesh.fixed.size() == 12);
    CHECK(mesh.node_measure.sum() == Approx(0.03 * 0.02 * 0.02).epsilon(tolerance::rounding));
    // edges, both diagonals of every face, four of every body
    const int edges = 3 * 9 + 2 * 12 + 2 * 12, faces = 2 * (3 * 2 * 3 + 3 * 2 * 3 + 2 * 2 * 4), bodies = 4 * 12;
    CHECK(mesh.spring_count() == edges + faces + bodies);
    CHECK(mesh.incident_measure.sum() == Approx(6 * mesh.node_measure.sum()).epsilon(tolerance::rounding));
    const Cells cells = mesh_cells(mesh);
    REQUIRE(cells.rows() == 12);
    for (int k = 0; k < 8; ++k)
        for (int d = 0; d < 3; ++d)
            CHECK(mesh.nodes(cells(0, k), d) == Approx((k >> d & 1) ? 0.01 : 0.0));
    CHECK_THROWS_WITH(make_lattice("embedded", 3, 3, 0.1, 0.1), Contains("topology 'embedded' follows no lattice of a block"));
    for (const Lattice& lattice : {Lattice{{0, 1, 1}, {1, 1, 1}}, Lattice{{1, 1, 1}, {1, 0, 1}}})
        CHECK_THROWS_WITH(embedded_block(lattice), Contains("not possible"));
    CHECK_THROWS_AS(block(0, 1, 1), MismatchError);
}
