#include "train/train_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <mutex>

#include "cases/study_mesh.h"
#include "error.h"
#include "parallel.h"
#include "springs/heuristic.h"
#include "springs/spring_law.h"
#include "train/certified_sets.h"
#include "train/node_weights.h"
#include "train/objective.h"
#include "train/optimizer.h"
#include "train/stream.h"

namespace tissue {

SpringMesh spring_mesh_of(const Study& study, const Cases& cases) {
    SpringMesh mesh = study_mesh(study, cases.shape, study.springs.topology);
    if (cases.nodes.rows() != mesh.nodes.rows() || !cases.nodes.isApprox(mesh.nodes, 1e-9))
        throw MismatchError(fmt::format("the cases have {} nodes that are not the {} x {} lattice of study '{}'",
                                        cases.nodes.rows(), study.cells[0] + 1, study.cells[1] + 1, study.name));
    return mesh;
}

namespace {

/// (7) with this E2 for the base material; where regions have a material of their own, in proportion to their E.
Eigen::VectorXd study_heuristic(const Study& study, const Cases& cases, const SpringMesh& mesh, double modulus_N_m) {
    if (study.material.regions.empty()) return heuristic_stiffness(mesh, modulus_N_m);
    Eigen::VectorXd modulus(mesh.triangles.rows());
    for (Eigen::Index t = 0; t < modulus.size(); ++t) {
        const int region = cases.shape->region[static_cast<std::size_t>(t)];
        const Study::LawParameters& own =
            region == 0 ? study.material
                        : static_cast<const Study::LawParameters&>(study.material.regions.at(static_cast<std::size_t>(region - 1)));
        modulus[t] = modulus_N_m * own.youngs_modulus_Pa() / study.material.youngs_modulus_Pa();
    }
    return heuristic_stiffness(mesh, modulus);
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The study's optimisers, its own first, each once.
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
    const Objective& objective = *objectives().at(study.training.objective);
    const std::vector<const Optimizer*> optimizers = optimizers_of(study.training);
    const double unit = study.modulus_N_m();
    TrainedModel model;
    TrainingBooks& books = model.books;
    books.seed = study.training.seed;
    model.study = study.name;
    model.law = study.springs.law;
    model.mesh = spring_mesh_of(study, cases);
    model.modulus_N_m = unit;
    model.node_mass_kg = node_masses(model.mesh, study.material.density_kg_m3, study.geometry.thickness_m);
    model.heuristic_a = study_heuristic(study, cases, model.mesh, unit);
    model.heuristic_b = study_heuristic(study, cases, model.mesh, study.second_modulus_N_m());

    const std::vector<LoadCase> loads = load_cases(cases);
    const auto C = static_cast<Eigen::Index>(loads.size());
    const int D = model.mesh.dimension(), S = model.mesh.spring_count();
    model.contact_m.resize(C, D);
    model.direction.resize(C, D);
    model.magnitude_m.resize(C);
    model.contact_force_N.resize(C, D);
    books.node_weight.resize(C, model.mesh.node_count());

    const std::unique_ptr<SpringLaw> law = make_spring_law(study.springs.law);
    for (Eigen::Index c = 0; c < C; ++c) {
        const LoadCase& load = loads[static_cast<std::size_t>(c)];
        model.case_names.push_back(load.name);
        model.contact_m.row(c) = load.path->contact_m;
        model.direction.row(c) = load.path->direction;
        model.magnitude_m[c] = load.record->magnitude_m;
        model.contact_force_N.row(c) = load.record->contact_force_N;
        books.node_weight.row(c) = draw_node_weights(study, model.mesh, load);
    }

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
