// Measures one study's load cases for `make gains`, on one spring mesh; scripts/gains_study.py runs it and evaluates
// the result.
//   gains_probe --study FILE --cases FILE --topology NAME --law NAME [--seed N] TASK [options]
//     iterations   iterations of `spsa` from the heuristic to gap <= --gap
//     gains        loss that `spsa-2008` leaves for every --first-step x --perturbation x --budget [E2]
//     weights      errors of the optimum for every --near x --far: Q is the study's weight_near (0.95-0.99) on the
//                  (2 near + 1)^2 nodes about the contact, and far times its weight_far (0.8-0.9) on all others
// Every optimum has a certificate, as every trained spring set has: `certificate` bounds its gap to the least loss.
// Prints a JSON list.
#include <gsl/gsl_rng.h>
#include <xxhash.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "eval/closed_loop.h"
#include "parallel.h"
#include "springs/heuristic.h"
#include "train/bounded_lsq.h"
#include "train/certificate.h"
#include "train/loss_terms.h"
#include "train/spsa.h"
#include "train/spsa_2008.h"
#include "train/train_sets.h"

namespace {

using namespace tissue;
using json = nlohmann::ordered_json;

struct Options {
    std::string study, cases, topology, law;
    unsigned long seed = 2008;
    int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    int repeats = 1;
    double gap = 0.02;
    int limit = 2000000;
    std::vector<double> magnitudes, first_steps = {0.003}, perturbations = {1}, fars = {1};
    std::vector<int> budgets = {20000}, nears = {1};
};

struct Stream {
    std::unique_ptr<gsl_rng, void (*)(gsl_rng*)> rng{gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free};
    Stream(unsigned long seed, const std::string& what) {
        const std::string key = std::to_string(seed) + "/" + what;
        gsl_rng_set(rng.get(), XXH3_64bits(key.data(), key.size()) & 0xffffffffUL);
    }
    double uniform(double low, double high) { return low + (high - low) * gsl_rng_uniform(rng.get()); }
};

/// One load case as a training problem.
struct Problem {
    const Study& study;
    const SpringMesh& mesh;
    const SpringLaw& law;
    const LoadCase& load;
    Eigen::VectorXd start;
    Box box;

    ForceLoss loss(int near_nodes, double far, unsigned long seed) const {
        Stream stream(seed, "weights/" + load.name);
        const double cell = study.geometry.width_m / study.cells[0];
        Eigen::VectorXd weight(mesh.node_count());
        for (int i = 0; i < mesh.node_count(); ++i) {
            const double away = (mesh.nodes.row(i).transpose() - load.path->contact_m).cwiseAbs().maxCoeff();
            const bool near = away <= (near_nodes + 0.01) * cell;
            const auto& range = near ? study.training.weight_near : study.training.weight_far;
            weight[i] = (near ? 1 : far) * stream.uniform(range[0], range[1]);
        }
        return loss_of(mesh, law, force_target(load, weight));
    }

    /// The optimum and a lower bound of the loss. The cost of the exact solver grows with the cube of the number of
    /// springs. Above 1000 springs, conjugate gradients as in spsa.h run with the exact gradient until the gap is below
    /// 1e-3, a twentieth of 2 %.
    Eigen::VectorXd optimum(const ForceLoss& loss, double& bound) const {
        const Eigen::VectorXd theta = mesh.spring_count() <= 1000 ? solve_bounded_lsq(loss, start, box).theta
                                                                  : conjugate_gradients(loss);
        bound = loss_lower_bound(loss, theta, box);
        return theta;
    }

    Eigen::VectorXd conjugate_gradients(const ForceLoss& loss) const {
        const Eigen::Index S = start.size();
        Eigen::VectorXd theta = start, curvature(S), g, scaled(S), last = Eigen::VectorXd::Zero(S), step = last, d, to;
        for (Eigen::Index s = 0; s < S; ++s) curvature[s] = loss.matrix().col(s).squaredNorm();
        const double silent = 1e-12 * curvature.maxCoeff();
        for (int k = 0; k < 5000; ++k) {
            const double value = loss(theta);
            if (k % 10 == 0 && loss_gap(value, loss_lower_bound(loss, theta, box), loss.scale()) < 1e-3) break;
            g = loss_gradient(loss, theta);
            for (Eigen::Index s = 0; s < S; ++s) {
                const bool held = curvature[s] <= silent || (theta[s] <= box.lo[s] && g[s] > 0) ||
                                  (theta[s] >= box.hi[s] && g[s] < 0);
                scaled[s] = held ? 0 : g[s] / curvature[s];
                if (held) step[s] = 0;
            }
            const double along = step.dot(g - last), change = scaled.dot(g - last);
            d = (along > 0 ? std::max(change / along, 0.0) : 0) * step - scaled;
            last = g;
            bool lower = false;
            for (int turn = 0; turn < 2 && !lower; ++turn, d = -scaled) {
                double alpha = -g.dot(d) / (loss.matrix() * d).squaredNorm();
                for (int tries = 0; alpha > 0 && tries < 20 && !lower; ++tries, alpha /= 3) {
                    to = box.project(theta + alpha * d);
                    lower = loss(to) < value;
                }
            }
            if (!lower) break;
            step = to - theta;
            theta = to;
        }
        return theta;
    }

    json head() const {
        return {{"set", load.name}, {"path", load.path->name}, {"magnitude_m", load.record->magnitude_m},
                {"nodes_a_side", study.cells[0] + 1}, {"springs", mesh.spring_count()}};
    }
};

void iterations(const Problem& p, const Options& o, json& out) {
    const ForceLoss loss = p.loss(1, 1, o.seed);
    double bound;
    const double best = loss(p.optimum(loss, bound));
    StopCriteria stop;
    stop.iterations = o.limit;
    stop.target_rel_loss = (bound + o.gap * std::max(bound, 0.05 * loss.scale())) / loss.scale();
    SpsaOptions options;
    options.gap_tolerance = o.gap / 20;
    Stream stream(o.seed, "spsa/" + p.load.name);
    const TrainSummary s = Spsa(options).minimise(loss, p.start, p.box, p.study.modulus_N_m(), stop, stream.rng.get());
    json j = p.head();
    j["start"] = loss(p.start) / loss.scale();
    j["optimum"] = best / loss.scale();
    j["certificate"] = loss_gap(best, bound, loss.scale());
    j["iterations"] = s.iterations;
    j["gap"] = loss_gap(s.loss, bound, loss.scale());
    j["status"] = to_string(s.status);
    j["seconds"] = s.seconds;
    out.push_back(j);
}

void gains(const Problem& p, const Options& o, json& out) {
    const ForceLoss loss = p.loss(1, 1, o.seed);
    double bound;
    p.optimum(loss, bound);
    for (int budget : o.budgets)
        for (double c : o.perturbations)
            for (double step : o.first_steps)
                for (int repeat = 0; repeat < o.repeats; ++repeat) {
                    Spsa2008Options options;
                    options.first_step = step;
                    options.first_perturbation = c;
                    options.least_perturbation = std::min(options.least_perturbation, c);
                    StopCriteria stop;
                    stop.iterations = budget;
                    Stream stream(o.seed, "spsa-2008/" + std::to_string(repeat) + "/" + p.load.name);
                    const TrainSummary s = Spsa2008(options).minimise(loss, p.start, p.box, p.study.modulus_N_m(), stop,
                                                                      stream.rng.get());
                    json j = p.head();
                    j["budget"] = budget, j["perturbation"] = c, j["first_step"] = step, j["repeat"] = repeat;
                    j["start"] = loss(p.start) / loss.scale();
                    j["bound"] = bound / loss.scale();
                    j["rel_loss"] = s.loss / loss.scale();
                    j["restarts"] = s.restarts;
                    j["status"] = to_string(s.status);
                    j["seconds"] = s.seconds;
                    out.push_back(j);
                }
}

void weights(const Problem& p, const Options& o, json& out) {
    const ForceLoss paper = p.loss(1, 1, o.seed);
    const NodeField& fe = p.load.record->force;
    const Eigen::VectorXd& push = p.load.path->direction;
    // The patch: every free node that has a part of the FE contact force.
    std::vector<int> patch;
    for (int i = 0; i < p.mesh.node_count(); ++i)
        if (!std::binary_search(p.mesh.fixed.begin(), p.mesh.fixed.end(), i) &&
            fe.row(i).norm() > 1e-6 * p.load.record->contact_force_N.norm())
            patch.push_back(i);
    const SparseMatrix A = p.law.force_matrix(p.mesh, p.load.record->displacement);
    const SurfacePoint contact = locate_on_surface(p.mesh, p.load.path->contact_m);
    for (int near : o.nears)
        for (double far : o.fars) {
            const ForceLoss loss = p.loss(near, far, o.seed);
            double bound;
            const Eigen::VectorXd theta = p.optimum(loss, bound), f = A * theta;
            double model = 0, reference = 0;
            for (int i : patch)
                for (int axis : {0, 1}) model += f[2 * i + axis] * push[axis], reference += fe(i, axis) * push[axis];
            const ContactReference held{contact, p.load.record->magnitude_m * push, p.load.record->contact_force_N};
            const std::optional<double> felt = error_of(answer_of(p.mesh, p.law, theta, held), held, p.mesh).force;
            json j = p.head();
            j["near"] = near, j["far"] = far, j["patch_nodes"] = patch.size();
            j["certificate"] = loss_gap(loss(theta), bound, loss.scale());
            j["rel_loss"] = paper(theta) / paper.scale();
            j["resolved"] = std::abs(model / reference - 1);
            j["closed_loop"] = felt ? json(*felt) : json(nullptr);
            out.push_back(j);
        }
}

}  // namespace

int main(int argc, char** argv) {
    Options o;
    CLI::App app("Measurements of make gains on one study's load cases.");
    app.add_option("--study", o.study)->required();
    app.add_option("--cases", o.cases)->required();
    app.add_option("--topology", o.topology)->required();
    app.add_option("--law", o.law)->required();
    app.add_option("--seed", o.seed);
    app.add_option("--threads", o.threads);
    app.add_option("--magnitude", o.magnitudes, "magnitudes of the study to use [m]; default: all");
    app.require_subcommand(1);
    void (*task)(const Problem&, const Options&, json&) = nullptr;
    CLI::App* sub = app.add_subcommand("iterations")->parse_complete_callback([&] { task = iterations; });
    sub->add_option("--gap", o.gap);
    sub->add_option("--limit", o.limit);
    sub = app.add_subcommand("gains")->parse_complete_callback([&] { task = gains; });
    sub->add_option("--first-step", o.first_steps);
    sub->add_option("--perturbation", o.perturbations);
    sub->add_option("--budget", o.budgets);
    sub->add_option("--repeats", o.repeats);
    sub = app.add_subcommand("weights")->parse_complete_callback([&] { task = weights; });
    sub->add_option("--near", o.nears);
    sub->add_option("--far", o.fars);
    CLI11_PARSE(app, argc, argv);

    try {
        const Study study = read_study(o.study);
        const Cases cases = read_cases(o.cases);
        const SpringMesh mesh = make_lattice(o.topology, study.cells[0], study.cells[1], study.geometry.width_m,
                                             study.geometry.height_m);
        const std::unique_ptr<SpringLaw> law = make_spring_law(o.law);
        const double unit = study.modulus_N_m();
        const Eigen::VectorXd start = heuristic_stiffness(mesh, unit);
        const Box box{Eigen::VectorXd::Constant(start.size(), study.training.k_min_E2 * unit),
                      Eigen::VectorXd::Constant(start.size(), study.training.k_max_E2 * unit)};
        std::vector<LoadCase> loads;
        for (const LoadCase& load : load_cases(cases)) {
            const auto is_it = [&](double m) { return std::abs(m - load.record->magnitude_m) < 1e-9; };
            if (o.magnitudes.empty() || std::any_of(o.magnitudes.begin(), o.magnitudes.end(), is_it)) loads.push_back(load);
        }
        std::vector<json> rows(loads.size(), json::array());
        parallel_for(static_cast<int>(loads.size()), o.threads, [&](int c) {
            const auto i = static_cast<std::size_t>(c);
            task({study, mesh, *law, loads[i], start, box}, o, rows[i]);
        });
        json all = json::array();
        for (const json& r : rows) all.insert(all.end(), r.begin(), r.end());
        std::cout << all.dump() << '\n';
    } catch (const std::exception& e) {
        std::cerr << "gains_probe: " << e.what() << '\n';
        return 1;
    }
}
