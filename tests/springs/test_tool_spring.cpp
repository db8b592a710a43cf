#include "springs/tool_spring.h"

#include <catch2/catch.hpp>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <memory>

#include "../mesh/embedded_block.h"
#include "../allocations.h"
#include "../haptic/haptic_example.h"
#include "../mesh/dome.h"
#include "../tolerances.h"
#include "mesh/embedded_lattice.h"
#include "springs/contact_patch.h"
#include "springs/contact_spring.h"
#include "springs/disc_contact.h"

using namespace tissue;

namespace {

SpringMesh solid(int x, int y, int z) { return embedded_block(Lattice{{x, y, z}, {0.01 * x, 0.01 * y, 0.01 * z}}); }

/// Contact parameters of a disc similar to those of block3: it hardens, and its stiffness depends on the place.
ContactParameters disc_parameters() {
    ContactParameters contact_parameters;
    contact_parameters.log_N_m.setZero(ContactParameters::disc_rows, 4);
    contact_parameters.log_N_m.col(0) << 3.2, 2.7, 1.1, 0.6, 4, 5, 7;
    contact_parameters.log_N_m.col(1) << 0.1, -0.2, 0.1, 0.05, 0.1, 0, 0.2;
    contact_parameters.log_N_m.col(2) << 0.5, 0.3, 0.2, 0.4, 0, 0, 0;
    contact_parameters.log_N_m.col(3) << -0.3, 0.2, 0.1, -0.1, 0.3, 0, 0;
    return contact_parameters;
}

ContactParameters plane_parameters() {
    ContactParameters contact_parameters;
    contact_parameters.log_N_m.col(0) << 3.2, 2.7, 1.1, 0.6;
    contact_parameters.log_N_m.col(1) << 0.1, -0.2, 0.1, 0.05;
    return contact_parameters;
}

NodeField some_ground() {
    NodeField ground(2, 4);
    ground << 0.02, 0.02, 0.01, 2e-7, 0.03, 0.025, 0.015, 3e-7;
    return ground;
}

NodeColumns some_displacement(const SpringMesh& mesh, Draw& draw) {
    NodeColumns u(mesh.node_count(), mesh.dimension());
    for (Eigen::Index i = 0; i < u.size(); ++i) u.data()[i] = draw(-2e-3, 2e-3);
    return u;
}

Eigen::Vector3d some_weight(Draw& draw, int corners) {
    Eigen::Vector3d w(draw(0, 1), draw(0, 1), corners == 3 ? draw(0, 1) : 0);
    return w / w.sum();
}

Point some_push(Draw& draw, int dimension) {
    Point push(dimension);
    for (int axis = 0; axis < dimension; ++axis) push[axis] = draw(-6e-3, 6e-3);
    return push;
}

/// Energy, tool force and nodal forces are those of ContactSpring, the contact in training.
void check_same(const ToolSpring& tool, const ContactSpring& spring, const NodeColumns& u, const Point& push) {
    const ContactSpring::Load load = spring.load(push, spring.gather(u));
    CHECK(tool.energy_J(push, u) == Approx(load.energy_J).epsilon(tolerance::rounding));
    NodeColumns f = NodeColumns::Zero(u.rows(), u.cols());
    const Point hand = tool.put_on(push, u, f);
    const double size = load.tool_force_N.norm() + load.node_N.norm();
    CHECK((hand - load.tool_force_N).norm() < tolerance::rounding * size);
    CHECK((tool.tool_force_N(push, u) - hand).norm() < tolerance::rounding * size);
    CHECK((spring.gather(f) - load.node_N).norm() < tolerance::rounding * size);
    CHECK(std::abs(f.norm() - load.node_N.norm()) < tolerance::rounding * size);  // no force on other nodes
}

/// Tool force, stiffness and the largest nodal force agree with finite differences of the energy.
void check_derivatives(const ToolSpring& tool, const NodeColumns& u, const Point& push) {
    const double h = 1e-7;
    const Point hand = tool.tool_force_N(push, u);
    const auto stiffness = tool.stiffness_N_m(push, u);
    for (Eigen::Index axis = 0; axis < push.size(); ++axis) {
        Point more = push, less = push;
        more[axis] += h;
        less[axis] -= h;
        CHECK((tool.energy_J(more, u) - tool.energy_J(less, u)) / (2 * h) == Approx(hand[axis]).margin(1e-5 * hand.norm()));
        CHECK(((tool.tool_force_N(more, u) - tool.tool_force_N(less, u)) / (2 * h) - stiffness.col(axis)).norm() < 1e-5 * stiffness.norm());
    }
    NodeColumns f = NodeColumns::Zero(u.rows(), u.cols());
    tool.put_on(push, u, f);
    Eigen::Index node = 0, axis = 0;
    f.cwiseAbs().maxCoeff(&node, &axis);
    NodeColumns more = u, less = u;
    more(node, axis) += h;
    less(node, axis) -= h;
    CHECK((tool.energy_J(push, more) - tool.energy_J(push, less)) / (2 * h) == Approx(f(node, axis)).epsilon(1e-5));
}

DiscTables some_tables(const SpringMesh& mesh) {
    return {some_ground(), {0.2, 0.3}, {NodeField::Random(mesh.facets.rows(), FacetTable::corner_count(3))}};
}

}  // namespace

TEST_CASE("a disc's contact in the tick has the energy and forces of the contact in training", "[solid][embedded]") {
    for (const SpringMesh& mesh : {solid(6, 5, 3), embedded_lattice(dome(6), 0.011)}) for (const ContactCurve curve : {ContactCurve::hardens, ContactCurve::compression}) {
        ContactParameters contact_parameters = disc_parameters();
        contact_parameters.curve = curve;
        DiscContact kernel(mesh, 0.007, some_tables(mesh));
        kernel.scale(Eigen::VectorXd::LinSpaced(mesh.node_count(), -0.2, 0.3));
        const FreeSurface surface(mesh);
        Draw draw(1);
        ToolSpring tool;
        int free = 0;
        for (int i = 0; i < 400; ++i) {
            const int facet = draw.below(static_cast<int>(mesh.facets.rows()));
            if (surface.free_of()[static_cast<std::size_t>(facet)] < 0) continue;
            ++free;
            const Eigen::Vector3d weight = some_weight(draw, 3);
            Eigen::Vector3d place = Eigen::Vector3d::Zero();
            for (int k = 0; k < 3; ++k) place += weight[k] * mesh.nodes.row(mesh.facets(facet, k)).transpose();
            kernel.tool_at(facet, weight, 0, contact_parameters, tool);
            const ContactSpring spring(kernel.rows_at(place), contact_parameters);
            const NodeColumns u = some_displacement(mesh, draw);
            const Point push = some_push(draw, 3);
            check_same(tool, spring, u, push);
            if (i < 20) check_derivatives(tool, u, push);
        }
        CHECK(free > 200);
    }
}

TEST_CASE("a patch's contact in the tick has the energy and forces of the contact in training", "[tool]") {
    const SpringMesh mesh = make_lattice("grid8", 10, 10, 0.1, 0.1);
    const ContactSurface kernel(mesh);
    const FreeSurface surface(mesh);
    Draw draw(2);
    ToolSpring tool;
    for (int i = 0; i < 200; ++i) {
        const int facet = draw.below(static_cast<int>(mesh.facets.rows()));
        if (surface.free_of()[static_cast<std::size_t>(facet)] < 0) continue;
        const Eigen::Vector3d weight = some_weight(draw, 2);
        const Point place = weight[0] * mesh.nodes.row(mesh.facets(facet, 0)).transpose() + weight[1] * mesh.nodes.row(mesh.facets(facet, 1)).transpose();
        kernel.tool_at(facet, weight, 0, plane_parameters(), tool);
        const NodeColumns u = some_displacement(mesh, draw);
        const Point push = some_push(draw, 2);
        check_same(tool, ContactSpring(kernel.rows_at(place), plane_parameters()), u, push);
        if (i < 20) check_derivatives(tool, u, push);
    }
}

TEST_CASE("push_at returns the tool displacement that has the given force", "[tool]") {
    const SpringMesh mesh = solid(6, 5, 3);
    const DiscContact kernel(mesh, 0.007);
    Draw draw(3);
    ToolSpring tool;
    for (int i = 0; i < 100; ++i) {
        kernel.tool_at(draw.below(static_cast<int>(mesh.facets.rows())), some_weight(draw, 3), 0, disc_parameters(), tool);
        const NodeColumns u = some_displacement(mesh, draw);
        // indented: there the coupling stiffens, and one displacement has the force
        const Point push = 5e-3 * (tool.inward() + 0.2 * Eigen::Vector3d(some_push(draw, 3) / 6e-3));
        const Point hand = tool.tool_force_N(push, u);
        CHECK((tool.tool_force_N(tool.push_at(hand, u), u) - hand).norm() < 1e-9 * hand.norm());
    }
}

TEST_CASE("on a fixed facet the contact is a wall as stiff as the nearest free contact and loads no node", "[solid]") {
    const SpringMesh mesh = solid(6, 5, 3);
    const DiscContact kernel(mesh, 0.007);
    const FreeSurface surface(mesh);
    ToolSpring tool, beside;
    int held = 0;
    const NodeColumns u = NodeColumns::Zero(mesh.node_count(), 3);
    for (int facet = 0; facet < mesh.facets.rows(); ++facet) {
        if (surface.free_of()[static_cast<std::size_t>(facet)] >= 0) continue;
        ++held;
        kernel.tool_at(facet, {0.2, 0.3, 0.5}, 0, disc_parameters(), tool);
        CHECK((tool.inward() - Eigen::Vector3d(0, 0, 1)).norm() < 1e-12);
        NodeColumns f = u;
        const Point hand = tool.put_on(Eigen::Vector3d(1e-3, 0, 2e-3), u, f);
        CHECK(f.isZero(0));
        CHECK(hand[2] == Approx(2 * hand[0]));
        const double k = tool.stiffness_N_m(Point::Zero(3), u)(2, 2);
        CHECK(k > 10);
        CHECK(k < 1000);
        // normal stiffness of all rows of the nearest contact while no node moves
        Point middle = Point::Zero(3);
        for (int node : mesh.facets.row(facet)) middle += mesh.nodes.row(node).transpose() / 3;
        const FreeSurface::Place place = surface.nearest(middle);
        const ContactSpring contact(kernel.rows_at(place.point_m), disc_parameters());
        const Eigen::Vector3d normal = contact.rows.push.row(0).transpose().normalized();
        CHECK(k == Approx(normal.dot(contact.rows.push.transpose() * contact.k_N_m.asDiagonal() * contact.rows.push * normal)).epsilon(1e-9));
    }
    CHECK(held == 60);
}

TEST_CASE("a contact in the tick is made and evaluated without allocation", "[solid][embedded]") {
    for (const SpringMesh& mesh : {solid(6, 5, 3), embedded_lattice(dome(6), 0.011)}) for (const ContactCurve curve : {ContactCurve::hardens, ContactCurve::compression}) {
        ContactParameters contact_parameters = disc_parameters();
        contact_parameters.curve = curve;
        const DiscContact kernel(mesh, 0.007, some_tables(mesh));
        const FreeSurface surface(mesh);
        ToolSpring tool;
        const NodeColumns u = NodeColumns::Zero(mesh.node_count(), 3);
        NodeColumns f = u;
        const Point push = Eigen::Vector3d(1e-3, 0, -2e-3);
        double sum = 0;
        const Allocations counted;
        for (int facet = 0; facet < mesh.facets.rows(); ++facet) {
            kernel.tool_at(facet, {0.2, 0.3, 0.5}, 0, contact_parameters, tool);
            sum += tool.put_on(push, u, f).norm() + tool.push_at(push, u).norm() + tool.stiffness_N_m(push, u).norm() + tool.energy_J(push, u);
            sum += surface.walk(facet, {0.2, 0.3, 0.5}, push).walked_m;
        }
        CHECK(Allocations::count() == 0);
        CHECK(sum > 0);
    }
}

TEST_CASE("show_at_most limits the tool force; the limited energy stays convex and consistent", "[tool][solid]") {
    for (const SpringMesh& mesh : {make_lattice("grid8", 10, 10, 0.1, 0.1), solid(6, 5, 3)}) {
        const int dimension = mesh.dimension();
        const std::unique_ptr<ContactKernel> kernel = dimension == 2 ? std::unique_ptr<ContactKernel>(new ContactSurface(mesh)) : std::make_unique<DiscContact>(mesh, 0.007);
        const FreeSurface surface(mesh);
        Draw draw(5);
        ToolSpring tool;
        int held_back = 0;
        for (int i = 0; i < 200; ++i) {
            const int facet = draw.below(static_cast<int>(mesh.facets.rows()));
            if (surface.free_of()[static_cast<std::size_t>(facet)] < 0) continue;
            kernel->tool_at(facet, some_weight(draw, dimension), 0, dimension == 2 ? plane_parameters() : disc_parameters(), tool);
            const NodeColumns u = 0.1 * some_displacement(mesh, draw);
            // the energy is convex there
            const auto some_inward = [&](double size_m) { return Point(size_m * (tool.inward() + some_push(draw, dimension) / 3e-2)); };
            tool.show_at_most(std::numeric_limits<double>::infinity());
            const Point push = some_inward(5e-3), whole = tool.tool_force_N(push, u);
            const double before_J = tool.energy_J(push, u), most = draw(0.3, 1.3) * whole.norm();
            tool.show_at_most(most);
            const Point shown = tool.tool_force_N(push, u);
            INFO(dimension << " axes, " << i << ": " << whole.norm() << " N, at most " << most);
            if (most >= whole.norm()) {
                CHECK(shown == whole);
                CHECK(tool.energy_J(push, u) == before_J);
                continue;
            }
            ++held_back;
            CHECK(shown.norm() == Approx(most).epsilon(2e-6));
            CHECK(tool.energy_J(push, u) < before_J);
            check_derivatives(tool, u, push);
            NodeColumns f = NodeColumns::Zero(u.rows(), u.cols());
            CHECK((tool.put_on(push, u, f) - shown).norm() < 1e-9 * most);
            for (int k = 0; k < 5; ++k) {  // the force of a convex energy is monotone along a displacement
                const Point other = some_inward(draw(3e-3, 7e-3));
                CHECK((tool.tool_force_N(other, u) - shown).dot(other - push) > -1e-5 * most * (other - push).norm());
            }
        }
        CHECK(held_back > 50);
    }
}
