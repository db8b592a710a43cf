// Times of training, of the loss and of its construction, on the load cases of a study. Run by scripts/bench.py.
//
//   bench_train sets STUDY CASES                  all spring sets of the study: by its optimiser, and exactly
//   bench_train iterate STUDY CASES OPTIMIZER SET one set, by one optimiser, repeatedly
//   bench_train loss STUDY CASES SET              one evaluation of the loss of one set
//   bench_train lattice                           construction of lattices and their force matrices
//   bench_train scaling STUDY CASES               cost over sets, springs and cases in one set, with exponents
//   bench_train space STUDY                       cost of training an energy model in space, over nodes, springs
//                                                 and paths, with exponents
//   bench_train space STUDY X Y Z PATHS           one lattice of X x Y x Z cells alone, for its memory:
//                                                 under /usr/bin/time -v
//   bench_train export STUDY CASES                the losses themselves, for other optimisers
//
// Runs on one thread, `scaling` and `space` are measured in processor time, so that other processes do not count;
// `sets` is measured in wall time. Prints a JSON list of {"name", "unit", "samples"}, or of finished entries. `export`
// prints a list of sets: L(theta) = |target - B theta| with B as triplets (row, column, value), and start, lo, hi, unit
// [N/m]. SET counts from 0.
//
// Sample run: build/release/bench/bench_train sets fem/studies/paper.toml results/paper/cases.h5
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cases/study_energy_model.h"
#include "cases/study_mesh.h"
#include "error.h"
#include "mesh/free_surface.h"
#include "springs/equilibrium.h"
#include "springs/heuristic.h"
#include "springs/energy_model_kernel.h"
#include "study/study.h"
#include "train/bounded_lsq.h"
#include "train/loss_terms.h"
#include "train/optimizer.h"
#include "train/train_energy_model.h"
#include "train/train_sets.h"

namespace {

using namespace tissue;
using Json = nlohmann::ordered_json;

constexpr int threads = 2;  // the goals are for two cores

Json entry(const std::string& name, const std::string& unit, const std::vector<double>& samples) {
    return {{"name", name}, {"unit", unit}, {"samples", samples}};
}

/// Processor time of this thread [s].
double processor_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Processor seconds of one call, `samples` times. Each sample is the mean of enough calls for the clock's resolution.
template <class Call>
std::vector<double> time_calls(int samples, const Call& call) {
    const auto seconds = [&](int calls) {
        const double begin = processor_seconds();
        for (int i = 0; i < calls; ++i) call();
        return (processor_seconds() - begin) / calls;
    };
    seconds(1);  // warm up
    const int calls = std::max(1, static_cast<int>(5e-3 / std::max(seconds(1), 1e-9)));
    std::vector<double> times;
    for (int s = 0; s < samples; ++s) times.push_back(seconds(calls));
    return times;
}

std::vector<double> scaled(std::vector<double> values, double factor) {
    for (double& value : values) value *= factor;
    return values;
}

/// The training problem of a study: its losses as in train_sets.
struct Problem {
    Study study;
    Cases cases;
    std::vector<ForceLoss> losses;
    Eigen::VectorXd start;
    Box box;

    Problem(const std::string& study_file, const std::string& cases_file)
        : study(read_study(study_file)), cases(read_cases(cases_file)) {
        if (study.training.objective != "force" || study.training.ridge > 0)
            throw MismatchError("bench_train: study '" + study.name + "' does not train on (9) alone");
        Study quick = study;  // one iteration, for the node weights
        quick.training.optimizer = "spsa-2008";
        quick.training.also.clear();
        quick.training.iterations = 1;
        const TrainedModel model = train_sets(quick, cases, threads);
        const std::unique_ptr<SpringLaw> law = make_spring_law(study.springs.law);
        const std::vector<LoadCase> loads = load_cases(cases);
        for (std::size_t c = 0; c < loads.size(); ++c)
            losses.push_back(
                loss_of(model.mesh, *law, force_target(loads[c], model.books.node_weight.row(static_cast<Eigen::Index>(c)))));
        start = model.heuristic_a;
        box.lo = Eigen::VectorXd::Constant(start.size(), study.training.k_min_E2 * study.modulus_N_m());
        box.hi = Eigen::VectorXd::Constant(start.size(), study.training.k_max_E2 * study.modulus_N_m());
    }

    const ForceLoss& loss(const std::string& set) const {
        const std::size_t c = std::stoul(set);
        if (c >= losses.size()) throw MismatchError("bench_train: there is no set " + set);
        return losses[c];
    }
};

Json bench_sets(const std::string& study_file, const std::string& cases_file) {
    Study study = read_study(study_file);
    study.training.also.clear();
    const Cases cases = read_cases(cases_file);
    std::vector<double> trained, exact, iterations, gaps;
    for (int repeat = 0; repeat < 5; ++repeat) {
        const TrainedModel model = train_sets(study, cases, threads);
        trained.push_back(model.books.trained[0].seconds);
        exact.push_back(model.books.optimum.seconds);
        if (repeat > 0) continue;
        iterations.assign(model.books.trained[0].iterations.begin(), model.books.trained[0].iterations.end());
        gaps.assign(model.books.trained[0].gap.begin(), model.books.trained[0].gap.end());
    }
    const std::string all = "train " + study.name + ", all " + std::to_string(iterations.size()) + " sets, ";
    const std::string by = study.training.optimizer;
    return {entry(all + by + ", at most " + std::to_string(study.training.iterations) + " iterations, 2 threads", "s",
                  trained),
            entry(all + by + ", iterations until it ends itself", "1", iterations),
            entry(all + by + ", gap to the certified bound", "1", gaps),
            entry(all + "exact with certificate, 2 threads", "s", exact)};
}

/// Time per iteration and final loss, from `start` to the study's number of iterations or the optimiser's own end.
Json bench_iterations(const Problem& problem, const std::string& optimizer, const std::string& set) {
    const ForceLoss& loss = problem.loss(set);
    const Optimizer& method = *optimizers().at(optimizer);
    const std::unique_ptr<gsl_rng, void (*)(gsl_rng*)> rng(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free);
    const StopCriteria stop{problem.study.training.iterations, {}, {}};
    std::vector<double> us, rel_loss;
    for (unsigned long repeat = 0; repeat < 5; ++repeat) {
        gsl_rng_set(rng.get(), problem.study.training.seed + repeat);
        const double begin = processor_seconds();
        const TrainSummary summary =
            method.minimise(loss, problem.start, problem.box, problem.study.modulus_N_m(), stop, rng.get());
        us.push_back(1e6 * (processor_seconds() - begin) / summary.iterations);
        rel_loss.push_back(summary.loss / loss.scale());
    }
    return {entry("iteration", "us", us), entry("rel_loss", "1", rel_loss)};
}

Json bench_loss(const Problem& problem, const std::string& set) {
    const ForceLoss& loss = problem.loss(set);
    Eigen::VectorXd workspace(loss.target().size());
    double sum = 0;  // used, so that the compiler keeps the calls
    const std::vector<double> times = time_calls(20, [&] { sum += loss(problem.start, workspace); });
    if (!std::isfinite(sum)) throw MismatchError("bench_train: the loss is not finite");
    return {entry("loss", "us", scaled(times, 1e6))};
}

Json bench_lattices() {
    Json list = Json::array();
    for (const std::string topology : {"grid4", "grid8"})
        for (int nodes : {11, 21, 41}) {
            const std::string size = std::to_string(nodes) + " x " + std::to_string(nodes) + " nodes";
            const SpringMesh mesh = make_lattice(topology, nodes - 1, nodes - 1, 0.1, 0.1);
            const std::string law_name = topology == "grid4" ? "isotropic" : "geometric";
            const std::unique_ptr<SpringLaw> law = make_spring_law(law_name);
            const NodeField u = 0.01 * (30 * mesh.nodes.array()).sin().matrix();
            double sum = 0;
            const std::vector<double> lattice =
                time_calls(20, [&] { sum += make_lattice(topology, nodes - 1, nodes - 1, 0.1, 0.1).incident_measure[0]; });
            const std::vector<double> matrix = time_calls(20, [&] { sum += law->force_matrix(mesh, u).coeff(0, 0); });
            if (!std::isfinite(sum)) throw MismatchError("bench_train: a force matrix is not finite");
            list.push_back(entry("make_lattice, " + topology + ", " + size, "us", scaled(lattice, 1e6)));
            list.push_back(
                entry("force_matrix, " + topology + ", " + law_name + ", " + size, "us", scaled(matrix, 1e6)));
        }
    return list;
}

/// Processor time of all threads [s].
double all_processor_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class Call>
double processor_seconds_of(const Call& call) {
    const double begin = all_processor_seconds();
    call();
    return all_processor_seconds() - begin;
}

/// Slope of log y against log x, least squares.
double exponent(const std::vector<double>& x, const std::vector<double>& y) {
    const auto n = static_cast<double>(x.size());
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double a = std::log(x[i]), b = std::log(y[i]);
        sx += a, sy += b, sxx += a * a, sxy += a * b;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

double median(std::vector<double> samples) {
    std::sort(samples.begin(), samples.end());
    const std::size_t n = samples.size();
    return (samples[(n - 1) / 2] + samples[n / 2]) / 2;
}

/// Adds the exponent of the samples' medians over the sizes; n is the number of sizes.
void add_exponent(Json& list, const std::string& what, const std::string& of, const std::vector<double>& size,
                  const std::vector<std::vector<double>>& samples) {
    std::vector<double> medians;
    for (const auto& s : samples) medians.push_back(median(s));
    const double p = exponent(size, medians);
    list.push_back({{"name", what + ", exponent in " + of}, {"unit", "1"}, {"median", p}, {"p95", p}, {"n", size.size()}});
}

/// Adds one entry per size, and the exponent over the sizes.
void add_costs(Json& list, const std::string& what, const std::string& of, const std::vector<double>& size,
               const std::vector<double>& seconds) {
    std::vector<std::vector<double>> samples;
    for (std::size_t i = 0; i < size.size(); ++i) {
        samples.push_back({seconds[i]});
        list.push_back(entry(what + ", " + std::to_string(static_cast<int>(size[i])) + " " + of + ", processor", "s", samples[i]));
    }
    add_exponent(list, what, of, size, samples);
}

/// Every `step`-th training path.
Cases thinned(const Cases& cases, int step) {
    Cases few{cases.study, cases.nodes, cases.shape, cases.magnitudes_m, {}};
    int k = 0;
    for (const LoadPath& path : cases.paths)
        if (path.role == "train" && k++ % step == 0) few.paths.push_back(path);
    return few;
}

/// Indentations of the top of a lattice whose springs differ from the heuristic. They stand in for FE cases.
Cases made_up(const Study& study, int paths) {
    const SpringMesh mesh = make_lattice(study.springs.topology, study.cells[0], study.cells[1], study.geometry.width_m,
                                         study.geometry.height_m);
    const std::unique_ptr<SpringLaw> law = make_spring_law(study.springs.law);
    Eigen::VectorXd theta = heuristic_stiffness(mesh, study.modulus_N_m());
    for (Eigen::Index s = 0; s < theta.size(); ++s) theta[s] *= 1 + 0.5 * std::sin(1.7 * static_cast<double>(s));
    Cases cases{study.name, mesh.nodes, {}, {0.005}, {}};
    for (int k = 0; k < paths; ++k) {
        LoadPath path;
        path.name = "push-" + std::to_string(k);
        path.contact_m = Eigen::Vector2d(study.geometry.width_m * (0.2 + 0.6 * k / paths), study.geometry.height_m);
        path.direction = Eigen::Vector2d(0.3, -1).normalized();
        const auto rest = solve_equilibrium(mesh, *law, theta, locate_on_surface(mesh, path.contact_m),
                                            0.005 * path.direction);
        if (!rest) throw MismatchError("bench_train: no equilibrium: " + reason_of(rest.status));
        const Eigen::VectorXd f = law->force_matrix(mesh, rest.displacement) * theta;
        PathRecord record{};
        record.contact_force_N = record.support_force_N = Eigen::Vector2d::Zero();
        record.displacement = record.force = NodeField::Zero(mesh.node_count(), 2);
        path.records.push_back(record);
        record.magnitude_m = 0.005;
        record.displacement = rest.displacement;
        record.force = Eigen::Map<const NodeField>(f.data(), mesh.node_count(), 2);
        record.contact_force_N = rest.contact_force;
        path.records.push_back(record);
        cases.paths.push_back(path);
    }
    return cases;
}

Json bench_scaling(const std::string& study_file, const std::string& cases_file) {
    Json list = Json::array();
    Study study = read_study(study_file);
    study.training.also.clear();
    const Cases cases = read_cases(cases_file);
    const std::string name = "train " + study.name;
    train_sets(study, thinned(cases, 64), threads);  // warm up
    {
        std::vector<double> sets, seconds;
        for (int step : {32, 16, 8, 4}) {
            const Cases few = thinned(cases, step);
            sets.push_back(static_cast<double>(load_cases(few).size()));
            seconds.push_back(processor_seconds_of([&] { train_sets(study, few, threads); }));
        }
        add_costs(list, name + ", every set", "sets", sets, seconds);
    }
    {
        std::vector<double> springs, seconds;
        for (int nodes : {6, 8, 11, 16}) {
            Study other = study;
            other.cells[0] = other.cells[1] = nodes - 1;
            const Cases pushes = made_up(other, 4);
            springs.push_back(make_lattice(other.springs.topology, nodes - 1, nodes - 1, 0.1, 0.1).spring_count());
            seconds.push_back(processor_seconds_of([&] { train_sets(other, pushes, threads); }));
        }
        add_costs(list, name + ", 4 made-up sets", "springs", springs, seconds);
    }
    {
        // one set for many cases: losses are built, summed, and solved exactly
        const SpringMesh mesh = spring_mesh_of(study, cases);
        const std::unique_ptr<SpringLaw> law = make_spring_law(study.springs.law);
        const Eigen::VectorXd start = heuristic_stiffness(mesh, study.modulus_N_m());
        const Box box{Eigen::VectorXd::Constant(start.size(), study.training.k_min_E2 * study.modulus_N_m()),
                      Eigen::VectorXd::Constant(start.size(), study.training.k_max_E2 * study.modulus_N_m())};
        const Eigen::VectorXd weight = Eigen::VectorXd::Ones(mesh.node_count());
        std::vector<double> count, seconds;
        for (int step : {64, 16, 4, 1}) {
            const Cases few = thinned(cases, step);
            const std::vector<LoadCase> loads = load_cases(few);
            count.push_back(static_cast<double>(loads.size()));
            seconds.push_back(processor_seconds_of([&] {
                std::vector<ForceLoss> losses;
                for (const LoadCase& load : loads)
                    losses.push_back(loss_of(mesh, *law, contact_target(mesh, load, locate_on_surface(mesh, load.path->contact_m), weight)));
                solve_bounded_lsq(*joint_loss(losses), start, box);
            }));
        }
        add_costs(list, name + ", one set for many cases", "cases", count, seconds);
    }
    return list;
}

/// An energy model of a solid block, and indentations of its top to train on: all over the top, straight and tilted, 4
/// and 8 mm deep. Their reference is the same model with other parameters, in place of FE.
struct SolidProblem {
    SpringMesh mesh;
    EnergyModelTerms law;
    std::vector<IndentationPath> paths;
    EnergyModelTrainingOptions options;

    SolidProblem(const Study& study, int count) : mesh(study_mesh(study, {}, study.springs.topology)), law(study_energy_model(study, {}, mesh)) {
        options.force_scale = study.training.force_scale;
        options.shape_scale = study.training.shape_scale;
        options.ridge = study.training.ridge;
        options.disc_radius_m = study.indenter.radius_m;
        options.compared = compared_nodes(mesh);
        options.threads = threads;
        Eigen::VectorXd truth(law.size());
        for (Eigen::Index t = 0; t < truth.size(); ++t) truth[t] = 0.3 * std::sin(1.7 * static_cast<double>(t + 1));
        const TissueEnergy energy = law.energy(mesh);
        const std::unique_ptr<ContactKernel> kernel = make_contact_kernel(mesh, options.disc_radius_m);
        EquilibriumSolver solver(energy, *kernel, options.equilibrium);
        for (int k = 0; k < count; ++k) {
            IndentationPath& path = paths.emplace_back();
            path.name = "push-" + std::to_string(k);
            const double turn = 2.4 * k, far = 0.3 * std::sqrt((k + 0.5) / count);  // contacts on a sunflower spiral
            path.contact_m = Eigen::Vector3d(study.geometry.width_m * (0.5 + far * std::cos(turn)),
                                             study.geometry.length_m * (0.5 + far * std::sin(turn)), study.geometry.height_m);
            const Eigen::Vector3d direction = k % 2 == 0 ? Eigen::Vector3d(0, 0, -1) : Eigen::Vector3d(std::cos(turn), std::sin(turn), -1.7).normalized();
            const ContactSpring contact(kernel->rows_at(path.contact_m), law.patch(truth));
            EquilibriumState state;
            for (const double depth_m : {0.004, 0.008}) {
                const EquilibriumState before = state;
                state = solver.indent(law.constants(truth), contact, depth_m * direction, before.displacement.size() > 0 ? &before : nullptr);
                if (state.status != SolverStatus::converged)
                    throw MismatchError("bench_train: " + path.name + " is " + to_string(state.status));
                path.records.push_back({state.push_m, state.contact_force_N, state.displacement});
            }
        }
    }

    /// Processor seconds per evaluation of the loss in training, the mean over the first iterations.
    double evaluation_seconds(int iterations = 4) const {
        EnergyModelTrainingOptions few = options;
        few.fit.max_iterations = iterations;
        int evaluations = 0;
        const double seconds = processor_seconds_of([&] {
            const TrainedEnergyModel trained = train_energy_model(mesh, law, paths, few);
            evaluations = trained.starts[0].evaluations + 1;  // plus one of the trained parameters
        });
        return seconds / evaluations;
    }
};

Study with_cells(Study study, int x, int y, int z) {
    study.cells[0] = x;
    study.cells[1] = y;
    study.cells[2] = z;
    study.springs.spacing_m = study.geometry.width_m / x;
    return study;
}

Json bench_one_solid(const Study& study, int paths) {
    const SolidProblem problem(study, paths);
    return {entry("train a law in space, an evaluation, " + std::to_string(paths) + " paths, " + std::to_string(problem.mesh.node_count()) +
                      " nodes, " + std::to_string(problem.mesh.spring_count()) + " springs, processor",
                  "s", {problem.evaluation_seconds(1)})};
}

/// Measures all sizes in turn and repeats, so that other load of the machine affects all of them.
Json bench_space(const std::string& study_file) {
    constexpr int repeats = 3, few_paths = 4;
    const Study study = read_study(study_file);
    const std::string what = "train a law in space of " + std::to_string(study.springs.terms.size()) + " numbers, an evaluation";
    std::vector<SolidProblem> lattices, sets;
    std::vector<double> nodes, springs, paths;
    for (const int cells : {6, 8, 10, 12}) {
        lattices.emplace_back(with_cells(study, cells, cells, cells / 2), few_paths);
        nodes.push_back(lattices.back().mesh.node_count());
        springs.push_back(lattices.back().mesh.spring_count());
    }
    for (const int count : {4, 8, 16, 30}) {
        sets.emplace_back(with_cells(study, 6, 6, 3), count);
        paths.push_back(count);
    }
    std::vector<std::vector<double>> by_lattice(lattices.size()), by_paths(sets.size());
    for (int repeat = 0; repeat < repeats; ++repeat) {
        for (std::size_t i = 0; i < lattices.size(); ++i) by_lattice[i].push_back(lattices[i].evaluation_seconds());
        for (std::size_t i = 0; i < sets.size(); ++i) by_paths[i].push_back(sets[i].evaluation_seconds());
    }
    Json list = Json::array();
    const std::string pressed = ", " + std::to_string(few_paths) + " paths";
    for (std::size_t i = 0; i < lattices.size(); ++i)
        list.push_back(entry(what + pressed + ", " + std::to_string(static_cast<int>(nodes[i])) + " nodes, " +
                                 std::to_string(static_cast<int>(springs[i])) + " springs, processor",
                             "s", by_lattice[i]));
    add_exponent(list, what + pressed, "nodes", nodes, by_lattice);
    add_exponent(list, what + pressed, "springs", springs, by_lattice);
    const std::string small = ", " + std::to_string(static_cast<int>(nodes[0])) + " nodes";
    for (std::size_t i = 0; i < sets.size(); ++i)
        list.push_back(entry(what + small + ", " + std::to_string(static_cast<int>(paths[i])) + " paths, processor", "s", by_paths[i]));
    add_exponent(list, what + small, "paths", paths, by_paths);
    return list;
}

Json export_losses(const Problem& problem) {
    const auto list = [](const Eigen::VectorXd& v) { return std::vector<double>(v.begin(), v.end()); };
    Json sets = Json::array();
    const std::vector<LoadCase> loads = load_cases(problem.cases);
    for (std::size_t c = 0; c < loads.size(); ++c) {
        const ForceLoss& loss = problem.losses[c];
        std::vector<int> row, column;
        std::vector<double> value;
        for (int s = 0; s < loss.matrix().outerSize(); ++s)
            for (SparseMatrix::InnerIterator it(loss.matrix(), s); it; ++it) {
                row.push_back(static_cast<int>(it.row()));
                column.push_back(s);
                value.push_back(it.value());
            }
        sets.push_back({{"name", loads[c].name},
                        {"row", row},
                        {"column", column},
                        {"value", value},
                        {"target", list(loss.target())},
                        {"start", list(problem.start)},
                        {"lo", list(problem.box.lo)},
                        {"hi", list(problem.box.hi)},
                        {"unit", problem.study.modulus_N_m()},
                        {"iterations", problem.study.training.iterations},
                        {"start_loss", loss(problem.start)}});
    }
    return sets;
}

Json run(const std::vector<std::string>& words) {
    const std::string command = words.empty() ? "" : words[0];
    const std::size_t given = words.size() - (words.empty() ? 0 : 1);
    if (command == "sets" && given == 2) return bench_sets(words[1], words[2]);
    if (command == "lattice" && given == 0) return bench_lattices();
    if (command == "scaling" && given == 2) return bench_scaling(words[1], words[2]);
    if (command == "space" && given == 1) return bench_space(words[1]);
    if (command == "space" && given == 5)
        return bench_one_solid(with_cells(read_study(words[1]), std::stoi(words[2]), std::stoi(words[3]), std::stoi(words[4])), std::stoi(words[5]));
    if (command == "export" && given == 2) return export_losses({words[1], words[2]});
    if (command == "loss" && given == 3) return bench_loss({words[1], words[2]}, words[3]);
    if (command == "iterate" && given == 4) return bench_iterations({words[1], words[2]}, words[3], words[4]);
    return nullptr;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const Json out = run({argv + 1, argv + argc});
        if (out.is_null()) {
            std::fputs("usage: bench_train sets|iterate|loss|lattice|scaling|space|export ...; see the head of its source\n", stderr);
            return 2;
        }
        std::puts(out.dump().c_str());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
