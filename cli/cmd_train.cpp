#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <iostream>
#include <optional>
#include <thread>

#include "command.h"
#include "error.h"
#include "io/atomic_file.h"
#include "progress.h"
#include "train/endings.h"
#include "train/train_study_model.h"
#include "train/train_sets.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string study, cases, out;
    int threads = 0;
    std::optional<unsigned long> seed;
    std::optional<std::string> optimizer;
    std::optional<int> iterations;
    bool json = false;
};

/// Prints a JSON array with an object per spring set, or per term of an energy model.
void print(const TrainedModel& model) {
    nlohmann::ordered_json j;
    if (const auto& energy_model = model.energy_model)
        for (std::size_t t = 0; t < energy_model->terms.size(); ++t)
            j.push_back({{"term", energy_model->terms[t]}, {"coefficient", energy_model->coefficients[static_cast<Eigen::Index>(t)]}});
    for (const SetDiagnostics& t : model.books.trained)
        for (Eigen::Index c = 0; c < t.loss_N.size(); ++c) {
            const auto i = static_cast<std::size_t>(c);
            j.push_back({{"optimizer", t.optimizer},
                         {"set", model.case_names[i]},
                         {"loss_N", t.loss_N[c]},
                         {"rel_loss", t.rel_loss[c]},
                         {"iterations", t.iterations[i]},
                         {"restarts", t.restarts[i]},
                         {"status", t.status[i]}});
        }
    std::cout << j.dump(1) << '\n';
}

void run(const Options& o, Provenance provenance) {
    Study study = read_study(o.study);
    if (o.seed) study.training.seed = *o.seed;
    if (study.springs.is_energy_model() && (o.optimizer || o.iterations))
        throw MismatchError("--optimizer and --iterations are for spring sets; study '" + study.name + "' has an energy model");
    if (o.optimizer) study.training.optimizer = *o.optimizer;
    if (o.iterations) study.training.iterations = *o.iterations;
    provenance.seed = study.training.seed;
    provenance.inputs[std::filesystem::path(o.cases).filename().string()] = file_hash(o.cases);

    TrainedModel model;
    {
        Progress progress("train");
        const Cases cases = read_cases(o.cases);
        model = study.springs.is_energy_model()
                    ? train_study_model(study, cases, o.threads)
                    : train_sets(study, cases, o.threads,
                                 [&](int done, int total, const std::string& set) { progress.step(done, total, set); });
    }
    write_trained_model(o.out, model, provenance);
    if (o.json) print(model);

    const Endings endings = endings_of(model.books);
    for (const std::string& line : endings.other) std::cerr << "tissuectl train: " << line << '\n';
    if (!endings.broken.empty())
        throw IncompleteResult(fmt::format("{} is written, but part of the training did not converge: {}", o.out,
                                        fmt::join(endings.broken, "; ")));
}

}  // namespace

void add_train(CLI::App& app, const Invocation& invocation) {
    auto o = std::make_shared<Options>();
    o->threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    CLI::App* command = app.add_subcommand(
        "train", "Train a spring set for every load case, or an energy model for all. Exit 3: written, but a training did not converge.");
    command->add_option("--study", o->study, "study file")->required()->type_name("FILE");
    command->add_option("--cases", o->cases, "cases.h5 of tissuectl collect")->required()->type_name("FILE");
    command->add_option("--out", o->out, "model.h5 to write")->required()->type_name("FILE");
    command->add_option("--threads", o->threads, "spring sets trained at a time; changes no result")
        ->type_name("threads")
        ->capture_default_str()
        ->check(CLI::Range(1, 4096));
    command->add_option("--seed", o->seed, "in place of the study's training.seed")->type_name("integer");
    command->add_option("--optimizer", o->optimizer, "in place of the study's training.optimizer")->type_name("NAME");
    command->add_option("--iterations", o->iterations, "in place of the study's training.iterations")
        ->type_name("count")
        ->check(CLI::Range(1, 100000000));
    command->add_flag("--json", o->json, "print one line of JSON per spring set, or per term");
    command->callback([o, command, &invocation] {
        echo_options(*command);
        run(*o, {invocation.command, 0, {}});
    });
}

}  // namespace tissue::cli
