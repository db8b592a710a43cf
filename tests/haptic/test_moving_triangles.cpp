#include "haptic/moving_triangles.h"

#include <catch2/catch.hpp>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "../mesh/embedded_block.h"
#include "../allocations.h"
#include "../refusal.h"
#include "../tolerances.h"
#include "error.h"
#include "haptic/contact.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

SpringMesh block(int x, int y, int z) { return embedded_block(Lattice{{x, y, z}, {0.01 * x, 0.01 * y, 0.01 * z}}); }

/// A mesh with its surface and the displacements of its nodes.
struct Body {
    SpringMesh mesh;
    MovingTriangles surface;
    NodeColumns u;

    explicit Body(const SpringMesh& of) : mesh(of), surface(of), u(NodeColumns::Zero(of.node_count(), 3)) {}
    Eigen::Vector3d node(int n) const { return (mesh.nodes.row(n) + u.row(n)).transpose(); }
    template <class Displacement>
    void move(const Displacement& of) {
        for (int n = 0; n < mesh.node_count(); ++n) u.row(n) = of(Eigen::Vector3d(mesh.nodes.row(n).transpose())).transpose();
        put(Eigen::Vector3d::Zero());
    }
    void put(const Eigen::Vector3d& place) { surface.move(place, NodeColumns(mesh.nodes), u); }

    /// Winding number of the surface about a point, as a sum of solid angles (Van Oosterom and Strackee 1983).
    double winding(const Eigen::Vector3d& p) const {
        double angle = 0;
        for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
            const Eigen::Vector3d a = node(mesh.facets(f, 0)) - p, b = node(mesh.facets(f, 1)) - p, c = node(mesh.facets(f, 2)) - p;
            angle += 2 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() + b.dot(c) * a.norm() + c.dot(a) * b.norm());
        }
        return angle / (4 * std::acos(-1.0));
    }
    /// Distance from the surface: the least distance from the faces and edges of all triangles.
    double away(const Eigen::Vector3d& p) const {
        double least = std::numeric_limits<double>::infinity();
        for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
            const Eigen::Vector3d a = node(mesh.facets(f, 0)), b = node(mesh.facets(f, 1)), c = node(mesh.facets(f, 2));
            const Eigen::Vector3d n = (b - a).cross(c - a).normalized(), on = p - n.dot(p - a) * n;
            const auto left = [&](const Eigen::Vector3d& i, const Eigen::Vector3d& j) { return (j - i).cross(on - i).dot(n) >= 0; };
            if (left(a, b) && left(b, c) && left(c, a)) least = std::min(least, (on - p).norm());
            for (const auto& [i, j] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
                const double w = std::min(1.0, std::max(0.0, (p - i).dot(j - i) / (j - i).squaredNorm()));
                least = std::min(least, (i + w * (j - i) - p).norm());
            }
        }
        return least;
    }
    /// Smallest fraction of the path from p to m at which it crosses a triangle; above 1 where it crosses none.
    double crossing(const Eigen::Vector3d& p, const Eigen::Vector3d& m) const {
        double first = 2;
        for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
            const Eigen::Vector3d a = node(mesh.facets(f, 0)), b = node(mesh.facets(f, 1)), c = node(mesh.facets(f, 2));
            const Eigen::Vector3d n = (b - a).cross(c - a);
            const double t = n.dot(a - p) / n.dot(m - p);
            if (!(t >= 0 && t <= 1)) continue;
            const Eigen::Vector3d x = p + t * (m - p);
            if ((b - a).cross(x - a).dot(n) >= 0 && (c - b).cross(x - b).dot(n) >= 0 && (a - c).cross(x - c).dot(n) >= 0) first = std::min(first, t);
        }
        return first;
    }
    bool looked_at_all() {
        bool simple = true;
        for (int tick = 0; tick < surface.ticks_to_look(); ++tick) simple = surface.simple();
        return simple;
    }
};

/// An indentation of width 1 cm, and a bending of the whole block.
Eigen::Vector3d pressed(const Eigen::Vector3d& x, const Eigen::Vector3d& at, double depth_m) {
    const double r2 = (x - at).squaredNorm(), held = std::min(1.0, x.z() / 0.02);
    return held * Eigen::Vector3d(0.003 * std::sin(80 * x.y()), 0.002 * std::sin(90 * x.x()), -depth_m * std::exp(-r2 / (2 * 0.01 * 0.01)));
}

Eigen::Vector3d some_point(Draw& draw, const Eigen::Vector3d& size, double beside_m) {
    return {draw(-beside_m, size.x() + beside_m), draw(-beside_m, size.y() + beside_m), draw(-beside_m, size.z() + beside_m)};
}

}  // namespace

TEST_CASE("the surface of a cube gives containment and nearest point and first crossing", "[solid]") {
    Body body(block(1, 1, 1));
    const MovingTriangles& cube = body.surface;
    CHECK(cube.triangles() == 12);
    CHECK(cube.contains(Eigen::Vector3d(0.005, 0.005, 0.005)));
    CHECK_FALSE(cube.contains(Eigen::Vector3d(0.005, 0.005, 0.0101)));
    CHECK_FALSE(cube.contains(Eigen::Vector3d(-0.001, 0.005, 0.005)));
    const SurfacePlace corner = cube.nearest(Eigen::Vector3d(0.013, 0.014, 0.01));
    CHECK(corner.distance_m == Approx(0.005));
    CHECK((corner.position_m - Eigen::Vector3d(0.01, 0.01, 0.01)).norm() < 1e-15);
    const auto entry = cube.first_crossing(Eigen::Vector3d(0.003, 0.004, 0.02), Eigen::Vector3d(0.003, 0.004, -0.02));
    REQUIRE(entry);
    CHECK((entry->position_m - Eigen::Vector3d(0.003, 0.004, 0.01)).norm() < 1e-15);
    CHECK(entry->distance_m == Approx(0.03));
    CHECK(entry->weight.minCoeff() >= 0);
    CHECK(entry->weight.sum() == Approx(1).epsilon(tolerance::rounding));
    CHECK((cube.at(entry->facet, entry->weight) - entry->position_m).norm() == 0);
    CHECK_FALSE(cube.first_crossing(Eigen::Vector3d(0.003, 0.004, 0.02), Eigen::Vector3d(0.003, 0.004, 0.011)));
    CHECK_FALSE(cube.first_crossing(Eigen::Vector3d(0.003, 0.004, 0.02), Eigen::Vector3d(0.003, 0.004, 0.02)));
    // From a point on the surface, a path inwards crosses the surface there, a path outwards does not.
    const auto in = cube.first_crossing(Eigen::Vector3d(0.003, 0.004, 0.01), Eigen::Vector3d(0.003, 0.004, 0.002));
    REQUIRE(in);
    CHECK(in->distance_m == Approx(0.008));
    CHECK_FALSE(cube.first_crossing(Eigen::Vector3d(0.003, 0.004, 0.01), Eigen::Vector3d(0.003, 0.004, 0.018)));
}

TEST_CASE("a mesh in the plane and an open surface have no moving triangles") {
    CHECK_THAT(refusal<MismatchError>([] { MovingTriangles(make_lattice("grid8", 2, 2, 1, 1)); }), Catch::Contains("in space"));
    SpringMesh open = block(1, 1, 1);
    open.facets.conservativeResize(open.facets.rows() - 1, 3);
    CHECK_THAT(refusal<MismatchError>([&] { MovingTriangles{open}; }), Catch::Contains("not closed at the edge"));
}

TEST_CASE("containment and nearest point and first crossing of a deformed block agree with a test of every triangle", "[solid]") {
    Body body(block(5, 4, 3));
    Draw draw(1);
    const Eigen::Vector3d size(0.05, 0.04, 0.03);
    for (double depth_m : {0.0, 0.004, 0.009}) {
        body.move([&](const Eigen::Vector3d& x) { return Eigen::Vector3d(pressed(x, {0.024, 0.021, 0.03}, depth_m) * (depth_m > 0)); });
        int inside = 0, crossed = 0;
        for (int i = 0; i < 1500; ++i) {
            Eigen::Vector3d p = some_point(draw, size, 0.01);
            if (i % 3 == 0) {  // near an edge or a node
                const int f = draw.below(static_cast<int>(body.mesh.facets.rows()));
                const double w = i % 6 == 0 ? 0 : draw(0, 1);
                p = (1 - w) * body.node(body.mesh.facets(f, 0)) + w * body.node(body.mesh.facets(f, 1)) + 1e-7 * some_point(draw, {1, 1, 1}, 1);
            }
            const double away = body.away(p);
            CHECK(body.surface.nearest(p).distance_m == Approx(away).margin(1e-15));
            if (away > 1e-12) CHECK(body.surface.contains(p) == (body.winding(p) > 0.5));
            inside += body.surface.contains(p);
            const Eigen::Vector3d m = some_point(draw, size, 0.01);
            const auto found = body.surface.first_crossing(p, m);
            const double first = body.crossing(p, m);
            REQUIRE(found.has_value() == (first <= 1));
            if (!found) continue;
            ++crossed;
            CHECK((found->position_m - (p + first * (m - p))).norm() < 1e-12);
            CHECK(found->distance_m == Approx((1 - first) * (m - p).norm()).margin(1e-12));
        }
        CHECK(inside > 100);
        CHECK(crossed > 500);
    }
}

TEST_CASE("a path into the tissue through a node or an edge is detected in any direction", "[solid]") {
    Body body(block(4, 3, 2));
    Draw draw(2);
    for (bool bent : {false, true}) {
        body.move([&](const Eigen::Vector3d& x) { return Eigen::Vector3d(pressed(x, {0.02, 0.015, 0.02}, 0.004) * bent); });
        for (Eigen::Index f = 0; f < body.mesh.facets.rows(); ++f)
            for (int k = 0; k < 3; ++k)
                for (double w : {0.0, 0.5, 1.0 / 3}) {
                    const Eigen::Vector3d on = (1 - w) * body.node(body.mesh.facets(f, k)) + w * body.node(body.mesh.facets(f, (k + 1) % 3));
                    for (int i = 0; i < 8; ++i) {
                        const Eigen::Vector3d inside = i == 0 ? Eigen::Vector3d(on.x(), 0.0151, 0.0101) : some_point(draw, {0.02, 0.01, 0.008}, 0) + Eigen::Vector3d(0.01, 0.01, 0.004);
                        if (body.winding(inside) < 0.5 || body.away(inside) < 1e-6) continue;
                        const Eigen::Vector3d outside = on + (on - inside).normalized() * 0.03;
                        if (std::abs(body.winding(outside)) > 0.5 || body.away(outside) < 1e-6) continue;
                        const auto found = body.surface.first_crossing(outside, inside);
                        REQUIRE(found);
                        CHECK(body.away(found->position_m) < 1e-12);
                        CHECK(body.surface.contains(inside));
                        CHECK_FALSE(body.surface.contains(outside));
                    }
                }
    }
    // The rays of contains() run along the first axis, here through edges and nodes of the sides.
    body.move([](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, 0); });
    for (double y : {0.005, 0.01, 0.02})
        for (double z : {0.005, 0.01}) {
            CHECK(body.surface.contains(Eigen::Vector3d(0.02, y, z)));
            CHECK_FALSE(body.surface.contains(Eigen::Vector3d(-0.02, y, z)));
            CHECK_FALSE(body.surface.contains(Eigen::Vector3d(0.06, y, z)));
        }
}

TEST_CASE("a point at the height of nodes and edges is contained exactly when it is inside the block", "[solid]") {
    for (const auto& cells : {std::array{4, 3, 2}, std::array{2, 5, 3}}) {
        Body body(block(cells[0], cells[1], cells[2]));
        body.put(Eigen::Vector3d::Zero());
        const Eigen::Vector3d low = body.mesh.nodes.colwise().minCoeff().transpose(), high = body.mesh.nodes.colwise().maxCoeff().transpose();
        int inside = 0;
        for (int i = 0; i < body.mesh.node_count(); ++i)
            for (int j = 0; j < body.mesh.node_count(); ++j) {
                const double y = body.mesh.nodes(i, 1), z = body.mesh.nodes(j, 2);
                if (y <= low.y() || y >= high.y() || z <= low.z() || z >= high.z()) continue;
                for (const double x : {low.x() - 0.001, low.x() + 0.001, body.mesh.nodes(i, 0) + 0.0003, high.x() - 0.001, high.x() + 0.001}) {
                    const bool wanted = x > low.x() && x < high.x();
                    REQUIRE(body.surface.contains(Eigen::Vector3d(x, y, z)) == wanted);
                    inside += wanted;
                }
            }
        CHECK(inside > 100);
    }
}

TEST_CASE("a fast or jumping tool is never inside thin oscillating tissue without a contact", "[solid]") {
    Body body(block(8, 8, 1));
    Draw draw(3);
    ContactState contact;
    Eigen::Vector3d tool(0.04, 0.04, 0.05), speed(0, 0, -0.002);
    int stopped = 0, inside = 0;
    for (int tick = 0; tick < 20000; ++tick) {
        const double swing = 0.004 * std::sin(0.05 * tick);
        body.move([&](const Eigen::Vector3d& x) { return Eigen::Vector3d(0, 0, swing * std::sin(60 * x.x()) * x.z() / 0.01); });
        const Eigen::Vector3d from = contact.has_proxy ? Eigen::Vector3d(contact.proxy_m) : tool;
        if (tick % 50 == 49) {
            tool = some_point(draw, {0.08, 0.08, 0.01}, 0.02);  // a jump
        } else {
            tool += speed;
            const double away = (tool - Eigen::Vector3d(0.04, 0.04, 0.005)).norm();
            if (draw.below(20) == 0 || away > 0.06) speed = 0.002 * ((Eigen::Vector3d(0.04, 0.04, 0.005) - tool).normalized() + 0.5 * some_point(draw, {0, 0, 0}, 1)).normalized();
        }
        const bool was_free = !contact.contact;
        const ContactRow row = update_contact(body.surface, tool, contact);
        if (body.winding(tool) > 0.5 && body.away(tool) > 1e-9) {
            ++inside;
            CHECK(contact.contact);
        }
        if (was_free && contact.contact) ++stopped;
        // A proxy that is still free has crossed nothing.
        if (was_free && !contact.contact && row == ContactRow::free) CHECK(body.crossing(from, tool) > 1);
        CHECK_FALSE(body.surface.contains_strictly(contact.proxy_m, 1e-9));
    }
    CHECK(stopped > 300);
    CHECK(inside > 500);
}

TEST_CASE("a surface in space is simple at rest and under indentation and translation and noise", "[solid]") {
    Body body(block(10, 10, 5));
    CHECK(body.surface.ticks_to_look() <= 256);
    CHECK(body.looked_at_all());
    body.move([](const Eigen::Vector3d& x) { return pressed(x, {0.05, 0.05, 0.05}, 0.02); });
    CHECK(body.looked_at_all());
    body.put({-0.3, 0.2, 0.1});
    CHECK(body.looked_at_all());
    Draw draw(4);
    body.move([&](const Eigen::Vector3d&) { return some_point(draw, {0, 0, 0}, 0.001); });
    CHECK(body.looked_at_all());
}

TEST_CASE("a self-intersection in space is found within one round of checks and cleared within another", "[solid]") {
    Body body(block(6, 6, 5));
    // the middle of the top is pulled through the bottom
    const auto through = [](const Eigen::Vector3d& x) {
        const bool middle = x.z() > 0.049 && std::abs(x.x() - 0.03) < 0.001 && std::abs(x.y() - 0.03) < 0.001;
        return Eigen::Vector3d(0, 0, middle ? -0.06 : 0);
    };
    // two neighbouring nodes of the top change places: only triangles with a common node intersect
    const auto folded = [](const Eigen::Vector3d& x) {
        const auto is = [&](double at) { return x.z() > 0.049 && std::abs(x.x() - at) < 0.001 && std::abs(x.y() - 0.03) < 0.001; };
        return Eigen::Vector3d(is(0.02) ? 0.013 : is(0.03) ? -0.012 : 0, 0, is(0.02) ? 0.002 : is(0.03) ? 0.0015 : 0);
    };
    const auto rest = [](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, 0); };
    for (int way = 0; way < 2; ++way) {
        INFO("case " << way);
        body.move(rest);
        CHECK(body.looked_at_all());
        way == 0 ? body.move(through) : body.move(folded);
        CHECK_FALSE(body.looked_at_all());
        for (int tick = 0; tick < 3 * body.surface.ticks_to_look(); ++tick) CHECK_FALSE(body.surface.simple());
        body.move(rest);
        CHECK(body.looked_at_all());
    }
    // In the constructor as well, where the surface crosses itself at rest.
    SpringMesh crossed = block(6, 6, 5);
    for (int n = 0; n < crossed.node_count(); ++n) crossed.nodes.row(n) += through(crossed.nodes.row(n).transpose()).transpose();
    CHECK_FALSE(MovingTriangles(crossed).simple());
}

TEST_CASE("self-intersections found so far are part of a surface's saved state", "[solid][state]") {
    const auto through = [](const Eigen::Vector3d& x) { return Eigen::Vector3d(0, 0, x.z() > 0.049 && (x.head<2>() - Eigen::Vector2d(0.03, 0.03)).norm() < 0.001 ? -0.06 : 0); };
    Body knows(block(6, 6, 5)), other(block(6, 6, 5));
    REQUIRE(knows.surface.ticks_to_look() > 3);
    knows.move(through);
    other.move(through);
    while (knows.looked_at_all()) {}
    StateBytes count = StateBytes::counting();
    knows.surface.fields(count);
    std::vector<std::byte> bytes(count.size());
    StateBytes write = StateBytes::writing(bytes.data()), read = StateBytes::reading(bytes.data());
    knows.surface.fields(write);
    other.surface.fields(read);
    for (int tick = 0; tick < 3 * knows.surface.ticks_to_look(); ++tick) CHECK_FALSE(other.surface.simple());
}

TEST_CASE("an inverted surface is found not simple by a single check", "[solid]") {
    Body body(block(3, 3, 2));
    CHECK(body.surface.simple());
    body.move([](const Eigen::Vector3d& x) { return Eigen::Vector3d(0, 0, -2 * x.z()); });
    CHECK_FALSE(body.surface.simple());
    body.move([](const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, 0); });
    CHECK(body.surface.simple());
}

TEST_CASE("two overlapping bodies contain points of each other", "[solid]") {
    Body one(block(3, 3, 2)), other(block(3, 3, 2));
    other.put({0.02, 0.01, 0.01});
    const SurfacePlace of_other = other.surface.nearest(Eigen::Vector3d(0.02, 0.01, 0.01));
    CHECK(one.surface.contains_strictly(of_other.position_m + Eigen::Vector3d(1e-6, 1e-6, 1e-6), 1e-9));
    CHECK(other.surface.contains_strictly(Eigen::Vector3d(0.0299, 0.0299, 0.0199), 1e-9));
    other.put({0.04, 0.01, 0.01});
    CHECK_FALSE(other.surface.contains(Eigen::Vector3d(0.0299, 0.0299, 0.0199)));
}

TEST_CASE("the operations of a tick on a surface in space allocate nothing", "[solid]") {
    Body body(block(5, 4, 3));
    const NodeColumns rest = body.mesh.nodes;
    const Point place = Eigen::Vector3d(0.1, 0, 0), above = Eigen::Vector3d(0.12, 0.02, 0.05), below = Eigen::Vector3d(0.121, 0.02, 0.01);
    int used = 0;
    const Allocations counted;
    body.surface.move(place, rest, body.u);
    used += body.surface.simple();
    used += body.surface.contains(below);
    used += body.surface.contains_strictly(below, 1e-9);
    used += body.surface.nearest(above).distance_m > 0;
    used += body.surface.first_crossing(above, below).has_value();
    CHECK(Allocations::count() == 0);
    CHECK(used == 5);
}
