#include "mesh/nodule_surface.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace tissue {
namespace {

using Triangle = std::array<int, 3>;

/// Unit vectors and triangles, normals out, of a regular icosahedron.
void icosahedron(std::vector<Eigen::Vector3d>& points, std::vector<Triangle>& triangles) {
    const double golden = (1 + std::sqrt(5.0)) / 2;
    for (int axis = 0; axis < 3; ++axis)
        for (const auto& [one, other] : {std::pair<int, int>{1, 1}, {-1, 1}, {1, -1}, {-1, -1}}) {
            Eigen::Vector3d p = Eigen::Vector3d::Zero();
            p[axis] = one;
            p[(axis + 1) % 3] = other * golden;
            points.push_back(p.normalized());
        }
    // its faces are all triples that are as near to each other as any two
    const double side = 2 / std::sqrt(1 + golden * golden) + 1e-9;
    const auto near = [&](int i, int j) { return (points[static_cast<std::size_t>(i)] - points[static_cast<std::size_t>(j)]).norm() < side; };
    for (int i = 0; i < 12; ++i)
        for (int j = i + 1; j < 12; ++j)
            for (int k = j + 1; k < 12; ++k) {
                if (!near(i, j) || !near(j, k) || !near(i, k)) continue;
                const auto at = [&](int n) { return points[static_cast<std::size_t>(n)]; };
                const bool out = at(i).dot(at(j).cross(at(k))) > 0;
                triangles.push_back({i, out ? j : k, out ? k : j});
            }
}

/// Each triangle into four, the new points on the unit sphere.
void divide(std::vector<Eigen::Vector3d>& points, std::vector<Triangle>& triangles) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int i, int j) {
        const auto [found, is_new] = middles.try_emplace(std::minmax(i, j), static_cast<int>(points.size()));
        if (is_new) points.push_back((points[static_cast<std::size_t>(i)] + points[static_cast<std::size_t>(j)]).normalized());
        return found->second;
    };
    std::vector<Triangle> parts;
    for (const auto& [a, b, c] : triangles) {
        const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
        for (const Triangle& part : {Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) parts.push_back(part);
    }
    triangles = std::move(parts);
}

}  // namespace

NoduleSurface nodule_surface(const Inclusion& nodule) {
    if (const Surface* given = nodule.surface()) return {given->nodes, given->triangles};
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    icosahedron(points, triangles);
    for (int k = 0; k < 2; ++k) divide(points, triangles);
    NoduleSurface ball{NodeField(static_cast<Eigen::Index>(points.size()), 3), Cells(static_cast<Eigen::Index>(triangles.size()), 3)};
    for (std::size_t p = 0; p < points.size(); ++p) ball.points.row(static_cast<Eigen::Index>(p)) = (nodule.centre_m() + nodule.radius_m() * points[p]).transpose();
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) ball.triangles(static_cast<Eigen::Index>(t), k) = triangles[t][static_cast<std::size_t>(k)];
    return ball;
}

std::optional<std::string> nodule_fault(const NoduleSurface& surface) {
    std::map<std::pair<int, int>, int> edges;  // how often each is run through
    std::vector<bool> used(static_cast<std::size_t>(surface.points.rows()), false);
    double six_volumes = 0;
    const Eigen::RowVector3d from = surface.points.row(0);  // not the origin, which may be far away
    for (const auto& t : surface.triangles.rowwise()) {
        for (int k = 0; k < 3; ++k) {
            used[static_cast<std::size_t>(t[k])] = true;
            ++edges[{t[k], t[(k + 1) % 3]}];
        }
        const auto at = [&](int k) { return Eigen::Vector3d(surface.points.row(t[k]) - from); };
        six_volumes += at(0).dot(at(1).cross(at(2)));
    }
    for (const auto& [edge, times] : edges)
        if (const auto back = edges.find({edge.second, edge.first}); times != 1 || back == edges.end())
            return fmt::format("do not close: between points {} and {}", edge.first, edge.second);
    for (std::size_t p = 0; p < used.size(); ++p)
        if (!used[p]) return fmt::format("leave out point {}", p);
    if (!(six_volumes > 0)) return "point inwards, or enclose no volume";
    return std::nullopt;
}

}  // namespace tissue
