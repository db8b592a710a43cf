#include "mesh/nodule_surface.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/generators.h>
#include <CGAL/subdivision_method_3.h>
#include <fmt/format.h>

#include <map>
#include <utility>
#include <vector>

namespace tissue {

NoduleSurface nodule_surface(const Inclusion& nodule) {
    if (const Surface* given = nodule.surface()) return given->nodes.rows() > most_nodule_points ? NoduleSurface() : NoduleSurface{given->nodes, given->triangles};
    using Kernel = CGAL::Simple_cartesian<double>;
    CGAL::Surface_mesh<Kernel::Point_3> mesh;
    CGAL::make_icosahedron(mesh, Kernel::Point_3(0, 0, 0), 1.0);
    CGAL::Subdivision_method_3::Loop_subdivision(mesh, CGAL::parameters::number_of_iterations(2));
    NoduleSurface ball{NodeField(static_cast<Eigen::Index>(mesh.number_of_vertices()), 3), Cells(static_cast<Eigen::Index>(mesh.number_of_faces()), 3)};
    for (const auto v : mesh.vertices()) {
        const auto& p = mesh.point(v);
        ball.points.row(v.idx()) = (nodule.centre_m() + nodule.radius_m() * Eigen::Vector3d(p.x(), p.y(), p.z()).normalized()).transpose();
    }
    for (const auto f : mesh.faces()) {
        int k = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) ball.triangles(f.idx(), k++) = static_cast<int>(v.idx());
    }
    return ball;
}

std::optional<std::string> nodule_fault(const NoduleSurface& surface) {
    std::map<std::pair<int, int>, int> edges;  // number of triangles of each directed edge
    std::vector<bool> used(static_cast<std::size_t>(surface.points.rows()), false);
    for (const auto& t : surface.triangles.rowwise())
        for (int k = 0; k < 3; ++k) {
            used[static_cast<std::size_t>(t[k])] = true;
            ++edges[{t[k], t[(k + 1) % 3]}];
        }
    for (const auto& [edge, times] : edges)
        if (const auto back = edges.find({edge.second, edge.first}); times != 1 || back == edges.end())
            return fmt::format("are not closed between points {} and {}", edge.first, edge.second);
    for (std::size_t p = 0; p < used.size(); ++p)
        if (!used[p]) return fmt::format("do not use point {}", p);
    if (!(enclosed_by({surface.points, surface.triangles, {}}).volume_m3 > 0)) return "have inward normals, or enclose no volume";
    return std::nullopt;
}

}  // namespace tissue
