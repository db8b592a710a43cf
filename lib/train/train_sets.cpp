#include "train/train_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <mutex>

#include "error.h"
#include "parallel.h"
#include "springs/spring_law.h"
#include "train/certified_sets.h"
#include "train/node_weights.h"
#include "train/objective.h"
#include "train/optimizer.h"
#include "train/stream.h"

namespace tissue {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The study's optimiser, then those in `also`, each once.
std::vector<const Optimizer*> optimizers_of(const Study::Training& training) {
    std::vector<const Optimizer*> chosen = {optimizers().at(training.optimizer).get()};
    for (const std::string& name : training.also) {
        const Optimizer* other = optimizers().at(name).get();
        if (std::find(chosen.begin(), chosen.end(), other) == chosen.end()) chosen.push_back(other);
    }
    return chosen;
}

ProblemRecord record_of(const Objective& objective, const TrainingProblems& problems) {
    ProblemRecord record{objective.name(), {}, to_string(problems.one_set_status)};
    for (ProblemStatus status : problems.status) record.status.push_back(to_string(status));
    return record;
}

}  // namespace

TrainedModel train_sets(const Study& study, const Cases& cases, int threads, const TrainProgress& progress) {
    if (study.springs.is_energy_model()) throw MismatchError("study '" + study.name + "' has no spring sets: it has an energy model");
    if (cases.measurement)
        throw MismatchError("these cases are measured: they need an energy model, and study '" + study.name + "' has spring sets");
    const Objective& objective = *objectives().at(study.training.objective);
    const std::vector<const Optimizer*> optimizers = optimizers_of(study.training);
    const double unit = study.modulus_N_m();
    const std::vector<LoadCase> loads = load_cases(cases);
    if (loads.empty()) throw MismatchError(nothing_to_train_on(cases));
    TrainedModel model = untrained_model(study, cases, loads);
    TrainingDiagnostics& books = model.books;
    const auto C = static_cast<Eigen::Index>(loads.size());
    const int S = model.mesh.spring_count();
    books.node_weight.resize(C, model.mesh.node_count());
    for (Eigen::Index c = 0; c < C; ++c)
        books.node_weight.row(c) = draw_node_weights(study, model.mesh, loads[static_cast<std::size_t>(c)]);

    const std::unique_ptr<SpringLaw> law = make_spring_law(study.springs.law);
    const Box box{Eigen::VectorXd::Constant(S, study.training.k_min_E2 * unit),
                  Eigen::VectorXd::Constant(S, study.training.k_max_E2 * unit)};
    const StopCriteria stop{study.training.iterations, study.training.max_seconds, study.training.target_rel_loss};
    const Clock::time_point beginning = Clock::now();
    const TrainingProblems problems = objective.pose({study.training, model.mesh, *law, loads, books.node_weight,
                                                      model.heuristic_a, box, threads});
    model.one_set = problems.one_set;
    books.problems = record_of(objective, problems);
    const CertifiedSets certified = certify(problems, box, threads);
    model.optimum = certified.theta;
    books.optimum = certified.proof;
    if (problems.nearly_solved) books.optimum.seconds = seconds_since(beginning);
    const int total = static_cast<int>(C) * static_cast<int>(optimizers.size());
    int done = 0;
    std::mutex guard;
    for (const Optimizer* optimizer : optimizers) {
        std::vector<TrainSummary> sets(loads.size());
        const Clock::time_point begin = Clock::now();
        parallel_for(static_cast<int>(C), threads, [&](int c) {
            const auto i = static_cast<std::size_t>(c);
            const Stream stream(study.training.seed, optimizer->name(), loads[i].name);
            sets[i] = optimizer->is_exact()
                          ? certified.sets[i]
                          : optimizer->minimise(problems.minimised[i], problems.start[i], box, unit, stop, stream);
            const std::lock_guard<std::mutex> lock(guard);
            ++done;
            if (progress) progress(done, total, optimizer->name() + " " + loads[i].name);
        });
        const double seconds = optimizer->is_exact() ? books.optimum.seconds : seconds_since(begin);
        model.trained.push_back({optimizer->name(), theta_of(sets)});
        books.trained.push_back(gather(optimizer->name(), sets, problems, books.optimum, seconds));
    }
    return model;
}

}  // namespace tissue
