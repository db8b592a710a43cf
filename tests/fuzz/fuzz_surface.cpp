// Surface files: the first byte selects the file name's ending. The surface is checked, remeshed if it has no faults,
// and repaired if it is small.
#include "fuzz_file.h"
#include "mesh/surface.h"
#include "mesh/surface_remesh.h"
#include "mesh/surface_repair.h"
#include "mesh/surface_report.h"
#include "surface_file/surface_file.h"

using namespace tissue;

FUZZ_TARGET(surface)(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const char* ending = data[0] == 's' ? "stl" : data[0] == 'o' ? "obj" : data[0] == 'p' ? "ply" : data[0] == 'f' ? "off" : "glb";
    const FuzzFile file(data + 1, size - 1, std::string("shape.") + ending);
    reads([&] {
        const MshFile mesh = read_surface_file(file);
        const SurfaceReport report = report_on(mesh);
        for (const SurfaceFault& fault : report.faults) fault_text(fault, " mm", 1);
        if (report.faults.empty()) reads([&] {
            const std::string held = mesh.triangle_names.empty() ? "surface-1" : mesh.triangle_names.begin()->second;
            const Surface surface = make_surface(mesh, {held}, 0.001);
            const double size_m = (surface.nodes.colwise().maxCoeff() - surface.nodes.colwise().minCoeff()).maxCoeff();
            SurfaceRemesh divided(surface, {Eigen::Vector3d::Zero(), 0, size_m / 3, size_m / 3});
            divided.remesh(2);
            to_msh(divided.surface());
        });
        if (mesh.triangles.size() > 40) return;
        const double extent = (report.high - report.low).maxCoeff();
        reads([&] {
            const RepairedSurface made = repaired(mesh, {extent / 4, extent / 20});
            for (const SurfaceFault& fault : report_on(made.mesh).faults) must(fault.kind == SurfaceFault::Kind::handles, "a repaired surface has faults other than handles");
        });
    });
    return 0;
}
