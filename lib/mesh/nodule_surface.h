#pragma once

#include <optional>
#include <string>

#include "mesh/inclusion.h"

namespace tissue {

/// The closed surface of a part of other material, normals out, as a page draws it.
struct NoduleSurface {
    NodeField points;   ///< [m], at rest (V x 3); no rows: none
    Cells triangles;    ///< of points (W x 3)

    bool empty() const { return points.rows() == 0; }
};

/// Points of such a surface at the most: the server sends them to a page with the model.
constexpr Eigen::Index most_nodule_points = 20000;

/// That of an inclusion: the given surface, or of a ball 320 triangles with their corners on it, which enclose 3 per cent less than it does: CGAL's icosahedron, divided twice.
/// Empty where the given surface has more than most_nodule_points.
NoduleSurface nodule_surface(const Inclusion& nodule);

/// Why such a surface encloses no volume: an edge that two triangles do not run through in opposite directions, a point in no triangle, normals that point inwards on the whole.
/// Nothing when it does. Indices are points already.
std::optional<std::string> nodule_fault(const NoduleSurface& surface);

}  // namespace tissue
