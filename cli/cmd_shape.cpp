#include <fmt/format.h>

#include <iostream>

#include "command.h"
#include "error.h"
#include "io/atomic_file.h"
#include "mesh/shape.h"
#include "mesh/solid_shape.h"
#include "study/study.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string study, mesh, out;
};

void run(const Options& o) {
    const Study study = read_study(o.study);
    const Study::Geometry& g = study.geometry;
    if (g.is_block()) throw MismatchError("study '" + study.name + "' is of the block; it has no geometry.shape");
    MshFile mesh = read_msh(o.mesh, g.is_solid());
    mesh.file = g.shape;  // what the user knows of; the mesh is what gmsh made of it
    ShapeNotes notes;
    const auto make = g.is_solid() ? make_solid_shape : make_shape;
    const Shape shape = make(mesh, g.fixed, study.material.region_names(), g.unit_m, &notes);
    if (notes.turned > 0)
        std::cerr << fmt::format("shape: {} {} of {} {} and were turned\n", notes.turned, g.is_solid() ? "tetrahedra" : "triangles", g.shape,
                                 g.is_solid() ? "were inside out" : "ran clockwise");
    write_file(o.out, to_msh(shape, study.material.region_names()));
}

}  // namespace

void add_shape(CLI::App& app, const Invocation&) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("shape", "Check a study's own shape and write the mesh of its springs.");
    command->add_option("--study", o->study, "study file")->required()->type_name("FILE");
    command->add_option("--mesh", o->mesh, "the shape as gmsh saved it, MSH 2.2")->required()->type_name("FILE");
    command->add_option("--out", o->out, "mesh.msh to write")->required()->type_name("FILE");
    command->callback([o] { run(*o); });
}

}  // namespace tissue::cli
