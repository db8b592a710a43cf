#pragma once

#include <cmath>

#include "mesh/facet_table.h"
#include "springs/disc_sizes.h"

namespace tissue {

/// What a disc reads of its place, of one model.
struct DiscTables {
    NodeField ground = {};       ///< what is of other stiffness than the block, as points (G x 4): place [m], volume times log(E / E_block) [m3]; often no rows
    Eigen::Vector2d curved_range = {-INFINITY, INFINITY};  ///< on an embedded lattice a contact's factor `curved` is clamped to this: least and most of the training contacts
    FacetTable correction = {};  ///< of an embedded lattice, by facet of the mesh: log of the contact's stiffness over the law's (springs/lattice_correction.h); often no rows
    double ball_contact_m = 0;   ///< of a ball the largest radius of its contact (springs/ball_contact.h); 0: a disc
    DiscSizes sizes = {};        ///< and corrections by radius
};

}  // namespace tissue
