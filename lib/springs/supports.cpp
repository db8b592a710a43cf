#include "springs/supports.h"

#include <algorithm>

#include "error.h"
#include "mesh/facet.h"

namespace tissue {
namespace {

Cells held_corners(const SpringMesh& mesh) {
    if (mesh.embedding.empty()) throw MismatchError("supports at points need an embedded lattice");
    return mesh.embedding.corner(mesh.fixed, Eigen::all);
}

}  // namespace

Supports::Supports(const SpringMesh& mesh) : Elements(held_corners(mesh)), fixed_(mesh.fixed), embedding_(mesh.embedding) {}

double Supports::energy(int e, const NodeField& u) const { return embedding_.at(fixed_[static_cast<std::size_t>(e)], u).squaredNorm() / 2; }

void Supports::force(int e, const NodeField& u, ElementVector& out) const {
    const int node = fixed_[static_cast<std::size_t>(e)];
    const Eigen::Vector3d there = embedding_.at(node, u);
    out.resize(24);
    for (int k = 0; k < 8; ++k) out.segment<3>(3 * k) = embedding_.weight(node, k) * there;
}

void Supports::tangent(int e, const NodeField& /*u*/, ElementMatrix& out) const {
    const auto weight = embedding_.weight.row(fixed_[static_cast<std::size_t>(e)]);
    out.setZero(24, 24);
    for (int m = 0; m < 8; ++m)
        for (int n = 0; n < 8; ++n) out.block<3, 3>(3 * m, 3 * n).diagonal().setConstant(weight[m] * weight[n]);
}

Eigen::VectorXd fixed_areas(const SpringMesh& mesh) {
    Eigen::VectorXd area = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(mesh.fixed.size()));
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        Eigen::Index at_fixed[3];
        bool all = true;
        for (int c = 0; c < 3; ++c) {
            const auto at = std::lower_bound(mesh.fixed.begin(), mesh.fixed.end(), mesh.facets(f, c));
            all = all && at != mesh.fixed.end() && *at == mesh.facets(f, c);
            at_fixed[c] = at - mesh.fixed.begin();
        }
        if (!all) continue;
        for (Eigen::Index node : at_fixed) area[node] += facet_measure(mesh.nodes, mesh.facets, f) / 3;
    }
    return area;
}

}  // namespace tissue
