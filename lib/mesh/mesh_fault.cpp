#include "mesh/mesh_fault.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "error.h"
#include "mesh/outline.h"

namespace tissue {
namespace {

using Edge = std::pair<int, int>;

double cross(const NodeField& nodes, int a, int b, int c) {
    const Eigen::RowVector2d u = nodes.row(b) - nodes.row(a), v = nodes.row(c) - nodes.row(a);
    return u.x() * v.y() - u.y() * v.x();
}

/// The three nodes of a face, rotated so that the smallest is first. The orientation is unchanged.
std::array<int, 3> turned(std::array<int, 3> face) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return face;
}

std::optional<MeshFault> solid_fault(const SpringMesh& mesh) {
    std::set<std::array<int, 3>> outer;
    for (Eigen::Index t = 0; t < mesh.simplices.rows(); ++t) {
        const auto at = [&](int k) { return Eigen::Vector3d(mesh.nodes.row(mesh.simplices(t, k))); };
        if (!((at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) > 0))
            return MeshFault{"tetrahedra", fmt::format("tetrahedron {} is inverted or has no volume", t)};
        for (const auto& [i, j, k] : {std::array<int, 3>{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}) {
            const int a = mesh.simplices(t, i), b = mesh.simplices(t, j), c = mesh.simplices(t, k);
            if (outer.erase(turned({a, c, b})) == 0 && !outer.insert(turned({a, b, c})).second)
                return MeshFault{"tetrahedra", fmt::format("tetrahedron {} overlaps another", t)};
        }
    }
    bool held = false, free = false;
    std::set<std::array<int, 3>> facets;
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        facets.insert(turned({mesh.facets(f, 0), mesh.facets(f, 1), mesh.facets(f, 2)}));
        int fixed = 0;
        for (int node : mesh.facets.row(f)) fixed += std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), node);
        held |= fixed == 3;
        free |= fixed == 0;
    }
    if (facets != outer) return MeshFault{"facets", "are not the surface of the tetrahedra"};
    if (!held || !free) return MeshFault{"fixed", held ? "leaves no facet free" : "fixes no facet"};
    return std::nullopt;
}

}  // namespace

std::optional<MeshFault> triangle_fault(const NodeField& nodes, const Cells& triangles) {
    std::set<Edge> edges;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        if (!(cross(nodes, triangles(t, 0), triangles(t, 1), triangles(t, 2)) > 0))
            return MeshFault{"triangles", fmt::format("triangle {} is clockwise or has no area", t)};
        for (int i = 0; i < 3; ++i)
            if (!edges.emplace(triangles(t, i), triangles(t, (i + 1) % 3)).second)
                return MeshFault{"triangles", fmt::format("triangle {} overlaps another", t)};
    }
    return std::nullopt;
}

std::optional<MeshFault> mesh_fault(const SpringMesh& mesh) {
    if (mesh.is_solid()) return solid_fault(mesh);
    if (const auto fault = triangle_fault(mesh.nodes, mesh.simplices)) return fault;
    const std::vector<int> loop = mesh.loop();
    const std::size_t M = loop.size();
    double twice_area = 0;
    std::set<Edge> segments;
    for (std::size_t b = 0; b < M; ++b) {
        const int i = loop[b], j = loop[(b + 1) % M];
        twice_area += cross(mesh.nodes, loop[0], i, j);
        segments.emplace(i, j);
    }
    if (!(twice_area > 0)) return MeshFault{"boundary", "is clockwise"};
    std::set<Edge> outer;
    for (Eigen::Index t = 0; t < mesh.simplices.rows(); ++t)
        for (int i = 0; i < 3; ++i) {
            const int a = mesh.simplices(t, i), b = mesh.simplices(t, (i + 1) % 3);
            if (outer.erase({b, a}) == 0) outer.emplace(a, b);
        }
    if (segments != outer) return MeshFault{"boundary", "is not the outline of the triangles"};
    try {
        Outline{mesh};
    } catch (const MismatchError& e) {
        return MeshFault{"fixed", e.what()};
    }
    return std::nullopt;
}

}  // namespace tissue
