#include <fmt/format.h>

#include <algorithm>

#include <iostream>

#include "cases/plan.h"
#include "cases/shape_checks.h"
#include "cases/study_mesh.h"
#include "command.h"
#include "error.h"
#include "io/atomic_file.h"
#include "io/one_line.h"
#include "mesh/shape.h"
#include "mesh/solid_shape.h"
#include "mesh/surface.h"
#include "mesh/surface_remesh.h"
#include "study/study.h"
#include "surface_file/surface_file.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string study, mesh, out;
    bool words = false, curves = false, surface = false, filled = false;
};

/// A surface of triangles, remeshed to sides of lattice.size_m, for gmsh to fill.
std::string divided_surface(const Study& study, const MshFile& mesh) {
    constexpr int rounds = 8;
    const Study::Geometry& g = study.geometry;
    const Surface surface = make_surface(mesh, g.fixed, g.unit_m, read_other_surface, g.beds());
    SurfaceRemesh divided(surface, {Eigen::Vector3d::Zero(), 0, study.spring_size_m, study.spring_size_m});
    divided.remesh(rounds);
    try {
        check_fixed_area(surface, divided.surface());
    } catch (const MismatchError& e) {
        throw StudyError(one_line(fmt::format("{}: key 'lattice.size_m': {}", study.file, e.what())));
    }
    return to_msh(divided.surface());
}

void run(const Options& o) {
    const Study study = read_study(o.study);
    const Study::Geometry& g = study.geometry;
    if (g.is_block()) throw MismatchError("study '" + study.name + "' has a block and no geometry.shape");
    if ((o.surface || o.filled) && !(g.is_solid() && study.spring_size_m > 0))
        throw MismatchError("study '" + study.name + "' has no surface in space to remesh with edges of lattice.size_m");
    if (o.words) {
        std::cout << shape_words(study) << '\n';
        return;
    }
    if (o.mesh.empty() || o.out.empty()) throw CLI::RequiredError(o.mesh.empty() ? "--mesh" : "--out");
    // messages name the user's file, not the mesh that gmsh made of it
    const MshFile mesh = o.surface ? read_surface_or_msh(o.mesh, g.shape) : read_msh(o.mesh, g.is_solid(), g.shape);
    if (!o.filled) refuse_wrong_unit(study, mesh);
    if (o.curves) return;
    if (o.surface) return write_file(o.out, divided_surface(study, mesh));
    ShapeNotes notes;
    const std::vector<std::string> regions = study.material.region_names();
    std::vector<std::string> held;  // names that divided_surface gave to fixed parts
    std::vector<int> beds = g.beds();
    std::sort(beds.begin(), beds.end());
    beds.erase(std::unique(beds.begin(), beds.end()), beds.end());
    if (beds.empty()) beds.push_back(0);
    for (int bed : beds) held.push_back(fixed_name(fixed_label_of(bed)));
    const Shape shape = o.filled ? make_solid_shape(mesh, held, {}, 1, &notes, {}, beds)
                        : g.is_solid() ? make_solid_shape(mesh, g.fixed, regions, g.unit_m, &notes, read_other_surface, g.beds())
                                       : make_shape(mesh, g.fixed, regions, g.unit_m, &notes);
    refuse_nodule_outside(study, shape);
    if (notes.turned > 0)
        std::cerr << fmt::format("shape: {} {} of {} {} and were turned\n", notes.turned, g.is_solid() ? "tetrahedra" : "triangles", g.shape,
                                 g.is_solid() ? "were inverted" : "were clockwise");
    if (const std::string finer = finer_than_asked(study, shape); !finer.empty()) std::cerr << "shape: warning: " << finer << '\n';
    write_file(o.out, to_msh(shape, regions));
}

}  // namespace

void add_shape(CLI::App& app, const Invocation&) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("shape", "Check a study's own shape and write its mesh.");
    command->add_option("--study", o->study, "study file")->required()->type_name("FILE");
    command->add_option("--mesh", o->mesh, "the shape as gmsh saved it, MSH 2.2; with --surface the surface's file itself")->type_name("FILE");
    command->add_option("--out", o->out, "mesh.msh to write")->type_name("FILE");
    command->add_flag("--words", o->words, "print only the shape's file and gmsh's arguments, for scripts/mesh");
    command->add_flag("--curves", o->curves, "the mesh has only the curves of a .geo: check that its unit is the study's, and write nothing");
    command->add_flag("--surface", o->surface, "write the surface of an .stl, .obj, .ply, .off or .glb, remeshed with edges of lattice.size_m, for gmsh to fill");
    command->add_flag("--filled", o->filled, "the mesh is the filled surface");
    command->callback([o] { run(*o); });
}

}  // namespace tissue::cli
