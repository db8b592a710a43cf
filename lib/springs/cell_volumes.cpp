#include "springs/cell_volumes.h"

#include <Eigen/Dense>
#include <fmt/format.h>

#include "error.h"

namespace tissue {
namespace {

Cells solid_cells(const SpringMesh& mesh) {
    if (!mesh.is_solid()) throw MismatchError("cells with a volume need a mesh in space");
    if (mesh.embedding.empty()) throw MismatchError("cubes need an embedded lattice");
    return mesh.embedding.cubes;
}

/// det(I + G) - 1, without cancellation of the 1.
double growth(const Eigen::Matrix3d& G) {
    const double trace = G.trace();
    return trace + (trace * trace - (G * G).trace()) / 2 + G.determinant();
}

Eigen::Matrix3d cofactor(const Eigen::Matrix3d& F) {
    Eigen::Matrix3d C;
    for (int i = 0; i < 3; ++i) C.row(i) = F.row((i + 1) % 3).cross(F.row((i + 2) % 3));
    return C;
}

}  // namespace

CellVolumes::CellVolumes(const SpringMesh& mesh) : Elements(solid_cells(mesh)), volume_(nodes().rows()) {
    for (int e = 0; e < count(); ++e) {
        const Eigen::Vector3d at = mesh.embedding.centroid.row(e);
        Eigen::Matrix<double, 3, 8> local;  // derivatives by the local coordinates, each of which runs from 0 to 1
        Eigen::Matrix3d edges = Eigen::Matrix3d::Zero();
        for (int k = 0; k < 8; ++k) {
            for (int d = 0; d < 3; ++d) {
                local(d, k) = (k >> d & 1) ? 1 : -1;
                for (int other : {(d + 1) % 3, (d + 2) % 3}) local(d, k) *= (k >> other & 1) ? at[other] : 1 - at[other];
            }
            edges += mesh.nodes.row(nodes()(e, k)).transpose() * local.col(k).transpose();
        }
        volume_[e] = mesh.embedding.fraction[e] * edges.determinant();
        if (!(volume_[e] > 0)) throw MismatchError(fmt::format("cell {} is inverted or has no volume", e));
        gradient_.push_back(edges.inverse().transpose() * local);
    }
}

Eigen::Matrix3d CellVolumes::displacement_gradient(int e, const NodeField& u) const {
    Eigen::Matrix3d G = Eigen::Matrix3d::Zero();
    for (int k = 0; k < 8; ++k) G += u.row(nodes()(e, k)).transpose() * gradient_[static_cast<std::size_t>(e)].col(k).transpose();
    return G;
}

double CellVolumes::volume_ratio(int e, const NodeField& u) const { return 1 + growth(displacement_gradient(e, u)); }

double CellVolumes::energy(int e, const NodeField& u) const {
    const double by = growth(displacement_gradient(e, u));
    return volume_[e] * by * by / 2;
}

void CellVolumes::force(int e, const NodeField& u, ElementVector& out) const {
    const Eigen::Matrix3d G = displacement_gradient(e, u);
    const Eigen::Matrix<double, 3, 8> by_node =
        volume_[e] * growth(G) * cofactor(Eigen::Matrix3d::Identity() + G) * gradient_[static_cast<std::size_t>(e)];
    out = Eigen::Map<const Eigen::Matrix<double, 24, 1>>(by_node.data());
}

void CellVolumes::tangent(int e, const NodeField& u, ElementMatrix& out) const {
    const Eigen::Matrix<double, 3, 8>& g = gradient_[static_cast<std::size_t>(e)];
    const Eigen::Matrix3d G = displacement_gradient(e, u), F = Eigen::Matrix3d::Identity() + G;
    const Eigen::Matrix<double, 3, 8> J_by = cofactor(F) * g;
    const Eigen::Map<const Eigen::Matrix<double, 24, 1>> j(J_by.data());
    out.noalias() = volume_[e] * j * j.transpose();
    // d cof(F)_ia / dF_jb = eps_ijk eps_abc F_kc: between corners m and n, row i and column j, sum_c F_kc (g_m x g_n)_c
    const double by = volume_[e] * growth(G);
    for (int m = 0; m < 8; ++m)
        for (int n = 0; n < 8; ++n) {
            const Eigen::Vector3d across = by * (F * Eigen::Vector3d(g.col(m)).cross(Eigen::Vector3d(g.col(n))));
            for (int i = 0; i < 3; ++i) {
                out(3 * m + i, 3 * n + (i + 1) % 3) += across[(i + 2) % 3];
                out(3 * m + (i + 1) % 3, 3 * n + i) -= across[(i + 2) % 3];
            }
        }
}

}  // namespace tissue
