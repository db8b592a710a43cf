#include "train/training_diagnostics.h"

#include <fmt/format.h>

#include <cmath>

#include "train/diagnostics_table.h"

namespace tissue {
namespace {

void write_book(TableWriter& out, const SetDiagnostics& book) {
    const std::string group = "/trained/" + book.optimizer + "/";
    const std::size_t C = book.status.size();
    out.write(group + "loss", book.loss_N);
    out.write(group + "rel_loss", book.rel_loss);
    out.write(group + "gap", book.gap);
    out.write_integers(group + "iterations", {C}, book.iterations);
    out.write_integers(group + "evaluations", {C}, book.evaluations);
    out.write_integers(group + "restarts", {C}, book.restarts);
    out.write_texts(group + "status", book.status);
    out.write_integers(group + "curve_iteration", {book.curve_iteration.size()}, book.curve_iteration);
    out.write(group + "curve_loss", book.curve_loss_N);
}

/// in: passed by value, because the length P differs between optimisers.
SetDiagnostics read_book(const Hdf5Reader& file, TableReader in, const std::string& optimizer) {
    const std::string group = "/trained/" + optimizer + "/";
    SetDiagnostics book;
    book.optimizer = optimizer;
    book.loss_N = in.vector(group + "loss");
    book.rel_loss = in.vector(group + "rel_loss");
    book.gap = in.vector(group + "gap");
    book.iterations = in.integers(group + "iterations");
    book.evaluations = in.integers(group + "evaluations");
    book.restarts = in.integers(group + "restarts");
    book.status = in.texts(group + "status");
    book.curve_iteration = in.integers(group + "curve_iteration");
    book.curve_loss_N = in.field(group + "curve_loss");
    book.seconds = file.number_attribute("/trained/" + optimizer, "seconds");
    return book;
}

void write_energy_model_diagnostics(Hdf5Writer& file, const EnergyModelDiagnostics& diagnostics) {
    TableWriter out(file, energy_model_diagnostics_table());
    const std::size_t R = diagnostics.status.size();
    out.write("/law/untrained_constants", diagnostics.untrained_constants);
    out.write("/law/untrained_patch_log", NodeField(diagnostics.untrained_patch.log_N_m));
    out.write_texts("/law/start_status", diagnostics.status);
    out.write("/law/start_objective", diagnostics.start_objective);
    out.write("/law/start_gradient", diagnostics.gradient);
    out.write_integers("/law/start_iterations", {R}, diagnostics.iterations);
    out.write_integers("/law/start_evaluations", {R}, diagnostics.evaluations);
    out.write_texts("/law/lost", diagnostics.lost);
    file.attribute("/law", "objective", diagnostics.objective);
    file.attribute("/law", "kept", diagnostics.kept);
    file.attribute("/law", "paths", diagnostics.paths);
    file.attribute("/law", "records", diagnostics.records);
    file.attribute("/law", "factor", diagnostics.factor);
    file.attribute("/law", "seconds", diagnostics.seconds);
    if (diagnostics.at_rest) file.attribute("/law", "at_rest", 1);
    if (!diagnostics.shares) return;
    file.attribute("/law", "shares_histories", diagnostics.shares->histories);
    file.attribute("/law", "shares_kkt_residual", diagnostics.shares->kkt_residual);
    file.attribute("/law", "shares_misfit", diagnostics.shares->misfit);
    file.attribute("/law", "shares_grown", diagnostics.shares->grown);
    file.attribute("/law", "shares_status", diagnostics.shares->status);
}

/// energy_model: energy model of the same file; gives the lengths of the datasets.
EnergyModelDiagnostics read_energy_model_diagnostics(const Hdf5Reader& file, const EnergyModel& energy_model) {
    TableReader in(file, energy_model_diagnostics_table(), {{"E", static_cast<std::size_t>(energy_model.constants.size())},
                                             {"K", static_cast<std::size_t>(energy_model.patch.log_N_m.rows())},
                                             {"F", static_cast<std::size_t>(energy_model.patch.log_N_m.cols())}});
    EnergyModelDiagnostics diagnostics;
    diagnostics.untrained_constants = in.vector("/law/untrained_constants");
    diagnostics.untrained_patch.log_N_m = in.field("/law/untrained_patch_log");
    diagnostics.untrained_patch.curve = energy_model.patch.curve;
    diagnostics.status = in.texts("/law/start_status");
    diagnostics.start_objective = in.vector("/law/start_objective");
    diagnostics.gradient = in.vector("/law/start_gradient");
    diagnostics.iterations = in.integers("/law/start_iterations");
    diagnostics.evaluations = in.integers("/law/start_evaluations");
    diagnostics.lost = in.texts("/law/lost");
    const auto count = [&file](const char* key, double low, double high) {
        const double value = file.number_attribute("/law", key);
        if (!(value >= low && value <= high && value == std::floor(value)))
            file.refuse("/law", fmt::format("attribute '{}' is {}, must be a whole number from {} to {}", key, value, low, high));
        return static_cast<int>(value);
    };
    diagnostics.kept = count("kept", 0, static_cast<double>(diagnostics.status.size()) - 1);
    diagnostics.paths = count("paths", 1, 1e9);
    diagnostics.records = count("records", 1, 1e9);
    diagnostics.factor = file.number_attribute("/law", "factor");
    if (!(diagnostics.factor > 0) || !std::isfinite(diagnostics.factor))
        file.refuse("/law", fmt::format("attribute 'factor' is {}, must be a finite number > 0", diagnostics.factor));
    diagnostics.objective = file.number_attribute("/law", "objective");
    diagnostics.seconds = file.number_attribute("/law", "seconds");
    if (file.has_attribute("/law", "at_rest")) diagnostics.at_rest = count("at_rest", 0, 1) == 1;
    if (file.has_attribute("/law", "shares_status"))
        diagnostics.shares = {count("shares_histories", 1, 1e9), file.number_attribute("/law", "shares_kkt_residual"), file.number_attribute("/law", "shares_misfit"),
                       file.number_attribute("/law", "shares_grown"), file.text_attribute("/law", "shares_status")};
    return diagnostics;
}

}  // namespace

const DatasetTable& energy_model_diagnostics_table() {
    static const DatasetTable table = {
        {"/law/untrained_constants", "E", Values::positive(), "N/m", "constants of the heuristic, before training"},
        {"/law/untrained_patch_log", "K x F", Values::logarithm(), "log(N/m)", "contact of the heuristic, as /law/patch_log"},
        {"/law/start_status", "R", Values::text(), "text", "why the fit of each start stopped"},
        {"/law/start_objective", "R", Values::not_negative(), "1", "objective at the end of each fit"},
        {"/law/start_gradient", "R", Values::not_negative(), "1", "largest derivative of half the objective by a coefficient"},
        {"/law/start_iterations", "R", Values::count(), "1", "iterations"},
        {"/law/start_evaluations", "R", Values::count(), "1", "evaluations of all load cases"},
        {"/law/lost", "L*", Values::text(), "text", "training load cases without an equilibrium: place, tool displacement, cause"},
    };
    return table;
}

const DatasetTable& books_table() {
    static const DatasetTable table = {
        {"/cases/node_weight", "C x N", Values::not_negative(), "1", "diagonal of Q, one entry a node"},
        {"/optimum/loss", "C", Values::not_negative(), "N", "L of the optimum, (9)"},
        {"/optimum/rel_loss", "C", Values::not_negative().or_nan(), "1", "L / sqrt(f_fe' Q f_fe)"},
        {"/optimum/lower_bound", "C", Values::not_negative(), "N", "no set in the box has a smaller L"},
        {"/optimum/kkt_residual", "C", Values::not_negative().or_nan(), "1", "residual of the optimality conditions"},
        {"/optimum/status", "C", Values::text(), "text", "why the exact solver stopped", Rows::any, true},
        {"/problems/status", "C", Values::text(), "text", "state of each case's training problem", Rows::any, true},
        {"/trained/NAME/loss", "C", Values::not_negative(), "N", "L(theta), (9)"},
        {"/trained/NAME/rel_loss", "C", Values::not_negative().or_nan(), "1", "L / sqrt(f_fe' Q f_fe)"},
        {"/trained/NAME/gap", "C", Values::finite().or_nan(), "1", "distance from the certified optimum"},
        {"/trained/NAME/iterations", "C", Values::count(), "1", "iterations, all restarts together"},
        {"/trained/NAME/evaluations", "C", Values::count(), "1", "evaluations of the loss"},
        {"/trained/NAME/restarts", "C", Values::count(), "1", "restarts after a negative spring"},
        {"/trained/NAME/status", "C", Values::text(), "text", "why the optimiser stopped"},
        {"/trained/NAME/curve_iteration", "P*", Values::count(), "1", "iterations of the learning curves", Rows::ascending},
        {"/trained/NAME/curve_loss", "C x P*", Values::not_negative().or_nan(), "N",
         "learning curves, NaN once a set has stopped"},
    };
    return table;
}

EnergyModel energy_model_of_cases(const TrainedModel& model) {
    const EnergyModel& energy_model = *model.energy_model;
    return model.books.energy_model->at_rest && !energy_model.relaxation.empty() ? long_term(energy_model) : energy_model;
}

void write_trained_model(const std::string& file, const TrainedModel& model, const Provenance& provenance) {
    const TrainingDiagnostics& books = model.books;
    Hdf5Writer hdf5(file, "model", provenance, format_of(model));
    write_tissue(hdf5, model);
    if (books.energy_model) {
        write_energy_model_diagnostics(hdf5, *books.energy_model);
        return hdf5.commit();
    }
    TableWriter out(hdf5, books_table());
    out.write("/cases/node_weight", books.node_weight);
    out.write("/optimum/loss", books.optimum.loss_N);
    out.write("/optimum/rel_loss", books.optimum.rel_loss);
    out.write("/optimum/lower_bound", books.optimum.lower_bound_N);
    out.write("/optimum/kkt_residual", books.optimum.kkt_residual);
    if (!books.optimum.status.empty()) out.write_texts("/optimum/status", books.optimum.status);
    hdf5.attribute("/optimum", "seconds", books.optimum.seconds);
    if (!books.problems.status.empty()) {
        out.write_texts("/problems/status", books.problems.status);
        hdf5.attribute("/problems", "objective", books.problems.objective);
        hdf5.attribute("/problems", "one_set_status", books.problems.one_set_status);
    }
    for (const SetDiagnostics& book : books.trained) {
        write_book(out, book);
        hdf5.attribute("/trained/" + book.optimizer, "seconds", book.seconds);
    }
    hdf5.commit();
}

TrainedModel read_trained_model(const std::string& name) {
    const Hdf5Reader file(name, "model");
    TrainedModel model{read_model(file), {}};
    TrainingDiagnostics& books = model.books;
    const double seed = file.number_attribute("/", "seed");
    if (!(seed >= 0 && seed <= 9007199254740992.0))
        file.refuse("/", fmt::format("attribute 'seed' is {}, must be a whole number >= 0", seed));
    books.seed = static_cast<unsigned long>(seed);
    if (model.energy_model) {
        books.energy_model = read_energy_model_diagnostics(file, *model.energy_model);
        return model;
    }
    TableReader in(file, books_table(), {{"C", model.case_names.size()}, {"N", static_cast<std::size_t>(model.mesh.node_count())}});
    books.node_weight = in.field("/cases/node_weight");
    books.optimum = {in.vector("/optimum/loss"), in.vector("/optimum/rel_loss"), in.vector("/optimum/lower_bound"),
                     in.vector("/optimum/kkt_residual"), {}, file.number_attribute("/optimum", "seconds")};
    if (file.has("/optimum/status")) books.optimum.status = in.texts("/optimum/status");
    if (file.has("/problems/status"))
        books.problems = {file.text_attribute("/problems", "objective"), in.texts("/problems/status"),
                          file.text_attribute("/problems", "one_set_status")};
    for (const SpringSets& sets : model.trained) books.trained.push_back(read_book(file, in, sets.optimizer));
    return model;
}

}  // namespace tissue
