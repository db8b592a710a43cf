#include "springs/isotropic_springs.h"

#include <algorithm>
#include <cmath>

#include "mesh/solid_lattice.h"
#include "mesh/topology.h"

namespace tissue {
namespace {

/// (7)'s.
double share_of_7(int axes, int dimension) {
    const int along = __builtin_popcount(static_cast<unsigned>(axes));
    return dimension == 3 ? spring_share(along) : along == 1 ? 1.0 / 2 : 1;
}

/// Springs of a cell that run along these axes, one behind the other.
int alike(int axes, int dimension) { return 1 << (dimension - __builtin_popcount(static_cast<unsigned>(axes))); }

/// Directions that do: a diagonal has others beside it.
int directions(int axes) { return 1 << (__builtin_popcount(static_cast<unsigned>(axes)) - 1); }

}  // namespace

std::optional<std::array<double, 8>> isotropic_shares(const Point& cell_m) {
    const int D = static_cast<int>(cell_m.size()), all = (1 << D) - 1;
    Eigen::ArrayXd h = cell_m.array().square() / cell_m.squaredNorm();
    const auto pair = [&](int a, int b) { return h[a] * h[b]; };
    std::array<double, 8> w{};  // per volume and direction, c = 1
    if (D == 2) {
        w[3] = 1 / (2 * pair(0, 1));
    } else {
        double least = 0;  // below it an edge is negative
        for (int a = 0; a < 3; ++a) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            least = std::max(least, (h[a] / h[b] + h[a] / h[c] - 3) / (4 * h[a] * h[a]));
        }
        const double most = 1 / (4 * std::max({pair(0, 1), pair(1, 2), pair(2, 0)}));
        if (!(least < most)) return {};
        w[7] = (least + most) / 2;
        for (int a = 0; a < 3; ++a) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            w[static_cast<std::size_t>(all ^ (1 << a))] = (1 - 4 * w[7] * pair(b, c)) * std::pow(h[b] + h[c], 2) / (2 * pair(b, c));
        }
    }
    for (int a = 0; a < D; ++a) {
        double diagonals = 0;  // their part of the sum of w n_a^4
        for (int axes = 1; axes <= all; ++axes) {
            if (!(axes & (1 << a)) || directions(axes) == 1) continue;
            double length2 = 0;
            for (int b = 0; b < D; ++b) length2 += axes & (1 << b) ? h[b] : 0;
            diagonals += directions(axes) * w[static_cast<std::size_t>(axes)] * std::pow(h[a] / length2, 2);
        }
        const double edge = 3 - diagonals;
        if (!(edge > 1e-9)) return {};
        w[static_cast<std::size_t>(1 << a)] = edge;
    }
    double sum = 0;
    for (int axes = 1; axes <= all; ++axes) sum += directions(axes) * w[static_cast<std::size_t>(axes)];
    std::array<double, 8> share{};
    for (int axes = 1; axes <= all; ++axes) share[static_cast<std::size_t>(axes)] = (D == 2 ? 4 : 6) / sum * w[static_cast<std::size_t>(axes)] / alike(axes, D);
    return share;
}

Eigen::VectorXd isotropic_measure(const SpringMesh& mesh) {
    Eigen::VectorXd measure = mesh.incident_measure;
    if (!has_cells(mesh)) return measure;
    const int D = mesh.dimension();
    Eigen::MatrixXd span(mesh.spring_count(), D);
    for (int s = 0; s < mesh.spring_count(); ++s) span.row(s) = (mesh.nodes.row(mesh.springs(s, 0)) - mesh.nodes.row(mesh.springs(s, 1))).cwiseAbs();
    const Point cell_m = span.colwise().maxCoeff().transpose();
    const std::optional<std::array<double, 8>> share = isotropic_shares(cell_m);
    if (!share || !(span.rowwise().minCoeff().maxCoeff() > 0)) return measure;  // without diagonals nothing is isotropic
    for (int s = 0; s < mesh.spring_count(); ++s) {
        int axes = 0;
        for (int a = 0; a < D; ++a) axes |= span(s, a) > 0.5 * cell_m[a] ? 1 << a : 0;
        const double ratio = (*share)[static_cast<std::size_t>(axes)] / share_of_7(axes, D);
        if (std::abs(ratio - 1) > 1e-9) measure[s] *= ratio;  // squares have (7)'s shares, but for rounding
    }
    return measure;
}

}  // namespace tissue
