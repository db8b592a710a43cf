#include "surface_file/divide_facet.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

namespace tissue::surface_file {

std::vector<std::array<std::size_t, 3>> divide_facet(const std::vector<MshFile::Point>& polygon) {
    using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
    std::vector<Point> corners;
    for (const MshFile::Point& p : polygon) corners.emplace_back(p.x, p.y, p.z);
    std::vector<CGAL::Triple<int, int, int>> triangles;
    CGAL::Polygon_mesh_processing::triangulate_hole_polyline(corners, std::back_inserter(triangles), CGAL::parameters::use_delaunay_triangulation(false));
    std::vector<std::array<std::size_t, 3>> all;
    for (const auto& t : triangles) all.push_back({static_cast<std::size_t>(t.first), static_cast<std::size_t>(t.second), static_cast<std::size_t>(t.third)});
    return all;
}

}  // namespace tissue::surface_file
