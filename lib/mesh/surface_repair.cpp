#include "mesh/surface_repair.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "error.h"

namespace tissue {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangle = Kernel::Triangle_3;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, std::vector<Triangle>::const_iterator>>>;

std::vector<Point> points_of(const MshFile& mesh) {
    std::vector<Point> points;
    for (const MshFile::Point& p : mesh.points) points.emplace_back(p.x, p.y, p.z);
    return points;
}

std::vector<Triangle> triangles_of(const MshFile& mesh, const std::vector<Point>& points) {
    std::vector<Triangle> all;
    for (const MshFile::Element& e : mesh.triangles) {
        const Triangle t(points[static_cast<std::size_t>(e.node[0])], points[static_cast<std::size_t>(e.node[1])], points[static_cast<std::size_t>(e.node[2])]);
        if (!t.is_degenerate()) all.push_back(t);
    }
    return all;
}

/// Distances of one surface from another, at the centroids of parts of its triangles. Parts have sides of at most
/// `spacing`, which is enlarged so that there are about half a million parts at most.
struct Distances {
    double median = 0, most = 0;
    Point at;  // point of the largest distance
};
Distances distances(const std::vector<Triangle>& from, const std::vector<Triangle>& to, double spacing) {
    constexpr double most_parts = 5e5;
    Tree tree(to.begin(), to.end());
    double area = 0;
    for (const Triangle& t : from) area += std::sqrt(t.squared_area());
    spacing = std::max(spacing, std::sqrt(2 * area / most_parts));
    std::vector<std::pair<double, double>> all;  // distance, and twice the area of the part
    Distances d;
    std::vector<Triangle> left(from.rbegin(), from.rend());
    while (!left.empty()) {
        const Triangle t = left.back();
        left.pop_back();
        int longest = 0;
        for (int i = 1; i < 3; ++i)
            if (CGAL::squared_distance(t[i], t[i + 1]) > CGAL::squared_distance(t[longest], t[longest + 1])) longest = i;
        const Point a = t[longest], b = t[longest + 1], c = t[longest + 2];
        // the second limit is for long thin triangles, which make more parts than their area implies
        if (CGAL::squared_distance(a, b) > spacing * spacing && all.size() + left.size() < 4 * most_parts + from.size()) {
            const Point middle = CGAL::midpoint(a, b);
            left.push_back({a, middle, c});
            left.push_back({middle, b, c});
            continue;
        }
        const Point x = CGAL::centroid(t);
        const double there = std::sqrt(tree.squared_distance(x));
        all.emplace_back(there, std::sqrt(t.squared_area()));
        if (there >= d.most) d.most = there, d.at = x;
    }
    std::sort(all.begin(), all.end());
    double sum = 0;
    for (const auto& [there, each] : all)
        if ((sum += each) >= area / 2) {
            d.median = there;
            break;
        }
    return d;
}

double extent_of(const MshFile& mesh) {
    CGAL::Bbox_3 box;
    for (const MshFile::Element& e : mesh.triangles)
        for (int n : e.node) {
            const MshFile::Point& p = mesh.points[static_cast<std::size_t>(n)];
            box += CGAL::Bbox_3(p.x, p.y, p.z, p.x, p.y, p.z);
        }
    return std::max({box.x_span(), box.y_span(), box.z_span()});
}

}  // namespace

SurfaceRepair usual_repair(const MshFile& mesh) { return {extent_of(mesh) / 50, extent_of(mesh) / 1000}; }

RepairedSurface repaired(const MshFile& mesh, const SurfaceRepair& repair) {
    const double extent = extent_of(mesh);
    if (!(repair.closes >= extent / 250) || !(repair.offset >= extent / 1e5) || !std::isfinite(repair.closes + repair.offset))
        throw MismatchError(fmt::format("{}: has the size {:.4g} in its file's unit; in that unit --closes must be at least {:.2g} and --offset at least {:.2g}", mesh.file, extent, extent / 250, extent / 1e5));
    const std::vector<Point> points = points_of(mesh);
    const std::vector<Triangle> given = triangles_of(mesh, points);
    if (given.empty()) throw FileError(mesh.file + ": has no triangle with an area");
    std::vector<Point> corners;
    std::vector<std::array<std::size_t, 3>> faces;
    for (const Triangle& t : given) {
        faces.push_back({corners.size(), corners.size() + 1, corners.size() + 2});
        for (int i = 0; i < 3; ++i) corners.push_back(t[i]);
    }
    CGAL::Surface_mesh<Point> wrap;
    CGAL::alpha_wrap_3(corners, faces, repair.closes / 2, repair.offset, wrap);  // alpha is a radius
    RepairedSurface made{};
    made.distances.left_out = CGAL::Polygon_mesh_processing::keep_largest_connected_components(wrap, 1);
    wrap.collect_garbage();
    made.mesh.file = mesh.file;
    for (const auto vertex : wrap.vertices()) {
        const Point& p = wrap.point(vertex);
        made.mesh.points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
    }
    for (const auto face : wrap.faces()) {
        MshFile::Element e{static_cast<long>(made.mesh.triangles.size()) + 1, {}, 0};
        int i = 0;
        for (const auto vertex : CGAL::vertices_around_face(wrap.halfedge(face), wrap)) e.node[i++] = static_cast<int>(vertex.idx());
        made.mesh.triangles.push_back(e);
    }
    const std::vector<Triangle> new_triangles = triangles_of(made.mesh, points_of(made.mesh));
    if (new_triangles.empty()) throw FileError(mesh.file + ": is too far from the origin for the floats of an .stl");
    const Distances out = distances(new_triangles, given, repair.closes / 4), back = distances(given, new_triangles, repair.closes / 4);
    made.distances = {out.median, out.most, back.median, back.most, {back.at.x(), back.at.y(), back.at.z()}, made.distances.left_out};
    return made;
}

std::string to_stl(const MshFile& mesh) {
    std::string bytes(80, ' ');
    // .stl is little-endian, and so are all supported machines
    const auto put = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
    put(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const MshFile::Element& e : mesh.triangles) {
        std::array<float, 12> facet{};  // normal 0: readers take it from the order of the corners
        for (int i = 0; i < 3; ++i) {
            const MshFile::Point& p = mesh.points[static_cast<std::size_t>(e.node[i])];
            facet[static_cast<std::size_t>(3 * i + 3)] = static_cast<float>(p.x);
            facet[static_cast<std::size_t>(3 * i + 4)] = static_cast<float>(p.y);
            facet[static_cast<std::size_t>(3 * i + 5)] = static_cast<float>(p.z);
        }
        put(facet);
        put(std::uint16_t{0});
    }
    return bytes;
}

}  // namespace tissue
