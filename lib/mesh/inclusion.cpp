#include "mesh/inclusion.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "error.h"
#include "mesh/surface_remesh.h"
#include "mesh/surface_report.h"

namespace tissue {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

constexpr double pi = 3.14159265358979323846;

struct Volume {
    double m3;
    Eigen::Vector3d centre_m;
};
/// By tetrahedra from a point to every triangle.
Volume volume_of(const Surface& s) {
    const Eigen::Vector3d from = s.corner(0, 0);
    Volume sum{0, Eigen::Vector3d::Zero()};
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
        const Eigen::Vector3d a = s.corner(t, 0) - from, b = s.corner(t, 1) - from, c = s.corner(t, 2) - from;
        const double m3 = a.cross(b).dot(c) / 6;
        sum.m3 += m3;
        sum.centre_m += m3 * (a + b + c) / 4;
    }
    sum.centre_m = from + sum.centre_m / sum.m3;
    return sum;
}

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
    explicit Inside(const Surface& s) : mesh(mesh_of(s)), side(mesh) {}
    Mesh mesh;
    CGAL::Side_of_triangle_mesh<Mesh, Kernel> side;
};

Inclusion::Inclusion(const Eigen::Vector3d& centre_m, double radius_m)
    : centre_m_(centre_m), low_m_(centre_m.array() - radius_m), high_m_(centre_m.array() + radius_m), volume_m3_(4 * pi / 3 * std::pow(radius_m, 3)) {}

Inclusion::Inclusion(const Surface& surface)
    : inside_(std::make_shared<Inside>(surface)), low_m_(surface.nodes.colwise().minCoeff().transpose()), high_m_(surface.nodes.colwise().maxCoeff().transpose()) {
    const Volume volume = volume_of(surface);
    centre_m_ = volume.centre_m;
    volume_m3_ = volume.m3;
}

bool Inclusion::contains(const Eigen::Vector3d& place_m) const {
    if (!inside_) return (place_m - centre_m_).norm() < high_m_.x() - centre_m_.x();
    if ((place_m.array() < low_m_.array()).any() || (place_m.array() > high_m_.array()).any()) return false;
    return inside_->side({place_m.x(), place_m.y(), place_m.z()}) == CGAL::ON_BOUNDED_SIDE;
}

double Inclusion::radius_m() const { return std::cbrt(volume_m3_ / (4 * pi / 3)); }

Surface inclusion_surface(const MshFile& file, double unit_m) {
    if (const SurfaceReport report = report_on(file); !report.faults.empty())
        throw FileError(fmt::format("{}: {}; tissuectl surface says more, and repairs it", file.file, fault_text(report.faults.front(), "", 1)));
    return closed_surface(file, unit_m);
}

Surface inclusion_facets(const Surface& surface, double size_m) {
    constexpr int rounds = 6;
    SurfaceRemesh mesh(surface, {Eigen::Vector3d::Zero(), 0, size_m, size_m});
    mesh.remesh(rounds);
    Surface made = mesh.surface();
    const Volume wanted = volume_of(surface), has = volume_of(made);
    made.nodes = ((made.nodes.rowwise() - has.centre_m.transpose()) * std::cbrt(wanted.m3 / has.m3)).rowwise() + wanted.centre_m.transpose();
    return made;
}

}  // namespace tissue
