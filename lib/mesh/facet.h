#pragma once

#include "field.h"

namespace tissue {

/// The point of a facet that is nearest to a given position.
struct FacetPoint {
    double distance_m;
    Eigen::Vector3d weight;   ///< of the facet's nodes; the third is 0 for a segment
};

/// The point of one facet nearest to position_m [m] (D). nodes: positions [m] (N x D); facets: segments (B x 2) or
/// triangles (B x 3).
FacetPoint nearest_on_facet(const NodeField& nodes, const Cells& facets, Eigen::Index facet, const Point& position_m);

/// Unit normal of a facet, out of the tissue (D). Segments run counter-clockwise; triangles follow the right-hand rule.
Point facet_normal(const NodeField& nodes, const Cells& facets, Eigen::Index facet);

/// Length of a segment [m] or area of a triangle [m^2].
double facet_measure(const NodeField& nodes, const Cells& facets, Eigen::Index facet);

}  // namespace tissue
