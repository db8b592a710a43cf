#include "eval/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "error.h"
#include "mesh/free_surface.h"
#include "parallel.h"
#include "springs/heuristic.h"
#include "springs/indentation_solver.h"

namespace tissue {
namespace {

/// Stiffness of one model: one theta for all cases (baselines), one for each case (trained sets), none (energy model).
struct Candidate {
    std::string name;
    std::vector<Eigen::VectorXd> theta;  ///< [N/m]; size 1, C or 0

    const Eigen::VectorXd& at(std::size_t c) const { return theta.size() == 1 ? theta[0] : theta[c]; }
};

std::vector<double> collect(const std::vector<CaseError>& cases, double (*value)(const CaseError&)) {
    std::vector<double> values;
    for (const CaseError& c : cases) values.push_back(value(c));
    return values;
}

/// Evaluation::lower_bound_rel of case c.
double relative_bound(const TrainingDiagnostics& books, const LoadCase& load, Eigen::Index c) {
    constexpr double rounding = 1e-9;
    const double scale = std::sqrt(books.node_weight.row(c).dot(load.record->force.rowwise().squaredNorm()));
    const bool of_nodes = books.problems.objective.empty() || books.problems.objective == "force";
    const bool alone = of_nodes && std::abs(books.optimum.loss_N[c] - books.optimum.rel_loss[c] * scale) <= rounding * scale;
    return alone ? books.optimum.lower_bound_N[c] / scale : std::nan("");
}

/// Uniform stiffness [N/m] with the smallest median rel_loss. Used where half of the contacts have no equilibrium.
double uniform_by_rel_loss(const TrainedModel& model, const SpringLaw& law, const std::vector<LoadCase>& loads,
                           const std::vector<SurfacePoint>& contacts, double low, double high) {
    double best = low, best_median = std::numeric_limits<double>::infinity();
    for (double k = low; k <= high; k *= 1.01) {
        const Eigen::VectorXd theta = uniform_stiffness(model.mesh, k);
        std::vector<double> losses;
        for (std::size_t c = 0; c < loads.size(); ++c)
            losses.push_back(force_error(model.mesh, law, theta, contacts[c],
                                         model.books.node_weight.row(static_cast<Eigen::Index>(c)), *loads[c].path,
                                         *loads[c].record)
                                 .rel_loss);
        const double median = statistics_of(losses).median;
        if (median < best_median) {
            best_median = median;
            best = k;
        }
    }
    return best;
}

/// Index of the load case of this path with the nearest magnitude [m]; of two equally near ones the smaller. Absent
/// where FE ended before the first load case.
std::optional<std::size_t> nearest_case(const std::vector<LoadCase>& loads, const LoadPath& path, double magnitude_m) {
    std::optional<std::size_t> best;
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < loads.size(); ++c) {
        if (loads[c].path != &path) continue;
        const double d = std::abs(loads[c].record->magnitude_m - magnitude_m);
        if (d < distance - 1e-12) {
            distance = d;
            best = c;
        }
    }
    return best;
}

}  // namespace

Statistics ModelErrors::rel_loss() const {
    return statistics_of(collect(cases, [](const CaseError& c) { return c.open_loop.rel_loss; }), lost);
}

Statistics ModelErrors::resolved_error() const {
    return statistics_of(collect(cases, [](const CaseError& c) { return c.open_loop.resolved_error; }), lost);
}

ContactStatistics ModelErrors::closed_loop() const {
    std::vector<ContactError> errors;
    for (const CaseError& c : cases) errors.push_back(c.closed_loop);
    return contact_statistics(errors, lost);
}

const ModelErrors& Evaluation::model(const std::string& name) const {
    const auto it = std::find_if(models.begin(), models.end(), [&](const ModelErrors& m) { return m.name == name; });
    if (it == models.end()) throw MismatchError("the evaluation has no model '" + name + "'");
    return *it;
}

Evaluation evaluate(const TrainedModel& model, const Cases& cases, double k_min_N_m, double k_max_N_m, int threads) {
    const std::vector<LoadCase> loads = load_cases(cases);
    bool same = loads.size() == model.case_names.size() && has_nodes(model.mesh, cases.nodes);
    for (std::size_t c = 0; same && c < loads.size(); ++c) same = loads[c].name == model.case_names[c];
    if (cases.disc_radius_m > 0) same = same && model.energy_model && model.energy_model->disc_radius_m == cases.disc_radius_m;
    if (!same) throw MismatchError("the model was trained on other cases than these");
    if (cases.measurement && !model.energy_model)  // a file of an earlier version
        throw MismatchError("these cases are measured: they need an energy model, and this model has spring sets");

    const std::unique_ptr<SpringLaw> law = make_spring_law(model.law);
    std::vector<SurfacePoint> contacts;
    std::vector<ContactReference> references;
    for (const LoadCase& load : loads) {
        contacts.push_back(model.mesh.is_solid() ? SurfacePoint{} : locate_on_surface(model.mesh, load.path->contact_m));
        references.push_back({contacts.back(), load.path->push_m(*load.record), load.record->contact_force_N,
                          load.record->displacement});
    }

    Evaluation result;
    result.measurement = cases.measurement;
    result.listed = model.case_count() <= listed_cases && !model.energy_model;
    const bool listed = result.listed;
    result.study = model.study;
    result.trained = model.books.trained;
    result.optimum = model.books.optimum;
    result.problems = model.books.problems;
    result.energy_model = model.energy_model;
    result.energy_model_diagnostics = model.books.energy_model;
    std::optional<IndentationSolver> energy;
    if (model.energy_model) energy.emplace(model.mesh, energy_model_of_cases(model));
    const std::vector<int> compared = compared_nodes(model.mesh);
    std::vector<Candidate> candidates;
    const auto add_sets = [&](const std::string& name, const NodeField& theta) {
        candidates.push_back({name, {}});
        for (Eigen::Index c = 0; c < theta.rows(); ++c) candidates.back().theta.emplace_back(theta.row(c));
    };
    for (const SpringSets& trained : model.trained) {
        std::string name = "learned";
        if (!candidates.empty()) name += "_" + trained.optimizer;
        std::replace_if(name.begin(), name.end(), [](char ch) { return ch == '-' || ch == ':'; }, '_');
        add_sets(name, trained.theta);
    }
    if (energy)
        candidates.push_back({"learned", {}});
    else
        add_sets("optimum", model.optimum);
    // No uniform baseline in space: the force under a contact of a few nodes depends on the mesh
    result.uniform_N_m = 0;
    const double low = 0.05 * model.modulus_N_m, high = 40 * model.modulus_N_m;
    const std::optional<double> uniform = model.mesh.is_solid() ? std::optional<double>() : best_uniform_stiffness(model.mesh, *law, references, low, high);
    if (!model.mesh.is_solid()) {
        result.uniform_N_m = uniform ? *uniform : energy ? model.modulus_N_m : uniform_by_rel_loss(model, *law, loads, contacts, low, high);
        result.uniform_chosen_on = uniform ? "closed_loop" : energy ? "modulus" : "rel_loss";
        if (!energy) candidates.push_back({"one_set", {model.one_set}});
        candidates.push_back({"heuristic_a", {model.heuristic_a}});
        candidates.push_back({"heuristic_b", {model.heuristic_b}});
        candidates.push_back({"uniform", {uniform_stiffness(model.mesh, result.uniform_N_m)}});
    }

    for (const LoadCase& load : loads) {
        result.case_names.push_back(load.name);
        result.magnitude_m.push_back(load.record->magnitude_m);
        result.fe_resolved_N.push_back(load.record->contact_force_N.dot(load.path->direction));
        result.smallest_J.push_back(load.record->smallest_J);
        if (result.open_loop()) result.lower_bound_rel.push_back(relative_bound(model.books, load, static_cast<Eigen::Index>(result.lower_bound_rel.size())));
    }
    int lost_cases = -static_cast<int>(loads.size());
    for (const LoadPath& path : cases.paths)
        if (path.role == "train") lost_cases += static_cast<int>(load_magnitudes(cases, path).size());
    for (const Candidate& candidate : candidates) {
        ModelErrors errors{candidate.name, {}, {}, lost_cases};
        errors.cases.resize(loads.size());
        parallel_for(static_cast<int>(loads.size()), threads, [&](int i) {
            const auto c = static_cast<std::size_t>(i);
            CaseError& e = errors.cases[c];
            if (candidate.theta.empty()) {  // the energy model
                e.closed_loop = error_of(answer_of(*energy, loads[c].path->contact_m, references[c].push_m, loads[c].path->radius_m), references[c], model.mesh, compared);
                return;
            }
            if (result.open_loop())
                e.open_loop = force_error(model.mesh, *law, candidate.at(c), contacts[c],
                            model.books.node_weight.row(static_cast<Eigen::Index>(c)), *loads[c].path, *loads[c].record);
            e.closed_loop = error_of(answer_of(model.mesh, *law, candidate.at(c), references[c]), references[c], model.mesh, compared);
        });
        NodeField theta(static_cast<Eigen::Index>(candidate.theta.size()), model.mesh.spring_count());
        for (std::size_t c = 0; c < candidate.theta.size(); ++c) theta.row(static_cast<Eigen::Index>(c)) = candidate.theta[c];
        if (listed) errors.springs = spring_character(model, cases, theta);
        result.models.push_back(std::move(errors));
    }
    for (const LoadPath& path : cases.paths)
        if (path.role == "train" && !path.lost.empty()) result.lost.push_back(path.name + ": " + path.lost);
    result.discretisation = check_discretisation(cases);
    result.held_out = evaluate_held_out(model, cases, threads);
    result.two_tools = evaluate_two_tools(model, cases, threads);
    result.map = force_map(model, cases, threads);
    if (model.energy_model) result.histories = evaluate_histories(model, cases.histories, "held_out", threads);
    if (cases.measurement) result.histories.near_training = near_training(cases, "held_out");
    if (!listed) return result;
    result.front = ridge_front(model, cases, k_min_N_m, k_max_N_m);
    for (const LoadPath& path : cases.paths) {
        if (path.role != "train" || !nearest_case(loads, path, 0)) continue;
        ForceCurve curve;
        curve.path = path.name;
        curve.model_force_N.resize(candidates.size());
        const std::vector<int> loaded = loaded_nodes(model.mesh, path.records.back());
        for (const PathRecord& record : path.records) {
            const std::size_t serving = *nearest_case(loads, path, record.magnitude_m);
            curve.magnitude_m.push_back(record.magnitude_m);
            curve.fe_N.push_back(record.contact_force_N.dot(path.direction));
            curve.serving_set.push_back(loads[serving].name);
            for (std::size_t m = 0; m < candidates.size(); ++m)
                curve.model_force_N[m].push_back(resolved_force(model.mesh, *law, candidates[m].at(serving), loaded,
                                                                path.direction, record.displacement));
        }
        result.curves.push_back(std::move(curve));
    }
    return result;
}

}  // namespace tissue
