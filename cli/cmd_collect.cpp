#include "cases/load_path.h"
#include "command.h"
#include "io/atomic_file.h"
#include "study/study.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string study, paths, out;
};

void run(const Options& o, Provenance provenance) {
    const Study study = read_study(o.study);
    Cases cases;
    cases.study = study.name;
    cases.magnitudes_m = study.loads.magnitudes_m;
    cases.nodes = make_lattice("grid4", study.cells[0], study.cells[1], study.geometry.width_m,
                               study.geometry.height_m)
                      .nodes;
    for (const StudyPath& p : study.loads.paths) {
        const std::string file = o.paths + "/" + p.name + ".csv";
        LoadPath path = read_path_csv(file, cases.nodes);
        path.name = p.name;
        path.contact_m = p.contact_m;
        path.direction = p.direction;
        cases.paths.push_back(std::move(path));
        provenance.inputs[p.name + ".csv"] = file_hash(file);
    }
    load_cases(cases);  // refuses a path without a record at a magnitude
    write_cases(o.out, cases, provenance);
}

}  // namespace

void add_collect(CLI::App& app, const Invocation& invocation) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("collect", "Gather FreeFEM's load paths into one file of cases.");
    command->add_option("--study", o->study, "study file")->required()->type_name("FILE");
    command->add_option("--paths", o->paths, "folder of NAME.csv, one a load path")->required()->type_name("FOLDER");
    command->add_option("--out", o->out, "cases.h5 to write")->required()->type_name("FILE");
    command->callback([o, &invocation] { run(*o, {invocation.command, 0, {}}); });
}

}  // namespace tissue::cli
