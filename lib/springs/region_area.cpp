#include "springs/region_area.h"

#include <map>
#include <set>

namespace tissue {

RegionArea::Outline RegionArea::outline_of(const Cells& cells, const std::vector<int>& region) {
    std::set<std::array<int, 2>> open;
    for (int c : region)
        for (Eigen::Index k = 0; k < cells.cols(); ++k) {
            const int i = cells(c, k), j = cells(c, (k + 1) % cells.cols());
            if (!open.erase({j, i})) open.insert({i, j});
        }
    Outline outline;
    std::map<int, int> column;
    for (const std::array<int, 2>& edge : open)
        for (int node : edge) column.emplace(node, static_cast<int>(column.size()));
    outline.nodes.resize(1, static_cast<Eigen::Index>(column.size()));
    for (const auto& [node, at] : column) outline.nodes(0, at) = node;
    for (const std::array<int, 2>& edge : open) outline.edges.push_back({column[edge[0]], column[edge[1]]});
    return outline;
}

RegionArea::RegionArea(const SpringMesh& mesh, const Cells& cells, const std::vector<int>& region)
    : RegionArea(mesh, outline_of(cells, region)) {}

RegionArea::RegionArea(const SpringMesh& mesh, Outline outline)
    : Elements(std::move(outline.nodes)), edges_(std::move(outline.edges)), rest_(nodes().cols(), 2), area_(0) {
    for (Eigen::Index k = 0; k < nodes().cols(); ++k) rest_.row(k) = mesh.nodes.row(nodes()(0, k)) - mesh.nodes.row(nodes()(0, 0));
    for (const auto& [i, j] : edges_) area_ += (rest_(i, 0) * rest_(j, 1) - rest_(i, 1) * rest_(j, 0)) / 2;
}

/// Relative change of area, edge by edge in terms of u, as for one cell (springs/cell_areas.cpp): no cancellation.
double RegionArea::swelling(const NodeField& u) const {
    double twice = 0;
    for (const auto& [i, j] : edges_) {
        const auto a = u.row(nodes()(0, i)), b = u.row(nodes()(0, j));
        twice += a[0] * rest_(j, 1) - a[1] * rest_(j, 0) + rest_(i, 0) * b[1] - rest_(i, 1) * b[0] + a[0] * b[1] - a[1] * b[0];
    }
    return twice / (2 * area_);
}

void RegionArea::area_gradient(const NodeField& u, ElementVector& out) const {
    out.setZero(2 * nodes().cols());
    for (const auto& [i, j] : edges_) {
        const Eigen::RowVector2d p = rest_.row(i) + u.row(nodes()(0, i)), q = rest_.row(j) + u.row(nodes()(0, j));
        out[2 * i] += q[1] / 2;
        out[2 * i + 1] -= q[0] / 2;
        out[2 * j] -= p[1] / 2;
        out[2 * j + 1] += p[0] / 2;
    }
}

double RegionArea::energy(int, const NodeField& u) const {
    const double by = swelling(u);
    return area_ * by * by / 2;
}

void RegionArea::force(int, const NodeField& u, ElementVector& out) const {
    area_gradient(u, out);
    out *= swelling(u);
}

void RegionArea::tangent(int, const NodeField& u, ElementMatrix& out) const {
    ElementVector gradient;
    area_gradient(u, gradient);
    out.noalias() = gradient * gradient.transpose() / area_;
    const double half = swelling(u) / 2;
    for (const auto& [i, j] : edges_) {
        out(2 * i, 2 * j + 1) += half;
        out(2 * i + 1, 2 * j) -= half;
        out(2 * j, 2 * i + 1) -= half;
        out(2 * j + 1, 2 * i) += half;
    }
}

}  // namespace tissue
