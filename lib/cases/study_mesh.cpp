#include "cases/study_mesh.h"

#include "error.h"
#include "mesh/solid_shape.h"
#include "mesh/topology.h"

namespace tissue {

SpringMesh study_mesh(const Study& study, const std::optional<Shape>& shape, const std::string& topology) {
    if (study.geometry.is_block()) return make_lattice(topology, study.lattice());
    if (!shape) throw MismatchError("study '" + study.name + "' has a shape, and these cases have none");
    const Topology& kind = topologies().at(topology);
    if (shape->is_solid() != study.geometry.is_solid()) throw MismatchError("study '" + study.name + "' is of other dimensions than its shape");
    if (kind.needs_lattice()) throw MismatchError("topology '" + topology + "' is not possible on a shape");
    return kind.on_shape(*shape);
}

NodeField study_nodes(const Study& study, const std::optional<Shape>& shape) {
    return study_mesh(study, shape, study.geometry.is_solid() ? study.springs.topology : "edges").nodes;
}

std::optional<Shape> study_shape(const Study& study, const std::string& mesh_file) {
    if (study.geometry.is_block()) return std::nullopt;
    if (mesh_file.empty())
        throw MismatchError("study '" + study.name + "' has a shape: --mesh must name the mesh that tissuectl shape wrote");
    return study.geometry.is_solid() ? read_solid_shape(mesh_file) : read_shape(mesh_file);
}

}  // namespace tissue
