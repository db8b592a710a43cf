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
        if (!(area_[e] > 0)) throw MismatchError(fmt::format("cell {} runs clockwise or has no area", e));
}

/// Half the sum of cross products of successive corners, and its derivative by the corners.
double CellAreas::area_and_gradient(int e, const NodeField& u, ElementVector& gradient) const {
    const Eigen::Index corners = nodes().cols();
    gradient.resize(2 * corners);
    const auto x = [&](Eigen::Index k, int axis) {
        const int node = nodes()(e, k % corners);
        return rest_(node, axis) + u(node, axis);
    };
    double area = 0;
    for (Eigen::Index k = 0; k < corners; ++k) {
        gradient[2 * k] = (x(k + 1, 1) - x(k + corners - 1, 1)) / 2;
        gradient[2 * k + 1] = (x(k + corners - 1, 0) - x(k + 1, 0)) / 2;
        area += (x(k, 0) * x(k + 1, 1) - x(k, 1) * x(k + 1, 0)) / 2;
    }
    return area;
}

double CellAreas::area_ratio(int e, const NodeField& u) const {
    ElementVector gradient;
    return area_and_gradient(e, u, gradient) / area_[e];
}

double CellAreas::energy(int e, const NodeField& u) const {
    const double swelling = area_ratio(e, u) - 1;
    return area_[e] * swelling * swelling / 2;
}

void CellAreas::force(int e, const NodeField& u, ElementVector& out) const {
    const double area = area_and_gradient(e, u, out);
    out *= area / area_[e] - 1;
}

void CellAreas::tangent(int e, const NodeField& u, ElementMatrix& out) const {
    const Eigen::Index corners = nodes().cols();
    ElementVector gradient;
    const double swelling = area_and_gradient(e, u, gradient) / area_[e] - 1;
    out = gradient * gradient.transpose() / area_[e];
    for (Eigen::Index k = 0; k < corners; ++k)  // the area is bilinear in successive corners
        for (const Eigen::Index next : {(k + 1) % corners, (k + corners - 1) % corners}) {
            const double half = (next == (k + 1) % corners ? 0.5 : -0.5) * swelling;
            out(2 * k, 2 * next + 1) += half;
            out(2 * k + 1, 2 * next) -= half;
        }
}

}  // namespace tissue
