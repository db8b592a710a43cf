#pragma once

#include <Eigen/Core>

#include "haptic/moving_surface.h"

namespace tissue {

/// State of the contact between the proxy of Sec. 4.2 and one surface, between ticks.
struct ContactState {
    bool contact = false;   ///< at the end of the last tick
    /// There is a force only while this is true, since tissue never pulls the tool. update_contact() sets it where
    /// there is a contact and the master is inside. On an energy model the session sets it from the sign of the force.
    bool pressing = false;
    SurfacePlace where;     ///< place of the contact, while there is one
    Point proxy_m;          ///< (D)
    bool has_proxy = false; ///< false before the first position; the proxy starts at the master

    void fields(StateBytes& state) noexcept { state(contact, pressing, where.facet, where.weight, where.position_m, where.distance_m, proxy_m, has_proxy); }
};

/// The cases of Sec. 4.2: three conditions and what follows. A value is 4 (contact before) + 2 (master inside) +
/// (proxy inside). "Project": the proxy goes to the nearest place of the surface.
enum class ContactRow {
    //                 contact before, master inside, proxy inside
    free,              // no   no   no   the proxy goes to the master, or to the point where its path enters the tissue
    swallowed_left,    // no   no   yes  the mesh moved over the proxy, the master is outside: project, no force
    touch,             // no   yes  no   the proxy goes to the crossing of deepest penetration, (16)-(17)
    swallowed,         // no   yes  yes  the mesh moved over both: project, contact
    release,           // yes  no   no   not in the paper: contact ends, the proxy goes to the master
    swallowed_release, // yes  no   yes  the mesh moved over the proxy, the master left: project, no force
    hold,              // yes  yes  no   same facet and same weights: infinite friction
    hold_swallowed     // yes  yes  yes  the mesh moved over the proxy during the indentation: as `hold`
};

/// The case for three conditions. `master_inside` and `proxy_inside` refer to the surface of this tick. The proxy is
/// that of the last tick.
ContactRow contact_row(bool contact_before, bool master_inside, bool proxy_inside) noexcept;

/// Sec. 4.2 for one tick: places the proxy after the surface and the master have moved. master_m: (D). The surface must
/// be simple. Afterwards the proxy is outside or on the surface, and equals sum_k w(k) s(k) while in contact.
ContactRow update_contact(const MovingSurface& surface, const Point& master_m, ContactState& state) noexcept;

}  // namespace tissue
