#include "springs/cell_areas.h"

#include <fmt/format.h>

#include "error.h"

namespace tissue {
namespace {

Cells plane_cells(const SpringMesh& mesh) {
    if (mesh.dimension() != 2) throw MismatchError("cells with an area need a mesh in the plane");
    return mesh_cells(mesh);
}

}  // namespace

CellAreas::CellAreas(const SpringMesh& mesh)
    : Elements(plane_cells(mesh)), rest_(mesh.nodes), area_(cell_areas(mesh, nodes())) {
    for (int e = 0; e < count(); ++e)
        if (!(area_[e] > 0)) throw MismatchError(fmt::format("cell {} is clockwise or has no area", e));
}

/// Change of half the sum of cross products of successive corners, written in u: no cancellation.
double CellAreas::swelling(int e, const NodeField& u) const {
    double twice = 0;
    for (Eigen::Index k = 0, corners = nodes().cols(); k < corners; ++k) {
        const int i = nodes()(e, k), j = nodes()(e, (k + 1) % corners), before = nodes()(e, (k + corners - 1) % corners);
        twice += u(i, 0) * (rest_(j, 1) - rest_(before, 1)) - u(i, 1) * (rest_(j, 0) - rest_(before, 0));
        twice += u(i, 0) * u(j, 1) - u(i, 1) * u(j, 0);
    }
    return twice / (2 * area_[e]);
}

void CellAreas::area_gradient(int e, const NodeField& u, ElementVector& out) const {
    const Eigen::Index corners = nodes().cols();
    out.resize(2 * corners);
    for (Eigen::Index k = 0; k < corners; ++k) {
        const int after = nodes()(e, (k + 1) % corners), before = nodes()(e, (k + corners - 1) % corners);
        out[2 * k] = (rest_(after, 1) - rest_(before, 1) + u(after, 1) - u(before, 1)) / 2;
        out[2 * k + 1] = (rest_(before, 0) - rest_(after, 0) + u(before, 0) - u(after, 0)) / 2;
    }
}

double CellAreas::area_ratio(int e, const NodeField& u) const { return 1 + swelling(e, u); }

double CellAreas::energy(int e, const NodeField& u) const {
    const double by = swelling(e, u);
    return area_[e] * by * by / 2;
}

void CellAreas::force(int e, const NodeField& u, ElementVector& out) const {
    area_gradient(e, u, out);
    out *= swelling(e, u);
}

void CellAreas::tangent(int e, const NodeField& u, ElementMatrix& out) const {
    const Eigen::Index corners = nodes().cols();
    ElementVector gradient;
    area_gradient(e, u, gradient);
    out = gradient * gradient.transpose() / area_[e];
    const double by = swelling(e, u);
    // the area is bilinear in the positions of successive corners
    for (Eigen::Index k = 0; k < corners; ++k)
        for (const Eigen::Index next : {(k + 1) % corners, (k + corners - 1) % corners}) {
            const double half = (next == (k + 1) % corners ? 0.5 : -0.5) * by;
            out(2 * k, 2 * next + 1) += half;
            out(2 * k + 1, 2 * next) -= half;
        }
}

}  // namespace tissue
