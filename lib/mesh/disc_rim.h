#pragma once

#include "mesh/surface.h"
#include "mesh/surface_remesh.h"

namespace tissue {

/// Where and how a disc presses, and how finely.
struct DiscRim {
    Eigen::Vector3d contact_m;
    double radius_m;
    double near_m, far_m;  ///< sides within radius_m + 2 mm of the contact, and far away
};

/// The wanted sides about a contact on the surface.
SideLength side_length(const DiscRim& disc, const Eigen::Vector3d& contact_m);

/// A surface of finite elements for a disc: graded triangles, the contact (the surface's nearest point) a node, and the
/// rim |x - contact| = radius a closed line of sides, inside which triangles have the label disc.
struct RimmedSurface {
    Surface surface;
    Eigen::Vector3d contact_m;
    double least_quality;  ///< of its triangles
};

/// If keeping edges that turn by more than 40 degrees leaves a triangle of quality below 0.1, as short ones of a segmentation do, the whole surface is divided again
/// without keeping them, and that is taken where it encloses the same volume to 0.3 %.
/// Throws MismatchError: a contact farther than two radii from the surface, a disc over the held part, one that covers the
/// surface or is no patch with one rim, a surface that has no triangles of quality 0.1 there; a size that is not positive.
RimmedSurface with_rim(const Surface& surface, const DiscRim& disc);

}  // namespace tissue
