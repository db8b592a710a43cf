#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "cases/measured_cases.h"
#include "cases/measurement_warnings.h"
#include "cases/measured_histories.h"
#include "command.h"
#include "error.h"
#include "io/atomic_file.h"
#include "study/study.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string data, study, out, histories;
};

void run(const Options& o, Provenance provenance) {
    const Study study = read_study(o.study);
    if (!study.data) throw StudyError(o.study + ": has no [data], which a study of measured contacts needs");
    // first: a pipe would wait for a second writer
    provenance.inputs[std::filesystem::path(o.data).filename().string()] = file_hash(o.data);
    if (!o.histories.empty()) provenance.inputs[std::filesystem::path(o.histories).filename().string()] = file_hash(o.histories);
    const MeasuredTable table = read_measured_csv(o.data);
    Cases cases = measured_cases(study, table);
    if (!o.histories.empty()) cases.histories = read_measured_histories(study, o.histories);
    provenance.seed = study.data->seed;
    write_cases(o.out, cases, provenance);

    const Measurement& m = *cases.measurement;
    int sets = 0, validation = 0, held_out = 0;
    for (const LoadPath& path : cases.paths) {
        sets += path.role == "train" ? static_cast<int>(path.records.size()) : 0;
        validation += path.role == "validation" ? 1 : 0;
        held_out += path.role == "held_out" ? 1 : 0;
    }
    std::cerr << fmt::format("import {}: {} rows at {} contacts: {} training indentations, {} validation rows, {} test "
                             "rows\nimport {}: noise ({}): {:.2g} % of the force, {:.2g} mm, of one component\n",
                             o.data, m.rows, m.contacts, sets, validation, held_out, o.data, m.noise_source,
                             100 * m.force_noise, 1e3 * m.displacement_noise_m);
    if (!cases.histories.empty()) {
        const auto count = [&](const char* role) { return std::count_if(cases.histories.begin(), cases.histories.end(), [&](const History& h) { return h.role == role; }); };
        std::cerr << fmt::format("import {}: {} histories: {} for training, {} for validation, {} for the test set\n", o.histories, cases.histories.size(), count("train"),
                                 count("validation"), count("held_out"));
    }
    for (const std::string& doubt : measurement_warnings(study, table)) std::cerr << fmt::format("import {}: warning: {}\n", o.data, doubt);
    for (const std::string& doubt : measurement_warnings(study, cases.histories)) std::cerr << fmt::format("import {}: warning: {}\n", o.histories, doubt);
    for (const std::string& line : m.outliers) std::cerr << fmt::format("import {}: outlier, kept: {}\n", o.data, line);
}

}  // namespace

void add_import(CLI::App& app, const Invocation& invocation) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("import", "Import measured contact forces in place of FE references.");
    command->add_option("data", o->data, "CSV: contact, displacement and force, units in its header")
        ->required()->type_name("FILE");
    command->add_option("--histories", o->histories, "CSV of displacement histories: history, time, contact, displacement and force")->type_name("FILE");
    command->add_option("--study", o->study, "study file, with [data]")->required()->type_name("FILE");
    command->add_option("--out", o->out, "cases.h5 to write")->required()->type_name("FILE");
    command->callback([o, &invocation] { run(*o, {invocation.command, 0, {}}); });
}

}  // namespace tissue::cli
