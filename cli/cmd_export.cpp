#include <fmt/format.h>

#include <iostream>
#include <numeric>

#include "cases/load_path.h"
#include "command.h"
#include "error.h"
#include "export/csv.h"
#include "export/npy.h"
#include "export/sofa.h"
#include "export/surface_files.h"
#include "export/vtu.h"
#include "io/atomic_file.h"
#include "progress.h"
#include "springs/indentation_solver.h"
#include "surface_file/surface_file.h"
#include "surface_file/vtk_file.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string file, to, out, sets, set, path, surface, unit = "m";

    bool draws_surface() const { return to == "vtp" || to == "glb"; }
};

/// The load path named by --path, or all.
std::vector<const LoadPath*> chosen_paths(const Cases& cases, const Options& o) {
    std::vector<const LoadPath*> paths;
    for (const LoadPath& path : cases.paths)
        if (o.path.empty() || path.name == o.path) paths.push_back(&path);
    if (paths.empty()) throw MismatchError(fmt::format("{}: has no load path '{}'", o.file, o.path));
    return paths;
}

void export_cases(const Options& o) {
    if (o.to == "sofa") throw MismatchError(o.file + ": has load cases; a SOFA scene needs the springs of a model.h5");
    if (o.draws_surface()) throw MismatchError(fmt::format("{}: has load cases; --to {} draws the surface of a model.h5", o.file, o.to));
    if (!o.sets.empty() || !o.set.empty())
        throw MismatchError(o.file + ": has load cases; --sets and --set choose among the spring sets of a model.h5");
    const Cases cases = read_cases(o.file);
    const std::vector<const LoadPath*> paths = chosen_paths(cases, o);
    if (o.to == "csv") return write_files(o.out, csv_files(cases, paths));
    if (cases.measurement) throw MismatchError(o.file + ": has measured forces and no displacement of the tissue to draw; --to csv exports the forces");
    Files files;
    for (const LoadPath* path : paths) {
        if (path->records.empty()) std::cerr << "tissuectl export: " << path->name << ", left out: no FE reference at its first record: " << path->lost << '\n';
        files.merge(path_vtu(cases, *path));
    }
    if (files.empty()) throw MismatchError(o.file + ": no load path has a record; nothing is written");
    write_files(o.out, files);
}

/// The drawn surface under each indentation.
void export_surfaces(const Options& o, const TissueModel& model) {
    if (!model.mesh.is_solid()) throw MismatchError(fmt::format("{}: is a model in the plane; --to {} draws the surface of a model in space", o.file, o.to));
    refuse_vtk(o.surface);
    const CarriedSurface surface = o.surface.empty() ? own_surface(model.mesh) : carried_surface(model.mesh, read_surface_or_msh(o.surface, o.surface), units_m.at(o.unit));
    const IndentationSolver solver(model);
    Files files;
    for (const IndentationOfCase& c : indentations_of_cases(model, o.set)) {
        const std::string& name = model.case_names[static_cast<std::size_t>(c.load_case)];
        if (!c.state) {
            std::cerr << "tissuectl export: " << name << ", left out: " << reason_of(c.state.status) << '\n';
            continue;
        }
        const Point contact_m = model.contact_m.row(c.load_case).transpose();
        const IndentedSurface pressed{surface, name, surface.moved(solver.of(model.radius_of(c.load_case)).displayed(contact_m, c.push_m, c.state.displacement)), contact_m, c.push_m, c.state.contact_force};
        files[name + "." + o.to] = o.to == "vtp" ? surface_vtp(pressed) : surface_glb(pressed);
    }
    if (files.empty()) throw MismatchError(o.file + ": no load case has an equilibrium; nothing is written");
    write_files(o.out, files);
}

void export_energy_model(const Options& o, const TissueModel& model) {
    if (!o.sets.empty())
        throw MismatchError(o.file + ": is an energy model; --sets chooses among spring sets");
    if (o.to == "sofa") throw MismatchError(o.file + ": is an energy model, and " + sofa_lacks);
    if (!model.energy_model->relaxation.empty())
        std::cerr << "tissuectl export: " << o.file << " relaxes: it is exported with its instantaneous constants, as before any relaxation\n";
    if (o.draws_surface()) return export_surfaces(o, model);
    const std::vector<IndentationOfCase> cases = indentations_of_cases(model, o.set);
    if (o.to == "csv") return write_files(o.out, csv_files(model, cases));
    Files files;
    for (const IndentationOfCase& c : cases) {
        const std::string& name = model.case_names[static_cast<std::size_t>(c.load_case)];
        files[name + ".vtu"] = pressed_vtu(model, c);
        if (!c.state)
            std::cerr << "tissuectl export: " << name << ", drawn at rest: " << reason_of(c.state.status) << '\n';
    }
    write_files(o.out, files);
}

/// Arrays of an energy model that are not datasets of its file.
Files energy_model_arrays(const TissueModel& model) {
    if (!model.mesh.is_solid()) return npy_files(energy_model_tables(model));
    std::vector<int> load_cases(static_cast<std::size_t>(model.case_count()));
    std::iota(load_cases.begin(), load_cases.end(), 0);
    return npy_files(solid_model_tables(model), contact_table(model, load_cases));
}

void export_model(const Options& o) {
    if (!o.path.empty())
        throw MismatchError(o.file + ": has springs; --path chooses among the load paths of a cases.h5");
    const TissueModel model = read_model(Hdf5Reader(o.file, "model"));
    if (model.energy_model) return export_energy_model(o, model);
    if (o.draws_surface()) throw MismatchError(fmt::format("{}: has spring sets, in the plane; --to {} draws the surface of a model in space", o.file, o.to));
    if (model.mesh.is_solid()) throw MismatchError(o.file + ": is in space and has no energy model; spring sets are supported in the plane only");
    if (o.to == "sofa" && o.set.empty())
        throw MismatchError(
            "a SOFA scene has one spring set: name it with --set (a load case of the model, or one_set)");
    const std::vector<NamedSet> sets = spring_sets(model, o.sets, o.set);
    if (o.to == "csv") return write_files(o.out, csv_files(model, sets));
    if (o.to == "sofa") {
        write_file(o.out, sofa_scene(model, sets.front()));
        std::cerr << "tissuectl export: spring law '" << model.law << "': " << sofa_fidelity(model.law) << '\n';
        return;
    }
    Files files;
    Progress progress("export");
    int done = 0;
    for (const NamedSet& set : sets) {
        std::string reason;
        files[set.name + ".vtu"] = set_vtu(model, set, reason);
        progress.step(++done, static_cast<int>(sets.size()),
                      set.name + (reason.empty() ? "" : ", drawn at rest: " + reason));
    }
    write_files(o.out, files);
}

void run(const Options& o) {
    const std::string kind = [&] {
        const Hdf5Reader in(o.file, "");
        if (o.to == "numpy") {
            if (!o.sets.empty() || !o.set.empty() || !o.path.empty())
                throw MismatchError("--to numpy writes every dataset; leave out --sets, --set and --path");
            Files files = npy_files(in);
            if (in.text_attribute("/", "kind") == "model" && in.has("/law")) files.merge(energy_model_arrays(read_model(in)));
            write_files(o.out, files);
        }
        return in.text_attribute("/", "kind");
    }();
    if (o.to == "numpy") return;
    if (kind == "cases") return export_cases(o);
    if (kind == "model") return export_model(o);
    throw FileError(fmt::format("{}: has kind '{}', which only --to numpy exports", o.file, kind));
}

}  // namespace

void add_export(CLI::App& app, const Invocation&) {
    auto o = std::make_shared<Options>();
    CLI::App* command =
        app.add_subcommand("export", "Export a file in the formats of other programs. All units are SI.");
    command->add_option("file", o->file, "cases.h5 or model.h5; for numpy also a recording")
        ->required()
        ->type_name("FILE");
    CLI::Validator known = CLI::IsMember({"vtu", "vtp", "glb", "sofa", "csv", "numpy"});
    known.description("");
    command->add_option("--to", o->to, "vtu (ParaView); for a model in space vtp (ParaView) and glb (glTF: Blender, Unity), the drawn surface; sofa (a scene), csv, numpy")
        ->required()
        ->type_name("NAME")
        ->check(known);
    command->add_option("--out", o->out, "folder to write; for sofa a .scn file")->required()->type_name("PATH");
    command->add_option("--sets", o->sets, "for spring sets: those of an optimiser, or optimum; default: those of the study's optimiser")
        ->type_name("NAME");
    command
        ->add_option("--set", o->set,
                     "for a model: one load case, or for spring sets one_set, heuristic_a or heuristic_b; default: all")
        ->type_name("NAME");
    command->add_option("--path", o->path, "for cases: one load path; default: all")->type_name("NAME");
    command->add_option("--surface", o->surface, "for vtp and glb: the organ's own surface, for example an .stl, which moves with the model; default: the model's coarser surface")->type_name("FILE");
    add_unit_option(*command, o->unit);
    command->get_option("--unit")->needs("--surface");
    command->callback([o] {
        if (!o->surface.empty() && !o->draws_surface()) throw CLI::ValidationError("--surface", "needs --to vtp or --to glb");
        run(*o);
    });
}

}  // namespace tissue::cli
