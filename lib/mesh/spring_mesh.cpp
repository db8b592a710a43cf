#include "mesh/spring_mesh.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "error.h"
#include "mesh/facet.h"

namespace tissue {
namespace {

double tolerance_of(const SpringMesh& mesh) {
    return 1e-6 * mesh.size_m();
}

}  // namespace

double size_m(const NodeField& nodes) {
    return (nodes.colwise().maxCoeff() - nodes.colwise().minCoeff()).maxCoeff();
}

bool has_nodes(const SpringMesh& mesh, const NodeField& places) {
    const auto own = mesh.own_nodes();
    return places.rows() == own.rows() && places.cols() == own.cols() && places.isApprox(own, 1e-9);
}

std::vector<int> SpringMesh::loop() const {
    std::vector<int> nodes_in_order(static_cast<std::size_t>(facets.rows()));
    for (std::size_t b = 0; b < nodes_in_order.size(); ++b) nodes_in_order[b] = facets(static_cast<Eigen::Index>(b), 0);
    return nodes_in_order;
}

Cells loop_facets(const std::vector<int>& loop) {
    Cells facets(static_cast<Eigen::Index>(loop.size()), 2);
    for (std::size_t b = 0; b < loop.size(); ++b)
        facets.row(static_cast<Eigen::Index>(b)) << loop[b], loop[(b + 1) % loop.size()];
    return facets;
}

SurfacePoint locate_on_surface(const SpringMesh& mesh, const Eigen::Vector2d& position_m) {
    double best = std::numeric_limits<double>::infinity();
    SurfacePoint point{};
    for (Eigen::Index b = 0; b < mesh.facets.rows(); ++b) {
        const int i = mesh.facets(b, 0), j = mesh.facets(b, 1);
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

void check_on_surface(const SpringMesh& mesh, const Point& position_m) {
    if (!mesh.is_solid()) {
        locate_on_surface(mesh, position_m);
        return;
    }
    double best = std::numeric_limits<double>::infinity();
    for (Eigen::Index b = 0; b < mesh.facets.rows(); ++b) best = std::min(best, nearest_on_facet(mesh.nodes, mesh.facets, b, position_m).distance_m);
    if (!(best <= tolerance_of(mesh)))
        throw MismatchError(fmt::format("the contact ({}, {}, {}) m is not on the surface; it is {:.3g} mm away from it",
                                        position_m[0], position_m[1], position_m[2], 1e3 * best));
}

int node_at(const SpringMesh& mesh, const Point& position_m) {
    Eigen::Index nearest;
    const double distance =
        (mesh.nodes.rowwise() - position_m.transpose()).rowwise().norm().minCoeff(&nearest);
    if (!(distance <= tolerance_of(mesh)))
        throw MismatchError(fmt::format("no lattice node at ({}) m; the nearest is {:.3g} mm away", fmt::join(position_m, ", "),
                                        1e3 * distance));
    return static_cast<int>(nearest);
}

}  // namespace tissue
