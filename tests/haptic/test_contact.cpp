#include <catch2/catch.hpp>
#include <cmath>

#include "haptic/contact.h"
#include "haptic/moving_outline.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

/// A square of `per_side` segments per side, counter-clockwise from its lower left corner.
MovingOutline square(double low_x, double low_y, double size, int per_side = 1) {
    MovingOutline outline(4 * per_side);
    const double x[5] = {0, 1, 1, 0, 0}, y[5] = {0, 0, 1, 1, 0};
    for (int side = 0, b = 0; side < 4; ++side)
        for (int k = 0; k < per_side; ++k, ++b) {
            const double t = static_cast<double>(k) / per_side;
            outline.set(b, {low_x + size * (x[side] + t * (x[side + 1] - x[side])),
                            low_y + size * (y[side] + t * (y[side + 1] - y[side]))});
        }
    outline.refresh();
    return outline;
}

ContactState proxy_at(double x, double y) {
    ContactState state;
    state.proxy_m = Eigen::Vector2d(x, y);
    state.has_proxy = true;
    return state;
}

ContactState in_contact(int segment, double w, const Eigen::Vector2d& proxy) {
    ContactState state = proxy_at(proxy.x(), proxy.y());
    state.contact = true;
    state.where.facet = segment;
    state.where.weight << 1 - w, w, 0;
    return state;
}

}  // namespace

TEST_CASE("a free proxy follows a master outside the tissue without force", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = proxy_at(-0.5, 0.5);
    CHECK(update_contact(outline, Eigen::Vector2d(-0.2, 0.7), state) == ContactRow::free);
    CHECK_FALSE(state.contact);
    CHECK_FALSE(state.pressing);
    CHECK(state.proxy_m == Eigen::Vector2d(-0.2, 0.7));
}

TEST_CASE("a proxy whose path crosses the tissue stops at the entry without force and is released in the next tick", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = proxy_at(-0.5, 0.4);
    CHECK(update_contact(outline, Eigen::Vector2d(1.5, 0.4), state) == ContactRow::free);
    CHECK(state.contact);
    CHECK_FALSE(state.pressing);
    CHECK(state.where.facet == 3);  // left side: the crossing farthest from the master
    CHECK((state.proxy_m - Eigen::Vector2d(0, 0.4)).norm() < 1e-12);
    CHECK(update_contact(outline, Eigen::Vector2d(1.5, 0.4), state) == ContactRow::release);
    CHECK_FALSE(state.contact);
}

TEST_CASE("a mesh that moves over a free proxy projects it without force while the master is outside", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = proxy_at(0.1, 0.5);
    CHECK(update_contact(outline, Eigen::Vector2d(-0.3, 0.5), state) == ContactRow::swallowed_left);
    CHECK((state.proxy_m - Eigen::Vector2d(0, 0.5)).norm() < 1e-15);
    CHECK_FALSE(state.pressing);
    CHECK(update_contact(outline, Eigen::Vector2d(-0.3, 0.5), state) == ContactRow::release);
    CHECK(state.proxy_m == Eigen::Vector2d(-0.3, 0.5));
}

TEST_CASE("a master that enters the tissue leaves the proxy at the crossing of deepest penetration", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = proxy_at(-0.5, 0.25);
    CHECK(update_contact(outline, Eigen::Vector2d(0.3, 0.25), state) == ContactRow::touch);
    CHECK(state.contact);
    CHECK(state.pressing);
    CHECK(state.where.facet == 3);
    CHECK(state.where.weight[1] == Approx(0.75));  // the left side runs downwards
    CHECK((state.proxy_m - outline.at(3, state.where.weight[1])).norm() == 0);
    CHECK((state.proxy_m - Eigen::Vector2d(0, 0.25)).norm() < 1e-15);

    // A bay: the path enters, leaves and enters again. The first entry has the deepest penetration.
    MovingOutline bay(8);
    const double x[] = {0, 3, 3, 2, 2, 1, 1, 0}, y[] = {0, 0, 2, 2, 1, 1, 2, 2};
    for (int b = 0; b < 8; ++b) bay.set(b, {x[b], y[b]});
    bay.refresh();
    ContactState across = proxy_at(-1, 1.5);
    CHECK(update_contact(bay, Eigen::Vector2d(2.5, 1.5), across) == ContactRow::touch);
    CHECK((across.proxy_m - Eigen::Vector2d(0, 1.5)).norm() < 1e-15);
}

TEST_CASE("a mesh that moves over master and proxy makes a contact at the nearest surface point", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = proxy_at(0.2, 0.9);
    CHECK(update_contact(outline, Eigen::Vector2d(0.25, 0.8), state) == ContactRow::swallowed);
    CHECK(state.pressing);
    CHECK(state.where.facet == 2);
    CHECK((state.proxy_m - Eigen::Vector2d(0.2, 1.0)).norm() < 1e-15);
}

TEST_CASE("a master that leaves the tissue ends the contact and the proxy goes to it", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = in_contact(3, 0.5, {0, 0.5});
    CHECK(update_contact(outline, Eigen::Vector2d(-0.01, 0.5), state) == ContactRow::release);
    CHECK_FALSE(state.contact);
    CHECK_FALSE(state.pressing);
    CHECK(state.proxy_m == Eigen::Vector2d(-0.01, 0.5));
}

TEST_CASE("a proxy inside the mesh is projected without force after the master has left and released in the next tick", "[contact]") {
    const MovingOutline outline = square(-0.1, 0, 1);  // has moved left, over the proxy
    ContactState state = in_contact(3, 0.5, {0, 0.5});
    CHECK(update_contact(outline, Eigen::Vector2d(-0.2, 0.5), state) == ContactRow::swallowed_release);
    CHECK((state.proxy_m - Eigen::Vector2d(-0.1, 0.5)).norm() < 1e-15);
    CHECK_FALSE(state.pressing);
    CHECK(update_contact(outline, Eigen::Vector2d(-0.2, 0.5), state) == ContactRow::release);
}

TEST_CASE("in contact the proxy keeps its facet and weights while the master moves inside the tissue", "[contact]") {
    MovingOutline outline = square(0, 0, 1);
    ContactState state = in_contact(3, 0.25, {0, 0.75});
    CHECK(update_contact(outline, Eigen::Vector2d(0.2, 0.1), state) == ContactRow::hold);
    CHECK(state.proxy_m == Eigen::Vector2d(0, 0.75));
    outline = square(0.05, 0.1, 1);  // has moved right and up; the old proxy is outside
    CHECK(update_contact(outline, Eigen::Vector2d(0.2, 0.15), state) == ContactRow::hold);
    CHECK((state.proxy_m - Eigen::Vector2d(0.05, 0.85)).norm() < 1e-15);
    CHECK(state.where.facet == 3);
    CHECK(state.where.weight[1] == 0.25);
}

TEST_CASE("a mesh that moves over the proxy during contact keeps the same place on the surface", "[contact]") {
    const MovingOutline outline = square(-0.1, 0, 1);
    ContactState state = in_contact(3, 0.5, {0, 0.5});
    CHECK(update_contact(outline, Eigen::Vector2d(0.2, 0.5), state) == ContactRow::hold_swallowed);
    CHECK((state.proxy_m - Eigen::Vector2d(-0.1, 0.5)).norm() < 1e-15);
    CHECK(state.where.weight[1] == 0.5);
    CHECK(state.pressing);
}

TEST_CASE("the three contact conditions give eight distinct cases", "[contact]") {
    int seen = 0;
    for (bool contact : {false, true})
        for (bool master : {false, true})
            for (bool proxy : {false, true}) seen |= 1 << static_cast<int>(contact_row(contact, master, proxy));
    CHECK(seen == 0xFF);
}

TEST_CASE("an outline is not simple when it crosses itself or is inverted", "[outline]") {
    MovingOutline outline = square(0, 0, 1, 5);
    CHECK(outline.simple());
    const Eigen::Vector2d kept = outline.node(2);
    outline.set(2, {0.4, 1.2});  // a spike through the top
    outline.refresh();
    CHECK_FALSE(outline.simple());
    outline.set(2, {0.4, 0.95});
    outline.refresh();
    CHECK(outline.simple());
    outline.set(2, kept + Eigen::Vector2d(-0.3, 0));  // folded back onto its own side
    outline.refresh();
    CHECK_FALSE(outline.simple());
    MovingOutline inside_out(4);
    for (int b = 0; b < 4; ++b) inside_out.set(b, square(0, 0, 1).node(3 - b));
    inside_out.refresh();
    CHECK_FALSE(inside_out.simple());
}

TEST_CASE("containment and nearest distance of a square outline match its geometry at random points", "[outline]") {
    const MovingOutline outline = square(0, 0, 1, 7);
    Draw draw(1);
    for (int k = 0; k < 20000; ++k) {
        const Eigen::Vector2d p(draw(-0.5, 1.5), draw(-0.5, 1.5));
        const bool inside = p.x() > 0 && p.x() < 1 && p.y() > 0 && p.y() < 1;
        REQUIRE(outline.contains(p) == inside);
        const Eigen::Vector2d clamped = p.cwiseMax(0.0).cwiseMin(1.0);
        const double distance = inside ? std::min(std::min(p.x(), 1 - p.x()), std::min(p.y(), 1 - p.y())) : (p - clamped).norm();
        REQUIRE(outline.nearest(p).distance_m == Approx(distance).margin(1e-14));
    }
}

TEST_CASE("the proxy is never inside a randomly deformed simple outline for any motion of the master", "[contact][adversarial]") {
    Draw draw(2008);
    const int per_side = 5, M = 4 * per_side;
    const MovingOutline rest = square(0, 0, 1, per_side);
    MovingOutline outline = rest;
    std::vector<Eigen::Vector2d> shift(static_cast<std::size_t>(M), Eigen::Vector2d::Zero());
    ContactState state;
    Eigen::Vector2d master(-1, -1);
    const long long ticks = adversarial_ticks(400000);
    long long inside = 0, bad_weight = 0, folded = 0, off_surface = 0, row[8] = {};
    for (long long k = 0; k < ticks; ++k) {
        // Nodes are displaced randomly, by up to 0.3 of a segment per tick and axis; the displacement decays.
        for (int b = 0; b < M; ++b) {
            Eigen::Vector2d& s = shift[static_cast<std::size_t>(b)];
            s = 0.9 * s + Eigen::Vector2d(draw(-0.06, 0.06), draw(-0.06, 0.06));
            outline.set(b, rest.node(b) + s);
        }
        outline.refresh();
        if (!outline.simple()) {
            ++folded;
            state = {};
            continue;
        }
        // Random positions, near a corner, exactly on a node, on the middle of a segment, and random steps.
        switch (draw.below(8)) {
            case 0: master = {draw(-1, 2), draw(-1, 2)}; break;
            case 1: master = {draw(-0.05, 0.05), draw(-0.05, 0.05)}; break;
            case 2: master = outline.node(draw.below(M)); break;
            case 3: master = outline.at(draw.below(M), 0.5); break;
            default: master += Eigen::Vector2d(draw(-0.1, 0.1), draw(-0.1, 0.1)); break;
        }
        // The proxy must have been outside once, as in a session.
        if (!state.has_proxy && outline.contains(master)) continue;
        ++row[static_cast<int>(update_contact(outline, master, state))];
        inside += outline.contains_strictly(state.proxy_m, 1e-9);
        bad_weight += state.contact && !(state.where.weight[1] >= 0 && state.where.weight[1] <= 1);
        off_surface += state.contact && (outline.at(state.where.facet, state.where.weight[1]) - state.proxy_m).norm() > 1e-15;
        REQUIRE(state.proxy_m.allFinite());
        REQUIRE((!state.pressing || outline.contains(master)));
    }
    CHECK(inside == 0);
    CHECK(bad_weight == 0);
    CHECK(off_surface == 0);
    CHECK(folded < ticks / 2);
    for (long long count : row) CHECK(count > ticks / 100000);  // every case occurred
}
