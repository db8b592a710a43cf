#pragma once

#include <cmath>

#include "mesh/facet_table.h"
#include "springs/disc_sizes.h"

namespace tissue {

/// Tables of one model that a disc's contact evaluates at its place.
struct DiscTables {
    /// tissue of other stiffness than the block's, as points (G x 4): place [m], volume times log(E / E_block) [m3];
    /// may have no rows
    NodeField ground = {};
    /// on an embedded lattice the factor `curved` is clamped to this range: that of the training contacts
    Eigen::Vector2d curved_range = {-INFINITY, INFINITY};
    /// on an embedded lattice, per facet of the mesh: log factor on the contact's stiffness
    /// (springs/lattice_correction.h); may have no rows
    FacetTable correction = {};
    double ball_contact_m = 0;   ///< largest contact radius of a ball [m] (springs/ball_contact.h); 0: a disc
    DiscSizes sizes = {};        ///< disc radii and their corrections, for a ball's growing contact
};

}  // namespace tissue
