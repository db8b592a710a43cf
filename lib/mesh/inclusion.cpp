#include "mesh/inclusion.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "error.h"
#include "mesh/surface_remesh.h"
#include "mesh/surface_report.h"

namespace tissue {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

constexpr double ball = 4 * 3.14159265358979323846 / 3;  // volume over radius^3

Mesh mesh_of(const Surface& s) {
    Mesh mesh;
    std::vector<Mesh::Vertex_index> vertex;
    for (const auto& p : s.nodes.rowwise()) vertex.push_back(mesh.add_vertex({p[0], p[1], p[2]}));
    for (const auto& t : s.triangles.rowwise())
        mesh.add_face(vertex[static_cast<std::size_t>(t[0])], vertex[static_cast<std::size_t>(t[1])], vertex[static_cast<std::size_t>(t[2])]);
    return mesh;
}

}  // namespace

struct Inclusion::Inside {
    explicit Inside(const Surface& s) : surface(s), mesh(mesh_of(s)), side(mesh) {}
    Surface surface;
    Mesh mesh;
    CGAL::Side_of_triangle_mesh<Mesh, Kernel> side;
};

Inclusion::Inclusion(const Eigen::Vector3d& centre_m, double radius_m)
    : centre_m_(centre_m), low_m_(centre_m.array() - radius_m), high_m_(centre_m.array() + radius_m), radius_m_(radius_m) {}

Inclusion::Inclusion(const Surface& surface)
    : inside_(std::make_shared<Inside>(surface)), low_m_(surface.nodes.colwise().minCoeff().transpose()), high_m_(surface.nodes.colwise().maxCoeff().transpose()) {
    const Enclosed enclosed = enclosed_by(surface);
    centre_m_ = enclosed.centre_m;
    radius_m_ = std::cbrt(enclosed.volume_m3 / ball);
}

bool Inclusion::contains(const Eigen::Vector3d& place_m) const {
    if (!inside_) return (place_m - centre_m_).norm() < radius_m_;
    if ((place_m.array() < low_m_.array()).any() || (place_m.array() > high_m_.array()).any()) return false;
    return inside_->side({place_m.x(), place_m.y(), place_m.z()}) == CGAL::ON_BOUNDED_SIDE;
}

const Surface* Inclusion::surface() const { return inside_ ? &inside_->surface : nullptr; }

double Inclusion::volume_m3() const { return ball * std::pow(radius_m_, 3); }

Surface inclusion_surface(const MshFile& file, double unit_m) {
    if (const SurfaceReport report = report_on(file); !report.faults.empty())
        throw FileError(fmt::format("{}: {}; tissuectl surface reports all faults and repairs them", file.file, fault_text(report.faults.front(), " mm", 1e3 * unit_m)));
    return closed_surface(file, unit_m);
}

Surface inclusion_facets(const Surface& surface, double most_m) {
    constexpr double part = 0.6, least_quality = 0.1;
    constexpr int rounds = 6;
    const Enclosed wanted = enclosed_by(surface);
    const double size_m = std::min(most_m, part * std::cbrt(wanted.volume_m3 / ball));
    SurfaceRemesh mesh(surface, {Eigen::Vector3d::Zero(), 0, size_m, size_m}, -1);
    mesh.remesh(rounds);
    Surface made = mesh.surface();
    const Enclosed has = enclosed_by(made);
    made.nodes = ((made.nodes.rowwise() - has.centre_m.transpose()) * std::cbrt(wanted.volume_m3 / has.volume_m3)).rowwise() + wanted.centre_m.transpose();
    for (Eigen::Index t = 0; t < made.triangles.rows(); ++t)
        if (const double quality = triangle_quality(made.corner(t, 0), made.corner(t, 1), made.corner(t, 2)); quality < least_quality)
            throw MismatchError(fmt::format("it has poor triangles with edges of {:.3g} mm: quality {:.3g}, needed {}", 1e3 * size_m, quality, least_quality));
    return made;
}

}  // namespace tissue
