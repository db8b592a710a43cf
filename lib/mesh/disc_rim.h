#pragma once

#include "mesh/surface.h"
#include "mesh/surface_remesh.h"

namespace tissue {

/// Contact and radius of a disc, and the wanted side lengths of triangles around it.
struct DiscRim {
    Eigen::Vector3d contact_m;
    double radius_m;
    double near_m, far_m;  ///< wanted side within radius_m + 2 mm of the contact, and far away
};

/// Wanted side lengths around a contact on the surface. contact_m: replaces disc.contact_m.
SideLength side_length(const DiscRim& disc, const Eigen::Vector3d& contact_m);

/// A surface for finite elements under a disc. Its triangles are graded in size, and the contact is a node. The rim
/// |x - contact| = radius is a closed line of sides, and the triangles inside it have Surface::disc_label.
struct RimmedSurface {
    Surface surface;
    Eigen::Vector3d contact_m;  ///< point of the given surface that is nearest to DiscRim::contact_m
    double least_quality;       ///< of its triangles, triangle_quality of mesh/surface.h
};

/// Remeshes a surface for a disc. Edges that turn by more than 40 degrees are kept. If this leaves a triangle of
/// quality below 0.1, as short edges of a segmentation do, the surface is remeshed again without keeping these edges.
/// The second surface is used if its volume differs from the first by less than 0.3 %.
/// Throws MismatchError: a size is not positive, or far_m < near_m; the contact is farther than two radii from the
/// surface or on the fixed part; the disc overlaps the fixed part, covers the surface or is not one patch with one rim;
/// a fixed part loses more than a tenth of its area; a triangle has a quality below 0.1.
RimmedSurface with_rim(const Surface& surface, const DiscRim& disc);

}  // namespace tissue
