#include "cases/study_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "error.h"
#include "io/one_line.h"
#include "mesh/inclusion.h"
#include "mesh/open_faces.h"
#include "mesh/solid_block.h"
#include "mesh/solid_shape.h"
#include "mesh/nearest_triangle.h"
#include "mesh/surface.h"
#include "mesh/topology.h"

namespace tissue {

SpringMesh study_mesh(const Study& study, const std::optional<Shape>& shape, const std::string& topology) {
    if (study.geometry.is_block() && !study.geometry.is_solid()) return make_lattice(topology, study.lattice());
    if (study.geometry.is_block()) return topologies().at(topology).on_shape(solid_block(study.lattice()), study.springs.spacing_m);
    if (!shape) throw MismatchError("study '" + study.name + "' has a shape, and these cases have none");
    const Topology& kind = topologies().at(topology);
    if (shape->is_solid() != study.geometry.is_solid()) throw MismatchError("study '" + study.name + "' and its shape have different dimensions");
    if (kind.needs_lattice()) throw MismatchError("topology '" + topology + "' is not possible on a shape");
    return kind.on_shape(*shape, study.springs.spacing_m);
}

Shape study_solid(const Study& study, const std::optional<Shape>& shape) {
    if (study.geometry.is_block()) return solid_block(study.lattice());
    if (!shape) throw MismatchError("study '" + study.name + "' has a shape, and these cases have none");
    return *shape;
}

NodeField study_nodes(const Study& study, const std::optional<Shape>& shape) {
    if (study.geometry.is_solid()) return study_solid(study, shape).nodes;
    if (shape) return shape->nodes;
    return study_mesh(study, shape, study.springs.topology).nodes;
}

std::optional<Shape> study_shape(const Study& study, const std::string& mesh_file) {
    if (study.geometry.is_block()) return std::nullopt;
    if (mesh_file.empty())
        throw MismatchError("study '" + study.name + "' has a shape: --mesh must name the mesh that tissuectl shape wrote");
    const Shape shape = study.geometry.is_solid() ? read_solid_shape(mesh_file) : read_shape(mesh_file);
    refuse_nodule_outside(study, shape);
    return shape;
}

namespace {

/// Points of a triangle no farther apart than apart_m, its corners included; at most 100 intervals along a side.
std::vector<Eigen::Vector3d> places_on(const Surface& surface, Eigen::Index triangle, double apart_m) {
    constexpr double most = 100;
    const Eigen::Vector3d a = surface.corner(triangle, 0), b = surface.corner(triangle, 1) - a, c = surface.corner(triangle, 2) - a;
    const int parts = static_cast<int>(std::clamp(std::ceil(std::max({b.norm(), c.norm(), (c - b).norm()}) / apart_m), 1.0, most));
    std::vector<Eigen::Vector3d> places;
    for (int i = 0; i <= parts; ++i)
        for (int j = 0; i + j <= parts; ++j) places.push_back(a + i * b / parts + j * c / parts);
    return places;
}

}  // namespace

void refuse_nodule_outside(const Study& study, const Shape& shape) {
    if (!study.nodule) return;
    const auto refuse = [&](const char* key, const Eigen::Vector3d& place_m, const std::string& cause) {
        throw StudyError(one_line(fmt::format("{}: key 'nodule.{}': ({:g}, {:g}, {:g}) m {}", study.file, key, place_m[0], place_m[1], place_m[2], cause)));
    };
    const Inclusion& nodule = study.nodule->inclusion;
    const Cells facets = open_faces(shape.simplices);
    const Surface boundary{shape.nodes, facets, std::vector<int>(static_cast<std::size_t>(facets.rows()), Surface::free_label)};
    const Inclusion tissue(boundary);
    const NearestTriangle nearest(boundary);
    const double half_m = study.sizes_m[0] / 2;
    if (!nodule.surface()) {
        if (!tissue.contains(nodule.centre_m())) refuse("centre_m", nodule.centre_m(), "is not inside " + study.geometry.shape);
        // Distance of the mesh's nodes on the ball from its centre, over its radius (fem/fill3.geo).
        constexpr double out = 1.03;
        const double surface_m = nearest.nearest(nodule.centre_m()).distance_m, least_m = out * nodule.radius_m() + half_m;
        if (surface_m < least_m)
            refuse("radius_m", nodule.centre_m(), fmt::format("is {:.3g} mm from the surface of {}; a nodule of {:g} mm needs {:g} mm, half of mesh.sizes_m[0] more "
                                                              "than {:g} of its radius", 1e3 * surface_m, study.geometry.shape, 1e3 * nodule.radius_m(), 1e3 * least_m, out));
        return;
    }
    for (Eigen::Index t = 0; t < nodule.surface()->triangles.rows(); ++t)
        for (const Eigen::Vector3d& place_m : places_on(*nodule.surface(), t, half_m)) {
            if (!tissue.contains(place_m)) refuse("shape", place_m, fmt::format("of {} is not inside {}", study.nodule->shape, study.geometry.shape));
            if (const double surface_m = nearest.nearest(place_m).distance_m; surface_m < half_m)
                refuse("shape", place_m, fmt::format("of {} is {:.3g} mm from the surface of {}; it needs {:g} mm, half of mesh.sizes_m[0]", study.nodule->shape, 1e3 * surface_m, study.geometry.shape, 1e3 * half_m));
        }
}

}  // namespace tissue
