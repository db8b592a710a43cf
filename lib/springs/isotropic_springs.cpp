#include "springs/isotropic_springs.h"

#include <cmath>

#include "mesh/embedded_lattice.h"
#include "mesh/topology.h"

namespace tissue {

std::optional<RectangleShares> isotropic_shares(const Eigen::Vector2d& sides_m) {
    const Eigen::Array2d h = sides_m.array().square() / sides_m.squaredNorm();
    // per volume and direction, c = 1
    const double diagonal = 1 / (2 * h[0] * h[1]), x = 3 - h[0] / h[1], y = 3 - h[1] / h[0];
    if (!(x > 1e-9 && y > 1e-9)) return {};
    const double sum = x + y + 2 * diagonal;
    return RectangleShares{2 * x / sum, 2 * y / sum, 4 * diagonal / sum};
}

namespace {

/// Isotropic share over that of (7), by the axes that a spring runs along.
double more_than_in_7(const RectangleShares& share, bool x, bool y) { return x && y ? share.diagonal : 2 * (x ? share.along_x : share.along_y); }
double more_than_in_7(int axes) { return (axes == 1 ? cube_edge_share : axes == 2 ? cube_face_share : cube_body_share) / spring_share(axes); }

}  // namespace

Eigen::VectorXd isotropic_measure(const SpringMesh& mesh) {
    Eigen::VectorXd measure = mesh.incident_measure;
    if (!has_cells(mesh)) return measure;
    Eigen::ArrayXXd span(mesh.spring_count(), mesh.dimension());
    for (int s = 0; s < mesh.spring_count(); ++s) span.row(s) = (mesh.nodes.row(mesh.springs(s, 0)) - mesh.nodes.row(mesh.springs(s, 1))).cwiseAbs();
    const Eigen::RowVectorXd cell_m = span.colwise().maxCoeff();
    const Eigen::ArrayXXi along = (span > 0.5 * cell_m.array().replicate(span.rows(), 1)).cast<int>();
    if (mesh.is_solid()) {
        for (int s = 0; s < mesh.spring_count(); ++s) measure[s] *= more_than_in_7(along.row(s).sum());
        return measure;
    }
    const std::optional<RectangleShares> share = isotropic_shares(cell_m.transpose());
    if (!share || along.rowwise().sum().maxCoeff() < 2) return measure;  // without diagonals no shares are isotropic
    for (int s = 0; s < mesh.spring_count(); ++s)
        // squares have the shares of (7): rounding must not change them
        if (const double more = more_than_in_7(*share, along(s, 0) > 0, along(s, 1) > 0); std::abs(more - 1) > 1e-9) measure[s] *= more;
    return measure;
}

}  // namespace tissue
