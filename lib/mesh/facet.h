#pragma once

#include "field.h"

namespace tissue {

/// The point of a facet that is nearest to another.
struct FacetPoint {
    double distance_m;
    Eigen::Vector3d weight;   ///< of the facet's nodes; the third is 0 for a segment
};

/// facets: segments or triangles, one row each; nodes: their places (N x D).
FacetPoint nearest_on_facet(const NodeField& nodes, const Cells& facets, Eigen::Index facet, const Point& position_m);

/// Unit normal of a facet, out of the tissue (D): segments run counter-clockwise, triangles as a right hand's fingers.
Point facet_normal(const NodeField& nodes, const Cells& facets, Eigen::Index facet);

/// Length of a segment, area of a triangle.
double facet_measure(const NodeField& nodes, const Cells& facets, Eigen::Index facet);

}  // namespace tissue
