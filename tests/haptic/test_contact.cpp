#include <catch2/catch.hpp>
#include <cmath>

#include "haptic/contact.h"
#include "haptic/moving_outline.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

/// A square of `per_side` segments a side, counter-clockwise from its low corner.
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

TEST_CASE("no contact, master out, proxy out: the proxy follows the master and there is no force", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = proxy_at(-0.5, 0.5);
    CHECK(update_contact(outline, Eigen::Vector2d(-0.2, 0.7), state) == ContactRow::free);
    CHECK_FALSE(state.contact);
    CHECK_FALSE(state.pressing);
    CHECK(state.proxy_m == Eigen::Vector2d(-0.2, 0.7));
}

TEST_CASE("no contact, both out, but the way crosses the tissue: the proxy stays where it entered, without force", "[contact]") {
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

TEST_CASE("no contact, master out, proxy swallowed: the proxy is projected, and an outside master feels nothing", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = proxy_at(0.1, 0.5);
    CHECK(update_contact(outline, Eigen::Vector2d(-0.3, 0.5), state) == ContactRow::swallowed_left);
    CHECK((state.proxy_m - Eigen::Vector2d(0, 0.5)).norm() < 1e-15);
    CHECK_FALSE(state.pressing);
    CHECK(update_contact(outline, Eigen::Vector2d(-0.3, 0.5), state) == ContactRow::release);
    CHECK(state.proxy_m == Eigen::Vector2d(-0.3, 0.5));
}

TEST_CASE("no contact, master in, proxy out: the proxy stops at the crossing of deepest penetration", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = proxy_at(-0.5, 0.25);
    CHECK(update_contact(outline, Eigen::Vector2d(0.3, 0.25), state) == ContactRow::touch);
    CHECK(state.contact);
    CHECK(state.pressing);
    CHECK(state.where.facet == 3);
    CHECK(state.where.weight[1] == Approx(0.75));  // the left side runs downwards
    CHECK((state.proxy_m - outline.at(3, state.where.weight[1])).norm() == 0);
    CHECK((state.proxy_m - Eigen::Vector2d(0, 0.25)).norm() < 1e-15);

    // a bay: the way enters, leaves and enters again; the first entry penetrates deepest
    MovingOutline bay(8);
    const double x[] = {0, 3, 3, 2, 2, 1, 1, 0}, y[] = {0, 0, 2, 2, 1, 1, 2, 2};
    for (int b = 0; b < 8; ++b) bay.set(b, {x[b], y[b]});
    bay.refresh();
    ContactState across = proxy_at(-1, 1.5);
    CHECK(update_contact(bay, Eigen::Vector2d(2.5, 1.5), across) == ContactRow::touch);
    CHECK((across.proxy_m - Eigen::Vector2d(0, 1.5)).norm() < 1e-15);
}

TEST_CASE("no contact, the mesh swallows master and proxy: contact at the nearest surface", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = proxy_at(0.2, 0.9);
    CHECK(update_contact(outline, Eigen::Vector2d(0.25, 0.8), state) == ContactRow::swallowed);
    CHECK(state.pressing);
    CHECK(state.where.facet == 2);
    CHECK((state.proxy_m - Eigen::Vector2d(0.2, 1.0)).norm() < 1e-15);
}

TEST_CASE("contact, master out: released, and the proxy goes to the master", "[contact]") {
    const MovingOutline outline = square(0, 0, 1);
    ContactState state = in_contact(3, 0.5, {0, 0.5});
    CHECK(update_contact(outline, Eigen::Vector2d(-0.01, 0.5), state) == ContactRow::release);
    CHECK_FALSE(state.contact);
    CHECK_FALSE(state.pressing);
    CHECK(state.proxy_m == Eigen::Vector2d(-0.01, 0.5));
}

TEST_CASE("contact, master out, proxy swallowed: projected without force, released in the next tick", "[contact]") {
    const MovingOutline outline = square(-0.1, 0, 1);  // has moved left over the proxy
    ContactState state = in_contact(3, 0.5, {0, 0.5});
    CHECK(update_contact(outline, Eigen::Vector2d(-0.2, 0.5), state) == ContactRow::swallowed_release);
    CHECK((state.proxy_m - Eigen::Vector2d(-0.1, 0.5)).norm() < 1e-15);
    CHECK_FALSE(state.pressing);
    CHECK(update_contact(outline, Eigen::Vector2d(-0.2, 0.5), state) == ContactRow::release);
}

TEST_CASE("contact, master in: the proxy keeps its place on the surface, wherever the master slides", "[contact]") {
    MovingOutline outline = square(0, 0, 1);
    ContactState state = in_contact(3, 0.25, {0, 0.75});
    CHECK(update_contact(outline, Eigen::Vector2d(0.2, 0.1), state) == ContactRow::hold);
    CHECK(state.proxy_m == Eigen::Vector2d(0, 0.75));
    outline = square(0.05, 0.1, 1);  // yields to the right: the old proxy is outside
    CHECK(update_contact(outline, Eigen::Vector2d(0.2, 0.15), state) == ContactRow::hold);
    CHECK((state.proxy_m - Eigen::Vector2d(0.05, 0.85)).norm() < 1e-15);
    CHECK(state.where.facet == 3);
    CHECK(state.where.weight[1] == 0.25);
}

TEST_CASE("contact, master in, proxy swallowed: the same place on the surface is kept", "[contact]") {
    const MovingOutline outline = square(-0.1, 0, 1);
    ContactState state = in_contact(3, 0.5, {0, 0.5});
    CHECK(update_contact(outline, Eigen::Vector2d(0.2, 0.5), state) == ContactRow::hold_swallowed);
    CHECK((state.proxy_m - Eigen::Vector2d(-0.1, 0.5)).norm() < 1e-15);
    CHECK(state.where.weight[1] == 0.5);
    CHECK(state.pressing);
}

TEST_CASE("the eight rows of the table are eight", "[contact]") {
    int seen = 0;
    for (bool contact : {false, true})
        for (bool master : {false, true})
            for (bool proxy : {false, true}) seen |= 1 << static_cast<int>(contact_row(contact, master, proxy));
    CHECK(seen == 0xFF);
}

TEST_CASE("an outline is simple until it touches itself", "[outline]") {
    MovingOutline outline = square(0, 0, 1, 5);
    CHECK(outline.simple());
    const Eigen::Vector2d kept = outline.node(2);
    outline.set(2, {0.4, 1.2});  // a spike out through the top
    outline.refresh();
    CHECK_FALSE(outline.simple());
    outline.set(2, {0.4, 0.95});
    outline.refresh();
    CHECK(outline.simple());
    outline.set(2, kept + Eigen::Vector2d(-0.3, 0));  // folded back along its own side
    outline.refresh();
    CHECK_FALSE(outline.simple());
    MovingOutline inside_out(4);
    for (int b = 0; b < 4; ++b) inside_out.set(b, square(0, 0, 1).node(3 - b));
    inside_out.refresh();
    CHECK_FALSE(inside_out.simple());
}

TEST_CASE("inside, nearest and crossing agree with a square's geometry at random points", "[outline]") {
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

TEST_CASE("a proxy is never inside a simple outline that shakes, whatever the master does", "[contact][adversarial]") {
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
        // nodes jump by up to a third of a segment, and come back
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
        // fast, slow, tunnelling, at corners and on nodes exactly
        switch (draw.below(8)) {
            case 0: master = {draw(-1, 2), draw(-1, 2)}; break;
            case 1: master = {draw(-0.05, 0.05), draw(-0.05, 0.05)}; break;
            case 2: master = outline.node(draw.below(M)); break;
            case 3: master = outline.at(draw.below(M), 0.5); break;
            default: master += Eigen::Vector2d(draw(-0.1, 0.1), draw(-0.1, 0.1)); break;
        }
        // a proxy needs to have been outside once, as in the simulation
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
    for (long long count : row) CHECK(count > ticks / 100000);  // every row was met
}
