#include "api/named_surfaces.h"

#include <fmt/format.h>

#include "error.h"
#include "mesh/carried_points.h"
#include "mesh/carried_surface.h"
#include "surface_file/surface_file.h"

namespace tissue {

void NamedSurfaces::Surface::places(const NodeColumns& u, double* places_m) const noexcept {
    for (Eigen::Index v = 0; v < rest_m.rows(); ++v)
        for (Eigen::Index a = 0; a < 3; ++a) {
            double at = rest_m(v, a);
            for (Eigen::Index k = 0; k < node.cols(); ++k) at += weight(v, k) * u(node(v, k), a);
            *places_m++ = at;
        }
}

NamedSurfaces::NamedSurfaces(const TissueModel& tissue) {
    if (!tissue.mesh.is_solid()) return;
    mesh_ = std::make_shared<SpringMesh>(tissue.mesh);
    const CarriedSurface own = own_surface(*mesh_);
    all_.push_back(std::make_shared<Surface>(Surface{"boundary", own.vertices, own.facets, own.node, own.weight}));
    if (tissue.nodule.empty()) return;
    const CarriedPoints inside = carried_points(*mesh_, tissue.nodule.points);
    all_.push_back(std::make_shared<Surface>(Surface{"nodule", tissue.nodule.points, tissue.nodule.triangles, inside.node, inside.weight}));
}

void NamedSurfaces::add(const std::string& name, const std::string& file, double unit_m) {
    if (name.empty()) throw MismatchError("a surface needs a name");
    if (find(name)) throw MismatchError(fmt::format("there is already a surface '{}'", name));
    if (!(unit_m > 0 && unit_m <= 1000)) throw MismatchError(fmt::format("{}: the unit is {} m, must lie in (0, 1000]", file, unit_m));
    if (!mesh_) throw MismatchError("the model is in the plane; surfaces need a model in space");
    const CarriedSurface carried = carried_surface(*mesh_, read_surface_file(file), unit_m);
    all_.push_back(std::make_shared<Surface>(Surface{name, carried.vertices, carried.facets, carried.node, carried.weight}));
}

const NamedSurfaces::Surface* NamedSurfaces::find(std::string_view name) const noexcept {
    for (const auto& surface : all_)
        if (surface->name == name) return surface.get();
    return nullptr;
}

std::vector<std::string> NamedSurfaces::names() const {
    std::vector<std::string> all;
    for (const auto& surface : all_) all.push_back(surface->name);
    return all;
}

}  // namespace tissue
