#include "haptic/contact.h"

namespace tissue {
namespace {

/// A proxy less deep than this counts as outside, since rounding displaces one that lies on the surface.
constexpr double on_surface_m = 1e-9;

void put_on_surface(ContactState& state, const SurfacePlace& where) noexcept {
    state.contact = true;
    state.where = where;
    state.proxy_m = where.position_m;
}

}  // namespace

ContactRow contact_row(bool contact_before, bool master_inside, bool proxy_inside) noexcept {
    return static_cast<ContactRow>((contact_before ? 4 : 0) + (master_inside ? 2 : 0) + (proxy_inside ? 1 : 0));
}

ContactRow update_contact(const MovingSurface& surface, const Point& master_m, ContactState& state) noexcept {
    if (!state.has_proxy) {
        state.proxy_m = master_m;
        state.has_proxy = true;
    }
    const bool master_inside = surface.contains(master_m);
    const bool proxy_inside = surface.contains_strictly(state.proxy_m, on_surface_m);
    const ContactRow row = contact_row(state.contact, master_inside, proxy_inside);
    switch (row) {
        case ContactRow::free:
        case ContactRow::touch:
            if (const auto crossing = surface.first_crossing(state.proxy_m, master_m)) {
                put_on_surface(state, *crossing);
            } else if (master_inside) {
                put_on_surface(state, surface.nearest(state.proxy_m));  // rounding hid the crossing between two facets
            } else {
                state.proxy_m = master_m;
            }
            break;
        case ContactRow::hold:
        case ContactRow::hold_swallowed:
            state.where.position_m = surface.at(state.where.facet, state.where.weight);
            state.where.distance_m = (master_m - state.where.position_m).norm();
            state.proxy_m = state.where.position_m;
            break;
        case ContactRow::swallowed:
        case ContactRow::swallowed_left:
        case ContactRow::swallowed_release:
            put_on_surface(state, surface.nearest(state.proxy_m));
            break;
        case ContactRow::release:
            state.contact = false;
            state.proxy_m = master_m;
            break;
    }
    state.pressing = state.contact && master_inside;
    return row;
}

}  // namespace tissue
