#include "mesh/mesh_fault.h"

#include <fmt/format.h>

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

}  // namespace

std::optional<MeshFault> triangle_fault(const NodeField& nodes, const Cells& triangles) {
    std::set<Edge> edges;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        if (!(cross(nodes, triangles(t, 0), triangles(t, 1), triangles(t, 2)) > 0))
            return MeshFault{"triangles", fmt::format("triangle {} runs clockwise or has no area", t)};
        for (int i = 0; i < 3; ++i)
            if (!edges.emplace(triangles(t, i), triangles(t, (i + 1) % 3)).second)
                return MeshFault{"triangles", fmt::format("triangle {} lies over another", t)};
    }
    return std::nullopt;
}

std::optional<MeshFault> mesh_fault(const SpringMesh& mesh) {
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
    if (!(twice_area > 0)) return MeshFault{"boundary", "runs clockwise"};
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
