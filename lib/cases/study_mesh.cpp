#include "cases/study_mesh.h"

#include "error.h"

namespace tissue {

SpringMesh study_mesh(const Study& study, const std::optional<Shape>& shape, const std::string& topology) {
    if (!study.geometry.is_block()) {
        if (!shape) throw MismatchError("study '" + study.name + "' has a shape, and these cases have none");
        if (topology != "edges") throw MismatchError("topology '" + topology + "' is not possible on a shape; allowed: edges");
        return edge_mesh(*shape);
    }
    const auto lattice = [&](const std::string& grid) {
        return make_lattice(grid, study.cells[0], study.cells[1], study.geometry.width_m, study.geometry.height_m);
    };
    return topology == "edges" ? edge_mesh(shape_of(lattice("grid4"))) : lattice(topology);
}

std::optional<Shape> study_shape(const Study& study, const std::string& mesh_file) {
    if (study.geometry.is_block()) return std::nullopt;
    if (mesh_file.empty())
        throw MismatchError("study '" + study.name + "' has a shape: --mesh must name the mesh that tissuectl shape wrote");
    return read_shape(mesh_file);
}

}  // namespace tissue
