#include "mesh/spring_mesh.h"

#include <fmt/format.h>

#include "error.h"

namespace tissue {
namespace {

double tolerance_of(const SpringMesh& mesh) {
    return 1e-6 * (mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).maxCoeff();
}

}  // namespace

SurfacePoint locate_on_surface(const SpringMesh& mesh, const Eigen::Vector2d& position_m) {
    double best = std::numeric_limits<double>::infinity();
    SurfacePoint point{};
    for (std::size_t b = 0; b < mesh.boundary.size(); ++b) {
        const int i = mesh.boundary[b], j = mesh.boundary[(b + 1) % mesh.boundary.size()];
        const Eigen::Vector2d start = mesh.nodes.row(i), along = mesh.nodes.row(j) - mesh.nodes.row(i);
        const double w = std::clamp((position_m - start).dot(along) / along.squaredNorm(), 0.0, 1.0);
        const double distance = (start + w * along - position_m).norm();
        if (distance < best) {
            best = distance;
            point = {{i, j}, {1 - w, w}};
        }
    }
    if (!(best <= tolerance_of(mesh)))
        throw MismatchError(fmt::format("the contact ({}, {}) m is not on the surface; it is {:.3g} mm away from it",
                                        position_m.x(), position_m.y(), 1e3 * best));
    return point;
}

int node_at(const SpringMesh& mesh, const Eigen::Vector2d& position_m) {
    Eigen::Index nearest;
    const double distance =
        (mesh.nodes.rowwise() - position_m.transpose()).rowwise().norm().minCoeff(&nearest);
    if (!(distance <= tolerance_of(mesh)))
        throw MismatchError(fmt::format("no lattice node at ({}, {}) m; the nearest is {:.3g} mm away", position_m.x(),
                                        position_m.y(), 1e3 * distance));
    return static_cast<int>(nearest);
}

}  // namespace tissue
