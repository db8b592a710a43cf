#pragma once

#include <array>
#include <vector>

#include "mesh/msh_file.h"

namespace tissue::surface_file {

/// Triangles, by places in the polygon, that fill a polygon of four corners or more, which need be neither plane nor convex: of CGAL's least weight
/// (largest angle between neighbours, then area). Fewer than two less than corners where it cannot be filled.
std::vector<std::array<std::size_t, 3>> divide_facet(const std::vector<MshFile::Point>& polygon);

}  // namespace tissue::surface_file
