// Shapes: MSH files of the plane, of solids and of surfaces; the shapes made from them are written and read again.
#include "fuzz_file.h"
#include "mesh/shape.h"
#include "mesh/solid_shape.h"
#include "mesh/surface.h"
#include "mesh/surface_remesh.h"

using namespace tissue;

namespace {

/// The names of a map, in its order.
std::vector<std::string> names_of(const std::map<int, std::string>& names) {
    std::vector<std::string> all;
    for (const auto& name : names) all.push_back(name.second);
    return all;
}

void make(const MshFile& mesh, bool in_space) {
    const std::vector<std::string> held = names_of(in_space ? mesh.triangle_names : mesh.line_names), regions = names_of(in_space ? mesh.tetrahedron_names : mesh.triangle_names);
    const std::vector<std::string> fixed(held.begin(), held.begin() + (held.empty() ? 0 : 1));
    const auto made = [&](const std::vector<std::string>& of) { return in_space ? make_solid_shape(mesh, fixed, of, 0.001) : make_shape(mesh, fixed, of, 0.001); };
    const Shape shape = made({});
    must(shape.nodes.allFinite(), "not finite");
    reads([&] { made(regions); });
    const FuzzFile again(to_msh(shape, {}), "mesh.msh");
    edge_mesh(in_space ? read_solid_shape(again) : read_shape(again));
}

}  // namespace

FUZZ_TARGET(msh)(const std::uint8_t* data, std::size_t size) {
    const FuzzFile file(data, size, "shape.msh");
    for (const bool in_space : {false, true}) {
        reads([&] { make(read_msh(file, in_space), in_space); });
        reads([&] { edge_mesh(in_space ? read_solid_shape(file) : read_shape(file)); });
    }
    reads([&] {
        const MshFile mesh = read_msh(file, true);
        const std::vector<std::string> held = names_of(mesh.triangle_names);
        const Surface surface = make_surface(mesh, held.empty() ? std::vector<std::string>{"surface-1"} : std::vector<std::string>{held.front()}, 0.001);
        const double size_m = (surface.nodes.colwise().maxCoeff() - surface.nodes.colwise().minCoeff()).maxCoeff();
        SurfaceRemesh divided(surface, {Eigen::Vector3d::Zero(), 0, size_m / 3, size_m / 3});
        divided.remesh(2);
        to_msh(divided.surface());
    });
    return 0;
}
