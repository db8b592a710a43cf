#include "cases/study_mesh.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <limits>

#include "error.h"
#include "io/one_line.h"
#include "mesh/facet.h"
#include "mesh/open_faces.h"
#include "mesh/solid_shape.h"
#include "mesh/topology.h"

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

void refuse_nodule_outside(const Study& study, const Shape& shape) {
    if (!study.nodule) return;
    const Study::Nodule& nodule = *study.nodule;
    const auto refuse = [&](const char* key, const std::string& cause) {
        throw StudyError(one_line(fmt::format("{}: key 'nodule.{}': ({:g}, {:g}, {:g}) m {}", study.file, key, nodule.centre_m[0], nodule.centre_m[1],
                                              nodule.centre_m[2], cause)));
    };
    bool inside = false;
    for (Eigen::Index t = 0; t < shape.simplices.rows() && !inside; ++t) {
        Eigen::Matrix4d corners;  // [places; 1], of which the centre is a mean with no negative weight
        for (int k = 0; k < 4; ++k) corners.col(k) << shape.nodes.row(shape.simplices(t, k)).transpose(), 1;
        const Eigen::Vector4d centre(nodule.centre_m[0], nodule.centre_m[1], nodule.centre_m[2], 1);
        inside = corners.lu().solve(centre).minCoeff() >= 0;
    }
    if (!inside) refuse("centre_m", "is not inside " + study.geometry.shape);
    const Cells surface = open_faces(shape.simplices);
    double surface_m = std::numeric_limits<double>::infinity();
    for (Eigen::Index f = 0; f < surface.rows(); ++f)
        surface_m = std::min(surface_m, nearest_on_facet(shape.nodes, surface, f, nodule.centre_m).distance_m);
    constexpr double out = 1.03;  // where the sphere's nodes are, over its radius (fem/fill3.geo)
    const double least_m = out * nodule.radius_m + study.sizes_m[0] / 2;
    if (surface_m < least_m)
        refuse("radius_m", fmt::format("is {:.3g} mm from the surface of {}; a nodule of {:g} mm needs {:g} mm, half of mesh.sizes_m[0] more "
                                       "than {:g} of its radius", 1e3 * surface_m, study.geometry.shape, 1e3 * nodule.radius_m, 1e3 * least_m, out));
}

}  // namespace tissue
