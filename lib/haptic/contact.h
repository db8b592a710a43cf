#pragma once

#include <Eigen/Core>

#include "haptic/moving_surface.h"

namespace tissue {

/// Master and proxy of Sec. 4.2 with one surface, between ticks.
struct ContactState {
    bool contact = false;   ///< at the end of the last tick
    bool pressing = false;  ///< contact, and the master inside: only then is there a force. Tissue pushes, never pulls
    SurfacePlace where;     ///< facet and weights while in contact
    Point proxy_m;          ///< (D)
    bool has_proxy = false; ///< false before the first position: the proxy starts at the master

    void fields(StateBytes& state) noexcept { state(contact, pressing, where.facet, where.weight, where.position_m, where.distance_m, proxy_m, has_proxy); }
};

/// One row of the table: what was found, in the order of `ContactRow`'s bits.
enum class ContactRow {
    //                 contact before, master inside, proxy inside
    free,              // no   no   no   the proxy goes to the master, or to where its way enters the tissue
    swallowed_left,    // no   no   yes  the mesh moved over the proxy, the master is out of it: project, no force
    touch,             // no   yes  no   to the crossing of deepest penetration (16)-(17)
    swallowed,         // no   yes  yes  the mesh moved over both: project, contact
    release,           // yes  no   no   the paper leaves it out: contact ends, the proxy goes to the master
    swallowed_release, // yes  no   yes  the mesh moved over the proxy, the master left: project, no force
    hold,              // yes  yes  no   same facet, same weights: infinite friction
    hold_swallowed     // yes  yes  yes  the mesh moved over the proxy while pushed: the same
};

/// The row for a state: inside is meant of the surface as it is now, and of the proxy where the last tick left it.
ContactRow contact_row(bool contact_before, bool master_inside, bool proxy_inside) noexcept;

/// Sec. 4.2 for one tick: the surface has moved, the master has moved; where is the proxy? The surface must be simple.
/// Afterwards the proxy is outside or on the surface, and equals sum_k w(k) s(k) while in contact.
ContactRow update_contact(const MovingSurface& surface, const Point& master_m, ContactState& state) noexcept;

}  // namespace tissue
