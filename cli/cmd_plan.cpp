#include <filesystem>

#include "command.h"
#include "io/atomic_file.h"
#include "cases/plan.h"
#include "cases/study_mesh.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string study, mesh, out;
};

void run(const Options& o) {
    const Study study = read_study(o.study);
    const std::filesystem::path folder = std::filesystem::path(o.out).parent_path() / "plan";
    const OpenFolder made(folder.string(), folder.string(), OpenFolder::Missing::make);
    std::error_code error;
    // a mesh that was made from an older shape of the study is not used
    Plan plan = make_plan(study);
    bool stale = o.mesh.empty() || !std::filesystem::exists(o.mesh, error);
    const auto shape = plan.parts.find("shape");
    if (shape != plan.parts.end() && write_file_if_changed((folder / "shape").string(), shape->second)) stale = true;
    if (shape != plan.parts.end() && !stale) plan = make_plan(study, study_shape(study, o.mesh));
    for (const auto& [name, text] : plan.parts) write_file_if_changed((folder / name).string(), text);
    write_file(o.out, plan.fragment);  // last, because make takes a new fragment as the sign that all parts exist
}

}  // namespace

void add_plan(CLI::App& app, const Invocation&) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("plan", "Write make's targets and arguments for a study.");
    command->add_option("--study", o->study, "study file")->required()->type_name("FILE");
    command->add_option("--out", o->out, "make fragment to write; its parts are written to plan/ in the same folder")
        ->required()
        ->type_name("FILE");
    command->add_option("--mesh", o->mesh, "mesh.msh of tissuectl shape, for a study that has a shape; without it only this mesh is planned")
        ->type_name("FILE");
    command->callback([o] { run(*o); });
}

}  // namespace tissue::cli
