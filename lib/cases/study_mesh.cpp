#include "cases/study_mesh.h"

#include <fmt/format.h>

#include "error.h"
#include "io/one_line.h"
#include "mesh/open_faces.h"
#include "mesh/solid_shape.h"
#include "mesh/surface.h"
#include "mesh/topology.h"
#include "surface_file/surface_file.h"

namespace tissue {

SpringMesh study_mesh(const Study& study, const std::optional<Shape>& shape, const std::string& topology) {
    if (study.geometry.is_block()) return make_lattice(topology, study.lattice());
    if (!shape) throw MismatchError("study '" + study.name + "' has a shape, and these cases have none");
    const Topology& kind = topologies().at(topology);
    if (shape->is_solid() != study.geometry.is_solid()) throw MismatchError("study '" + study.name + "' is of other dimensions than its shape");
    if (kind.needs_lattice()) throw MismatchError("topology '" + topology + "' is not possible on a shape");
    return kind.on_shape(*shape, study.springs.spacing_m);
}

NodeField study_nodes(const Study& study, const std::optional<Shape>& shape) {
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

Inclusion study_inclusion(const Study& study) {
    const Study::Nodule& nodule = *study.nodule;
    if (nodule.shape.empty()) return {nodule.centre_m, nodule.radius_m};
    return Inclusion(inclusion_surface(read_surface_file(nodule.shape), study.geometry.unit_m));
}

void refuse_nodule_outside(const Study& study, const Shape& shape) {
    if (!study.nodule) return;
    const Study::Nodule& nodule = *study.nodule;
    const auto refuse = [&](const char* key, const Eigen::Vector3d& place_m, const std::string& cause) {
        throw StudyError(one_line(fmt::format("{}: key 'nodule.{}': ({:g}, {:g}, {:g}) m {}", study.file, key, place_m[0], place_m[1], place_m[2], cause)));
    };
    const Cells facets = open_faces(shape.simplices);
    const Surface surface{shape.nodes, facets, std::vector<int>(static_cast<std::size_t>(facets.rows()), Surface::free_label)};
    const Inclusion tissue(surface);
    const NearestTriangle nearest(surface);
    if (nodule.shape.empty()) {
        if (!tissue.contains(nodule.centre_m)) refuse("centre_m", nodule.centre_m, "is not inside " + study.geometry.shape);
        constexpr double out = 1.03;  // where the sphere's nodes are, over its radius (fem/fill3.geo)
        const double surface_m = nearest.nearest(nodule.centre_m).distance_m, least_m = out * nodule.radius_m + study.sizes_m[0] / 2;
        if (surface_m < least_m)
            refuse("radius_m", nodule.centre_m, fmt::format("is {:.3g} mm from the surface of {}; a nodule of {:g} mm needs {:g} mm, half of mesh.sizes_m[0] more "
                                                            "than {:g} of its radius", 1e3 * surface_m, study.geometry.shape, 1e3 * nodule.radius_m, 1e3 * least_m, out));
        return;
    }
    const double least_m = study.sizes_m[0] / 2;
    const Surface given = inclusion_surface(read_surface_file(nodule.shape), study.geometry.unit_m);
    for (const auto& node : given.nodes.rowwise()) {
        const Eigen::Vector3d place_m = node.transpose();
        if (!tissue.contains(place_m)) refuse("shape", place_m, fmt::format("of {} is not inside {}", nodule.shape, study.geometry.shape));
        if (const double surface_m = nearest.nearest(place_m).distance_m; surface_m < least_m)
            refuse("shape", place_m, fmt::format("of {} is {:.3g} mm from the surface of {}; it needs {:g} mm, half of mesh.sizes_m[0]", nodule.shape, 1e3 * surface_m, study.geometry.shape, 1e3 * least_m));
    }
}

}  // namespace tissue
