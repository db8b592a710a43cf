#include "mesh/carried_surface.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "error.h"
#include "mesh/nearest_triangle.h"
#include "mesh/surface.h"

namespace tissue {
namespace {

constexpr double farthest = 0.1;  ///< largest distance of a vertex from the boundary, over the mesh's size

void refuse_the_plane(const SpringMesh& mesh) {
    if (!mesh.is_solid()) throw MismatchError("the model is in the plane; surfaces need a model in space");
}

}  // namespace

NodeField vertex_normals(const NodeField& vertices, const Cells& facets) {
    NodeField normals = NodeField::Zero(vertices.rows(), 3);
    for (const auto& facet : facets.rowwise()) {
        const Eigen::RowVector3d a = vertices.row(facet[0]), b = vertices.row(facet[1]), c = vertices.row(facet[2]);
        const Eigen::RowVector3d normal = (b - a).cross(c - a);
        for (const int corner : facet) normals.row(corner) += normal;
    }
    for (Eigen::Index v = 0; v < normals.rows(); ++v)
        if (const double length = normals.row(v).norm(); length > 0) normals.row(v) /= length;
    return normals;
}

NodeField CarriedSurface::moved(const NodeField& u) const {
    NodeField places = vertices;
    for (Eigen::Index v = 0; v < places.rows(); ++v)
        for (int k = 0; k < 3; ++k) places.row(v) += weight(v, k) * u.row(node(v, k));
    return places;
}

CarriedSurface carried_surface(const SpringMesh& mesh, const MshFile& file, double unit_m) {
    refuse_the_plane(mesh);
    if (file.triangles.empty()) throw MismatchError(file.file + ": has no triangles");
    CarriedSurface carried;
    std::vector<int> used;  // points of the triangles, ascending
    for (const MshFile::Element& e : file.triangles) used.insert(used.end(), e.node, e.node + 3);
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    const auto V = static_cast<Eigen::Index>(used.size()), F = static_cast<Eigen::Index>(file.triangles.size());
    carried.vertices.resize(V, 3);
    for (Eigen::Index v = 0; v < V; ++v) {
        const MshFile::Point& p = file.points[static_cast<std::size_t>(used[static_cast<std::size_t>(v)])];
        carried.vertices.row(v) << unit_m * p.x, unit_m * p.y, unit_m * p.z;
    }
    carried.facets.resize(F, 3);
    for (Eigen::Index f = 0; f < F; ++f)
        for (int k = 0; k < 3; ++k)
            carried.facets(f, k) = static_cast<int>(std::lower_bound(used.begin(), used.end(), file.triangles[static_cast<std::size_t>(f)].node[k]) - used.begin());
    // a negative volume: all normals point inwards
    if (enclosed_by({carried.vertices, carried.facets, {}}).volume_m3 < 0) carried.facets.col(1).swap(carried.facets.col(2));

    const NearestTriangle boundary({mesh.nodes, mesh.facets, std::vector<int>(static_cast<std::size_t>(mesh.facets.rows()), Surface::free_label)});
    const NodeField normals = vertex_normals(carried.vertices, carried.facets);
    carried.node.resize(V, 3);
    carried.weight.resize(V, 3);
    double most_m = 0;
    for (Eigen::Index v = 0; v < V; ++v) {
        const Eigen::Vector3d at = carried.vertices.row(v).transpose();
        NearestTriangle::Place place = boundary.nearest(at, normals.row(v).transpose());
        if (place.triangle < 0) place = boundary.nearest(at);
        most_m = std::max(most_m, place.distance_m);
        carried.node.row(v) = mesh.facets.row(place.triangle);
        carried.weight.row(v) = place.weight.transpose();
    }
    if (!(most_m <= farthest * mesh.size_m()))
        throw MismatchError(fmt::format("{}: is up to {:.3g} mm from the model, which is {:.3g} mm long: is it the surface of another organ, or is its unit not {:g} m?",
                                        file.file, 1e3 * most_m, 1e3 * mesh.size_m(), unit_m));
    return carried;
}

CarriedSurface own_surface(const SpringMesh& mesh) {
    refuse_the_plane(mesh);
    CarriedSurface carried;
    std::vector<int> shown(mesh.facets.data(), mesh.facets.data() + mesh.facets.size());
    std::sort(shown.begin(), shown.end());
    shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
    const auto V = static_cast<Eigen::Index>(shown.size());
    carried.vertices = mesh.nodes(shown, Eigen::all);
    carried.facets = mesh.facets.unaryExpr([&](int node) { return static_cast<int>(std::lower_bound(shown.begin(), shown.end(), node) - shown.begin()); });
    carried.node.resize(V, 3);
    carried.weight = NodeField::Zero(V, 3);
    carried.weight.col(0).setOnes();
    for (Eigen::Index v = 0; v < V; ++v) carried.node.row(v).setConstant(shown[static_cast<std::size_t>(v)]);
    return carried;
}

}  // namespace tissue
