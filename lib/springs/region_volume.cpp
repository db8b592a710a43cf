#include "springs/region_volume.h"

#include <Eigen/Geometry>
#include <map>

#include "mesh/open_faces.h"

namespace tissue {
namespace {

double triple(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b, const Eigen::RowVector3d& c) { return a.cross(b).dot(c); }

}  // namespace

RegionVolume::Surface RegionVolume::surface_of(const Cells& tetrahedra, const std::vector<int>& region) {
    Cells own(static_cast<Eigen::Index>(region.size()), 4);
    for (std::size_t r = 0; r < region.size(); ++r) own.row(static_cast<Eigen::Index>(r)) = tetrahedra.row(region[r]);
    const Cells faces = open_faces(own);
    Surface surface;
    std::map<int, int> column;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        for (int node : faces.row(f)) column.emplace(node, 0);
    surface.nodes.resize(1, static_cast<Eigen::Index>(column.size()));
    int next = 0;
    for (auto& [node, at] : column) {
        surface.nodes(0, next) = node;
        at = next++;
    }
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        surface.facets.push_back({column.at(faces(f, 0)), column.at(faces(f, 1)), column.at(faces(f, 2))});
    return surface;
}

RegionVolume::RegionVolume(const SpringMesh& mesh, const Cells& tetrahedra, const std::vector<int>& region)
    : RegionVolume(mesh, surface_of(tetrahedra, region)) {}

RegionVolume::RegionVolume(const SpringMesh& mesh, Surface surface)
    : Elements(std::move(surface.nodes)), facets_(std::move(surface.facets)), rest_(nodes().cols(), 3), volume_(0) {
    for (Eigen::Index k = 0; k < nodes().cols(); ++k) rest_.row(k) = mesh.nodes.row(nodes()(0, k)) - mesh.nodes.row(nodes()(0, 0));
    for (const auto& [i, j, k] : facets_) volume_ += triple(rest_.row(i), rest_.row(j), rest_.row(k)) / 6;
}

NodeField RegionVolume::places(const NodeField& u) const {
    NodeField x(rest_.rows(), 3);
    for (Eigen::Index k = 0; k < x.rows(); ++k) x.row(k) = rest_.row(k) + u.row(nodes()(0, k)) - u.row(nodes()(0, 0));
    return x;
}

/// Facet by facet, as it changes with u: nothing of the volume itself cancels.
double RegionVolume::swelling(const NodeField& u) const {
    const NodeField x = places(u);
    double six = 0;
    for (const auto& [i, j, k] : facets_) {
        const Eigen::RowVector3d a = rest_.row(i), b = rest_.row(j), c = rest_.row(k), x_a = x.row(i), x_b = x.row(j);
        six += triple(x_a - a, b, c) + triple(x_a, x_b - b, c) + triple(x_a, x_b, Eigen::RowVector3d(x.row(k)) - c);
    }
    return six / (6 * volume_);
}

void RegionVolume::volume_gradient(const NodeField& u, ElementVector& out) const {
    const NodeField x = places(u);
    out.setZero(3 * x.rows());
    for (const auto& [i, j, k] : facets_) {
        const Eigen::RowVector3d a = x.row(i), b = x.row(j), c = x.row(k);
        out.segment<3>(3 * i) += b.cross(c).transpose() / 6;
        out.segment<3>(3 * j) += c.cross(a).transpose() / 6;
        out.segment<3>(3 * k) += a.cross(b).transpose() / 6;
    }
}

double RegionVolume::energy(int, const NodeField& u) const {
    const double by = swelling(u);
    return volume_ * by * by / 2;
}

void RegionVolume::force(int, const NodeField& u, ElementVector& out) const {
    volume_gradient(u, out);
    out *= swelling(u);
}

void RegionVolume::tangent(int, const NodeField& u, ElementMatrix& out) const {
    ElementVector gradient;
    volume_gradient(u, gradient);
    out.noalias() = gradient * gradient.transpose() / volume_;
    const NodeField x = places(u);
    const double sixth = swelling(u) / 6;
    // a . (b x c): between b and c the matrix of v -> a x v, and so on around
    const auto add = [&](int p, int q, const Eigen::RowVector3d& r) {
        for (int d = 0; d < 3; ++d) {
            const int e = (d + 1) % 3, f = (d + 2) % 3;
            // d/dx_q of (x_q x r): component d is q_e r_f - q_f r_e
            out(3 * p + d, 3 * q + e) += sixth * r[f];
            out(3 * p + d, 3 * q + f) -= sixth * r[e];
        }
    };
    for (const auto& [i, j, k] : facets_) {
        const Eigen::RowVector3d a = x.row(i), b = x.row(j), c = x.row(k);
        add(i, j, c);  // gradient at i is b x c
        add(i, k, -b);
        add(j, k, a);  // at j is c x a
        add(j, i, -c);
        add(k, i, b);  // at k is a x b
        add(k, j, -a);
    }
}

}  // namespace tissue
