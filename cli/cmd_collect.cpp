#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "cases/history_plan.h"
#include "cases/load_path.h"
#include "cases/study_mesh.h"
#include "cases/sweep.h"
#include "command.h"
#include "error.h"
#include "io/atomic_file.h"
#include "study/study.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string study, paths, mesh, out;
    std::vector<std::string> only;  ///< names; empty: all of the plan
};

/// Removes the paths that are not in `only`. Throws MismatchError for a name that is not planned, and where none of the
/// paths left is for training.
void keep_only(std::vector<PlannedPath>& planned, const std::vector<std::string>& only) {
    const auto asked = [&](const std::string& name) { return std::find(only.begin(), only.end(), name) != only.end(); };
    for (const std::string& name : only)
        if (std::none_of(planned.begin(), planned.end(), [&](const PlannedPath& p) { return p.push.name == name; }))
            throw MismatchError(fmt::format("--only: the study has no load path '{}'", name));
    planned.erase(std::remove_if(planned.begin(), planned.end(), [&](const PlannedPath& p) { return !asked(p.push.name); }), planned.end());
    if (std::none_of(planned.begin(), planned.end(), [](const PlannedPath& p) { return p.role == "train"; }))
        throw MismatchError("--only: none of these load paths is a training path; name at least one");
}

/// Prints one line where FE solutions ended before the end of their histories.
void say_lost(const std::vector<History>& histories) {
    std::size_t lost = 0;
    const History* first = nullptr;
    for (const History& h : histories) {
        if (h.lost.empty()) continue;
        if (++lost == 1) first = &h;
    }
    if (first)
        std::cout << fmt::format("histories: {} of {} have no FE reference up to their end; the first, {}, stops after {} steps: {}\n", lost, histories.size(), first->name,
                                 first->time_s.size(), first->lost);
}

void run(const Options& o, Provenance provenance) {
    const Study study = read_study(o.study);
    if (study.data) throw StudyError(o.study + ": has [data] and no load paths; use tissuectl import");
    Cases cases;
    cases.study = study.name;
    cases.magnitudes_m = study.loads.magnitudes_m;
    cases.shape = study_shape(study, o.mesh);
    cases.nodes = study_nodes(study, cases.shape);
    std::string hashes;
    std::vector<PlannedPath> plan = planned_paths(study, cases.shape);
    if (!o.only.empty()) keep_only(plan, o.only);
    for (const PlannedPath& planned : plan) {
        const std::string file = o.paths + "/" + planned.push.name + ".csv";
        LoadPath path = read_path_csv(file, cases.nodes, planned.push.second.has_value());
        path.name = planned.push.name;
        path.contact_m = planned.push.contact_m;
        path.direction = planned.push.direction;
        path.second = planned.push.second;
        path.role = planned.role;
        path.depth_m = planned.depth_m;
        if (planned.push.radius_m != study.indenter.radius_m) {
            path.radius_m = planned.push.radius_m;
            cases.disc_radius_m = study.indenter.radius_m;
        }
        hashes += file_hash(file);
        cases.paths.push_back(std::move(path));
        if (study.geometry.is_block() && study.loads.sweep && planned.role == "train") {
            LoadPath image = mirrored(cases.paths.back(), cases.nodes, study.geometry.width_m);
            const bool itself = (image.contact_m - planned.push.contact_m).norm() < 1e-9 &&
                                (image.direction - planned.push.direction).norm() < 1e-9;
            if (!itself) cases.paths.push_back(std::move(image));
        }
    }
    for (const PlannedHistory& planned : o.only.empty() ? planned_histories(study, cases.shape) : std::vector<PlannedHistory>()) {
        cases.histories.push_back(read_planned_history(planned, o.paths, planned.has_elastic(study)));
        hashes += file_hash(o.paths + "/" + planned.push.name + ".csv");
        if (planned.has_elastic(study)) hashes += file_hash(o.paths + "/" + planned.elastic_name() + ".csv");
    }
    say_lost(cases.histories);
    provenance.inputs["cases/*.csv"] = text_hash(hashes);
    load_cases(cases);  // refuses a path without a record at a magnitude
    write_cases(o.out, cases, provenance);
}

}  // namespace

void add_collect(CLI::App& app, const Invocation& invocation) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("collect", "Collect FreeFEM's load paths in one file of cases.");
    command->add_option("--study", o->study, "study file")->required()->type_name("FILE");
    command->add_option("--paths", o->paths, "folder of NAME.csv, one file per load path")->required()->type_name("FOLDER");
    command->add_option("--mesh", o->mesh, "mesh.msh of tissuectl shape, for a study that has a shape")->type_name("FILE");
    command->add_option("--only", o->only, "load paths to collect while some of the study's are not solved yet; histories are then left out")
        ->delimiter(',')->type_name("NAME,...");
    command->add_option("--out", o->out, "cases.h5 to write")->required()->type_name("FILE");
    command->callback([o, &invocation] { run(*o, {invocation.command, 0, {}}); });
}

}  // namespace tissue::cli
