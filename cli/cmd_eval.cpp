#include <iostream>
#include <thread>

#include "command.h"
#include "error.h"
#include "eval/evaluation.h"
#include "io/atomic_file.h"
#include "study/study.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string study, model, cases, out, report;
    int threads = 0;
    bool json = false;
};

void run(const Options& o) {
    const Study study = read_study(o.study);
    const std::string model_hash = file_hash(o.model), cases_hash = file_hash(o.cases);
    const TrainedModel model = read_trained_model(o.model);
    if (model.study != study.name)
        throw MismatchError(o.model + ": was trained for study '" + model.study + "', not '" + study.name + "'");
    const Evaluation evaluation = evaluate(model, read_cases(o.cases), study.training.k_min_E2 * study.modulus_N_m(),
                                           study.training.k_max_E2 * study.modulus_N_m(), o.threads);
    const std::string json = to_json(evaluation, model.books.seed, {model_hash, cases_hash});
    if (!o.report.empty()) write_file(o.report, to_markdown(evaluation));
    write_file(o.out, json);
    if (o.json) std::cout << json;
}

}  // namespace

void add_eval(CLI::App& app, const Invocation&) {
    auto o = std::make_shared<Options>();
    o->threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    CLI::App* command = app.add_subcommand("eval", "Evaluate a model and its baselines on the FE cases.");
    command->add_option("--study", o->study, "study file")->required()->type_name("FILE");
    command->add_option("--model", o->model, "model.h5 of tissuectl train")->required()->type_name("FILE");
    command->add_option("--cases", o->cases, "cases.h5 of tissuectl collect")->required()->type_name("FILE");
    command->add_option("--out", o->out, "eval.json to write")->required()->type_name("FILE");
    command->add_option("--report", o->report, "report.md to write as well")->type_name("FILE");
    command->add_option("--threads", o->threads, "contacts evaluated at a time; changes no result")
        ->type_name("threads")
        ->capture_default_str()
        ->check(CLI::Range(1, 4096));
    command->add_flag("--json", o->json, "print eval.json too");
    command->callback([o, command] {
        echo_options(*command);
        run(*o);
    });
}

}  // namespace tissue::cli
