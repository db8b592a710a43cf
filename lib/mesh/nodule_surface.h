#pragma once

#include <optional>
#include <string>

#include "mesh/inclusion.h"

namespace tissue {

/// The closed surface of an inclusion, normals out, for display in a web page.
struct NoduleSurface {
    NodeField points;   ///< rest positions [m] (V x 3); no rows: no inclusion to show
    Cells triangles;    ///< point numbers (W x 3)

    bool empty() const { return points.rows() == 0; }
};

/// Largest number of points of such a surface, because the server sends them to a page together with the model.
constexpr Eigen::Index most_nodule_points = 20000;

/// The surface of an inclusion. For a ball it is CGAL's icosahedron, divided twice: 320 triangles with their corners on
/// the ball, which enclose 3 per cent less than the ball. Empty if the inclusion's surface has more than
/// most_nodule_points.
NoduleSurface nodule_surface(const Inclusion& nodule);

/// Why a surface does not enclose a volume: an edge is not used by two triangles in opposite directions, a point is in
/// no triangle, or the signed volume is not positive. Nothing if the surface is valid. Point numbers must be in range.
std::optional<std::string> nodule_fault(const NoduleSurface& surface);

}  // namespace tissue
