#pragma once

#include <array>
#include <vector>

#include "mesh/msh_file.h"

namespace tissue::surface_file {

/// Divides a polygon of n >= 4 corners into n - 2 triangles, as indices into `polygon`. The polygon need be neither
/// plane nor convex. Of all divisions CGAL takes the one of least weight (largest angle between neighbours, then area).
/// Result: fewer than n - 2 triangles if the polygon cannot be divided.
std::vector<std::array<std::size_t, 3>> divide_facet(const std::vector<MshFile::Point>& polygon);

}  // namespace tissue::surface_file
