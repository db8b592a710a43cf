#include "train/train_sets.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <tuple>

#include "cases/study_mesh.h"
#include "error.h"
#include "mesh/outline.h"
#include "parallel.h"
#include "springs/equilibrium.h"
#include "springs/heuristic.h"
#include "springs/spring_law.h"
#include "train/bounded_lsq.h"
#include "train/certificate.h"
#include "train/objective.h"
#include "train/optimizer.h"
#include "train/reaction.h"

namespace tissue {
namespace {

/// A GSL generator that no other set or purpose shares.
class Stream {
   public:
    Stream(unsigned long seed, const std::string& purpose, const std::string& set)
        : rng_(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free) {
        const std::string key = fmt::format("{}/{}/{}", seed, purpose, set);
        gsl_rng_set(rng_.get(), XXH3_64bits(key.data(), key.size()) & 0xffffffffUL);  // mt19937 takes 32 bits
    }
    operator gsl_rng*() const { return rng_.get(); }
    double uniform(const double (&range)[2]) const { return range[0] + (range[1] - range[0]) * gsl_rng_uniform(*this); }

   private:
    std::unique_ptr<gsl_rng, void (*)(gsl_rng*)> rng_;
};

/// Q of (9): high for the 3 x 3 nodes about the contact, lower elsewhere, both drawn at random (N).
Eigen::VectorXd draw_node_weights(const Study& study, const SpringMesh& mesh, const LoadCase& load) {
    const Stream stream(study.training.seed, "weights", load.name);
    // on a shape: as far as the next nodes are, on average and round its corners
    double spring_m = 0;
    for (int s = 0; s < mesh.spring_count(); ++s) spring_m += mesh.rest_length(s) / mesh.spring_count();
    const Eigen::Vector2d reach = study.geometry.is_block()
                                      ? Eigen::Vector2d(1.01 * study.geometry.width_m / study.cells[0],
                                                        1.01 * study.geometry.height_m / study.cells[1])
                                      : Eigen::Vector2d::Constant(1.2 * spring_m);
    Eigen::VectorXd weight(mesh.node_count());
    for (int i = 0; i < mesh.node_count(); ++i) {
        const Eigen::Vector2d away = (mesh.nodes.row(i).transpose() - load.path->contact_m).cwiseAbs();
        const bool near = away.x() <= reach.x() && away.y() <= reach.y();
        weight[i] = stream.uniform(near ? study.training.weight_near : study.training.weight_far);
    }
    return weight;
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What the sets of a study are trained on. `base` is (9) or its like, one a case, in which reports speak; `minimised`
/// may have more rows: a ridge, the reaction.
struct Objectives {
    std::vector<ForceLoss> base, minimised;
    Eigen::VectorXd one_set;       ///< the single set that serves all cases best (S)
    BoundedLsqOptions exact;       ///< how the exact solver should go about them
    std::vector<Eigen::VectorXd> start;  ///< where each set's training begins: inside the box, near the answer if known
};

/// How much the contact's reaction counts beside the nodes: enough that its error all but vanishes.
constexpr double reaction_factor = 30;

Objectives make_objectives(const Study& study, const TrainedModel& model, const SpringLaw& law,
                           const std::vector<LoadCase>& loads, const Box& box, int threads) {
    const bool contact = study.training.objective == "contact";
    std::vector<Target> targets;
    std::vector<SurfacePoint> contacts;
    Objectives o;
    for (std::size_t c = 0; c < loads.size(); ++c) {
        const Eigen::VectorXd weight = model.books.node_weight.row(static_cast<Eigen::Index>(c));
        contacts.push_back(locate_on_surface(model.mesh, loads[c].path->contact_m));
        targets.push_back(contact ? contact_target(model.mesh, loads[c], contacts.back(), weight)
                                  : force_target(loads[c], weight));
        o.base.push_back(loss_of(model.mesh, law, targets.back()));
    }
    std::vector<ForceLoss> joint = o.base;
    if (contact)  // the reactions of all contacts, through the heuristic's compliance
        parallel_for(static_cast<int>(loads.size()), threads, [&](int c) {
            const auto i = static_cast<std::size_t>(c);
            const std::optional<Eigen::MatrixXd> G =
                contact_sensitivity(model.mesh, law, model.heuristic_a, contacts[i], targets[i].displacement);
            if (G) joint[i] = with_reaction(o.base[i], model.mesh, law, targets[i], *G, reaction_factor);
        });
    o.one_set = solve_bounded_lsq(joint_loss(joint), model.heuristic_a, box).theta;
    // a ridge leaves nothing badly conditioned: Newton's own step at once
    if (study.training.ridge > 0) o.exact.first_shift = o.exact.shift;
    o.minimised = o.base;
    o.start.assign(loads.size(), model.heuristic_a);
    parallel_for(static_cast<int>(loads.size()), threads, [&](int c) {
        const auto i = static_cast<std::size_t>(c);
        const auto ridged = [&](const ForceLoss& loss) {
            return study.training.ridge > 0 ? with_ridge(loss, study.training.ridge, model.heuristic_a) : loss;
        };
        o.minimised[i] = ridged(o.base[i]);
        if (!contact) return;
        // the compliance that turns force residuals into the reaction's error is the set's own: one step towards it
        BoundedLsqOptions rough = o.exact;
        rough.kkt_tolerance = 1e-6;
        for (int pass = 0; pass < 2; ++pass) {
            const std::optional<Eigen::MatrixXd> G =
                contact_sensitivity(model.mesh, law, o.start[i], contacts[i], targets[i].displacement);
            if (!G) return;
            const ForceLoss seen = with_reaction(o.base[i], model.mesh, law, targets[i], *G, reaction_factor);
            o.minimised[i] = ridged(seen);
            if (pass == 0) o.start[i] = solve_bounded_lsq(o.minimised[i], o.start[i], box, rough).theta;
        }
    });
    return o;
}

/// A reading and those near it, itself first: a Gaussian of how far apart contacts and pushes are, cut where it is small.
std::vector<Reading> neighbours(const std::vector<Reading>& readings, const std::vector<double>& arcs, std::size_t of,
                                double reach_m) {
    std::vector<Reading> near = {readings[of]};
    for (std::size_t i = 0; i < readings.size() && reach_m > 0; ++i) {
        const double squared = (arcs[i] - arcs[of]) * (arcs[i] - arcs[of]) +
                               (readings[i].push_m - readings[of].push_m).squaredNorm();
        Reading other = readings[i];
        other.weight = std::exp(-squared / (2 * reach_m * reach_m));
        if (i != of && other.weight > 0.05) near.push_back(other);
    }
    return near;
}

/// Contact forces alone: the closed loop's own answer (reaction.h). The heuristic, scaled to the readings, is the prior of
/// the single set that serves all, and that one the prior of every other.
Objectives reaction_objectives(const Study& study, const TissueModel& model, const SpringLaw& law,
                               const std::vector<LoadCase>& loads, const Box& box, int threads) {
    std::vector<Reading> readings;
    std::vector<double> places;
    const Outline outline(model.mesh);
    for (const LoadCase& load : loads) places.push_back(outline.arc_of(load.path->contact_m));
    for (const LoadCase& load : loads)
        readings.push_back({locate_on_surface(model.mesh, load.path->contact_m), load.path->push_m(*load.record),
                            load.record->contact_force_N});
    const double ridge = study.training.ridge;
    const Eigen::VectorXd prior =
        box.project(best_factor(model.mesh, law, readings, model.heuristic_a) * model.heuristic_a);
    Objectives o;
    o.one_set = fit_reactions(model.mesh, law, readings, prior, prior, study.training.one_set_ridge, box).theta;
    if (ridge > 0) o.exact.first_shift = o.exact.shift;
    o.start.resize(loads.size());
    std::vector<std::optional<ReactionFit>> fits(loads.size());
    parallel_for(static_cast<int>(loads.size()), threads, [&](int c) {
        const auto i = static_cast<std::size_t>(c);
        fits[i] = fit_reactions(model.mesh, law, neighbours(readings, places, i, study.training.reach_m), o.one_set,
                                o.one_set, ridge, box);
    });
    for (std::size_t i = 0; i < loads.size(); ++i) {
        o.start[i] = fits[i]->theta;
        o.base.push_back(fits[i]->losses.front());
        o.minimised.push_back(fits[i]->inner);
    }
    return o;
}

/// The exact solution of every set (C x S) and its certificate.
std::pair<NodeField, OptimumProof> certify(const Objectives& objectives, const Box& box, int threads) {
    const std::vector<ForceLoss>& losses = objectives.minimised;
    const auto C = static_cast<Eigen::Index>(losses.size());
    NodeField theta(C, box.lo.size());
    OptimumProof optimum{Eigen::VectorXd(C), Eigen::VectorXd(C), Eigen::VectorXd(C), Eigen::VectorXd(C)};
    const Clock::time_point begin = Clock::now();
    parallel_for(static_cast<int>(C), threads, [&](int c) {
        const ForceLoss& loss = losses[static_cast<std::size_t>(c)];
        const BoundedLsqSummary exact = solve_bounded_lsq(loss, objectives.start[static_cast<std::size_t>(c)], box, objectives.exact);
        theta.row(c) = exact.theta;
        optimum.loss_N[c] = exact.residual_norm;
        const ForceLoss& base = objectives.base[static_cast<std::size_t>(c)];
        optimum.rel_loss[c] = base(exact.theta) / base.scale();
        optimum.lower_bound_N[c] = loss_lower_bound(loss, exact.theta, box);
        optimum.kkt_residual[c] = exact.kkt_residual;
    });
    optimum.seconds = seconds_since(begin);
    return {std::move(theta), std::move(optimum)};
}

NodeField theta_of(const std::vector<TrainSummary>& sets) {
    NodeField theta(static_cast<Eigen::Index>(sets.size()), sets[0].theta.size());
    for (std::size_t c = 0; c < sets.size(); ++c) theta.row(static_cast<Eigen::Index>(c)) = sets[c].theta;
    return theta;
}

TrainingBook gather(const std::string& optimizer, const std::vector<TrainSummary>& sets,
                    const Objectives& objectives, const OptimumProof& optimum, double seconds) {
    const auto C = static_cast<Eigen::Index>(sets.size());
    TrainingBook t;
    t.optimizer = optimizer;
    t.seconds = seconds;
    t.loss_N.resize(C);
    t.rel_loss.resize(C);
    t.gap.resize(C);
    std::map<int, Eigen::Index> column;  // sorted union of the sets' iterations
    for (const TrainSummary& s : sets)
        for (const LearningPoint& p : s.curve) column[p.iteration] = 0;
    for (auto& [iteration, index] : column) {
        index = static_cast<Eigen::Index>(t.curve_iteration.size());
        t.curve_iteration.push_back(iteration);
    }
    t.curve_loss_N = NodeField::Constant(C, static_cast<Eigen::Index>(column.size()), std::nan(""));
    for (Eigen::Index c = 0; c < C; ++c) {
        const TrainSummary& s = sets[static_cast<std::size_t>(c)];
        t.loss_N[c] = s.loss;
        const ForceLoss& base = objectives.base[static_cast<std::size_t>(c)];
        t.rel_loss[c] = base(s.theta) / base.scale();
        t.gap[c] = loss_gap(s.loss, optimum.lower_bound_N[c], base.scale());
        t.iterations.push_back(s.iterations);
        t.evaluations.push_back(s.evaluations);
        t.restarts.push_back(s.restarts);
        t.status.push_back(to_string(s.status));
        for (const LearningPoint& p : s.curve) t.curve_loss_N(c, column[p.iteration]) = p.loss;
    }
    return t;
}

}  // namespace

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

}  // namespace

TrainedModel train_sets(const Study& study, const Cases& cases, int threads, const TrainProgress& progress) {
    const double unit = study.modulus_N_m();
    TrainedModel model;
    model.books.seed = study.training.seed;
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
    model.books.node_weight.resize(C, model.mesh.node_count());

    const std::unique_ptr<SpringLaw> law = make_spring_law(study.springs.law);
    for (Eigen::Index c = 0; c < C; ++c) {
        const LoadCase& load = loads[static_cast<std::size_t>(c)];
        model.case_names.push_back(load.name);
        model.contact_m.row(c) = load.path->contact_m;
        model.direction.row(c) = load.path->direction;
        model.magnitude_m[c] = load.record->magnitude_m;
        model.contact_force_N.row(c) = load.record->contact_force_N;
        model.books.node_weight.row(c) = draw_node_weights(study, model.mesh, load);
    }

    const Box box{Eigen::VectorXd::Constant(S, study.training.k_min_E2 * unit),
                  Eigen::VectorXd::Constant(S, study.training.k_max_E2 * unit)};
    const StopCriteria stop{study.training.iterations, study.training.max_seconds, study.training.target_rel_loss};
    const Clock::time_point beginning = Clock::now();
    const Objectives objectives = study.training.objective == "reaction"
                                      ? reaction_objectives(study, model, *law, loads, box, threads)
                                      : make_objectives(study, model, *law, loads, box, threads);
    model.one_set = objectives.one_set;
    OptimumProof& proof = model.books.optimum;
    std::tie(model.optimum, proof) = certify(objectives, box, threads);
    if (study.training.objective != "force") proof.seconds = seconds_since(beginning);  // solves most of it
    std::vector<std::string> names = {study.training.optimizer};
    for (const std::string& other : study.training.also)
        if (std::find(names.begin(), names.end(), other) == names.end()) names.push_back(other);
    const int total = static_cast<int>(C) * static_cast<int>(names.size());
    int done = 0;
    std::mutex guard;
    for (const std::string& name : names) {
        const std::unique_ptr<Optimizer> optimizer = make_optimizer(name);
        std::vector<TrainSummary> sets(loads.size());
        const Clock::time_point begin = Clock::now();
        parallel_for(static_cast<int>(C), threads, [&](int c) {
            const auto i = static_cast<std::size_t>(c);
            const Stream stream(study.training.seed, name, loads[i].name);
            if (name == "exact") {  // the certificate has solved it already
                sets[i].theta = model.optimum.row(c);
                sets[i].loss = proof.loss_N[c];
                sets[i].status = TrainStatus::converged;
            } else
                sets[i] = optimizer->minimise(objectives.minimised[i], objectives.start[i], box, unit, stop, stream);
            const std::lock_guard<std::mutex> lock(guard);
            ++done;
            if (progress) progress(done, total, name + " " + loads[i].name);
        });
        const double seconds = name == "exact" ? proof.seconds : seconds_since(begin);
        model.trained.push_back({name, theta_of(sets)});
        model.books.trained.push_back(gather(name, sets, objectives, proof, seconds));
    }
    return model;
}

}  // namespace tissue
