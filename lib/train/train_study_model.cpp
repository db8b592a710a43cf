#include "train/train_study_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>

#include "cases/study_energy_model.h"
#include "cases/study_mesh.h"
#include "error.h"
#include "mesh/free_surface.h"
#include "springs/lattice_correction.h"
#include "springs/energy_model_kernel.h"
#include "train/relative_moduli.h"
#include "train/train_energy_model.h"

namespace tissue {
namespace {

/// Multiplies all stiffnesses of an energy model by a factor. Two dimensions only: it scales every row of the contact.
void grow(EnergyModel& energy_model, double factor) {
    energy_model.constants *= factor;
    energy_model.patch.log_N_m.col(0).array() += std::log(factor);
}

/// Smallest and largest factor `curved` of the paths' contacts, for DiscTables::curved_range.
Eigen::Vector2d curved_range(const SpringMesh& mesh, double disc_radius_m, const std::vector<IndentationPath>& paths) {
    std::map<double, std::unique_ptr<ContactKernel>> kernels;
    Eigen::VectorXd curved(static_cast<Eigen::Index>(paths.size()));
    for (Eigen::Index i = 0; i < curved.size(); ++i) {
        const IndentationPath& path = paths[static_cast<std::size_t>(i)];
        std::unique_ptr<ContactKernel>& kernel = kernels[path.radius_m];
        if (!kernel) kernel = make_contact_kernel(mesh, path.radius_m > 0 ? path.radius_m : disc_radius_m);
        curved[i] = kernel->rows_at(path.contact_m).factors[ContactParameters::curved_factor];
    }
    return {curved.minCoeff(), curved.maxCoeff()};
}

/// DiscSizes::radii_m of these paths, with the model's own radius; empty where no path has another one.
Eigen::VectorXd radii_of(double own_m, const std::vector<IndentationPath>& paths) {
    std::set<double> radii_m{own_m};
    for (const IndentationPath& path : paths)
        if (path.radius_m > 0) radii_m.insert(path.radius_m);
    if (radii_m.size() == 1) return {};
    return with_means({radii_m.begin(), radii_m.end()});
}

/// Fits the Maxwell branches of the energy model to the measured histories and stores them. Branches with a relative
/// modulus of 0 (below 1e-6) are left out. Result: diagnostics of the fit.
EnergyModelDiagnostics::Shares fit_branches(const Study& study, const Cases& cases, TissueModel& model, int threads) {
    EnergyModel& energy_model = *model.energy_model;
    Eigen::VectorXd tau_s(static_cast<Eigen::Index>(study.material.viscosity.size()));
    for (Eigen::Index k = 0; k < tau_s.size(); ++k) tau_s[k] = study.material.viscosity[static_cast<std::size_t>(k)].tau_s;
    if (tau_s.size() == 0) tau_s = time_ladder(cases.histories, "train");
    const FittedModuli fitted = fit_relative_moduli(model, cases.histories, "train", tau_s, threads, study.material.long_term);
    grow(energy_model, fitted.grown);
    constexpr double none = 1e-6;
    std::vector<int> used;
    for (Eigen::Index k = 0; k < tau_s.size(); ++k)
        if (fitted.share[k] > none) used.push_back(static_cast<int>(k));
    if (!used.empty()) {
        energy_model.relaxation.tau_s = tau_s(used);
        energy_model.relaxation.contact_share = fitted.share(used);
        energy_model.relaxation.share = Eigen::VectorXd::Ones(energy_model.constants.size()) * energy_model.relaxation.contact_share.transpose();
    }
    const auto count = std::count_if(cases.histories.begin(), cases.histories.end(), [](const History& h) { return h.role == "train"; });
    return {static_cast<int>(count), fitted.kkt_residual, fitted.misfit, fitted.grown, fitted.status};
}

}  // namespace

TrainedModel train_study_model(const Study& study, const Cases& cases, int threads) {
    if (!study.springs.is_energy_model()) throw MismatchError("study '" + study.name + "' has spring sets and no energy model");
    TrainedModel model = untrained_model(study, cases, load_cases(cases));
    const Cases kept = without_mirrors(cases);
    const std::vector<IndentationPath> paths = indentation_paths(kept);
    if (paths.empty()) throw MismatchError(nothing_to_train_on(kept));

    EnergyModelTrainingOptions options;
    options.force_scale = study.training.force_scale;
    options.shape_scale = study.training.shape_scale;
    options.ridge = study.training.ridge;
    options.starts = study.training.starts;
    options.seed = study.training.seed;
    options.threads = threads;
    options.disc_radius_m = study.indenter.radius_m;
    if (cases.disc_radius_m > 0 && cases.disc_radius_m != study.indenter.radius_m)
        throw MismatchError(fmt::format("the cases are of a study with a disc of {:g} mm, and this study has a disc of {:g} mm", 1e3 * cases.disc_radius_m, 1e3 * study.indenter.radius_m));
    if (model.mesh.is_solid()) options.compared = compared_nodes(model.mesh);
    if (model.mesh.is_solid()) options.sizes = {radii_of(options.disc_radius_m, paths), model.mesh.embedding.spacing_m};
    // Longer steps from the heuristic lose records, which takes long to compute
    if (model.mesh.is_solid()) options.fit.most_step = 2;
    // the material of measured tissue is not known: scale the heuristic to the measured forces
    double factor = 1;
    if (cases.measurement)
        factor = heuristic_factor(model.mesh, study_energy_model(study, kept.shape, model.mesh), paths, options);
    const EnergyModelTerms model_terms = study_energy_model(study, kept.shape, model.mesh, factor);
    const auto energy_model_at = [&](const EnergyModelTerms& of, const Eigen::VectorXd& p) {
        EnergyModel made{of.terms(), p, of.constants(p), of.patch(p), of.incompressible(), options.disc_radius_m};
        made.curve = of.curve();
        made.disc = {of.ground(), options.curved_range, options.correction};
        made.sizes = options.sizes;
        return made;
    };
    const auto correct = [&](const Eigen::VectorXd& p) {
        const auto energy_model_on = [&](const SpringMesh& mesh) { return energy_model_at(study_energy_model(study, kept.shape, mesh, factor), p); };
        const bool several = !options.sizes.empty();
        const Eigen::VectorXd radii_m = several ? options.sizes.radii_m : Eigen::VectorXd::Constant(1, options.disc_radius_m);
        const std::vector<FacetTable> tables = lattice_corrections(study_solid(study, kept.shape), model.mesh, energy_model_on, radii_m, threads);
        for (std::size_t k = 0; k < tables.size(); ++k)
            if (radii_m[static_cast<Eigen::Index>(k)] == options.disc_radius_m) options.correction = tables[k];
        if (several) options.sizes.correction = tables;
    };
    const auto begin = std::chrono::steady_clock::now();
    if (model.mesh.is_solid()) {
        options.curved_range = curved_range(model.mesh, options.disc_radius_m, paths);
        // The lattice correction depends slightly on the energy model: compute it for the untrained model, train
        // roughly with it, and compute it again for the result.
        correct(Eigen::VectorXd::Zero(model_terms.size()));
        EnergyModelTrainingOptions rough = options;
        rough.starts = 1;
        rough.fit.gain_tolerance = 1e-2;
        options.first = train_energy_model(model.mesh, model_terms, paths, rough).coefficients;
        correct(options.first);
    }
    const TrainedEnergyModel trained = train_energy_model(model.mesh, model_terms, paths, options);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    model.energy_model = energy_model_at(model_terms, trained.coefficients);
    model.energy_model->relaxation = study_relaxation(study, kept.shape, model.mesh, model_terms);

    EnergyModelDiagnostics& diagnostics = model.books.energy_model.emplace();
    const auto R = static_cast<Eigen::Index>(trained.starts.size());
    const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(model_terms.size());
    diagnostics.untrained_constants = model_terms.constants(nothing);
    diagnostics.untrained_patch = model_terms.patch(nothing);
    diagnostics.objective = trained.objective;
    diagnostics.factor = factor;
    diagnostics.kept = static_cast<int>(trained.kept);
    diagnostics.paths = static_cast<int>(paths.size());
    for (const IndentationPath& path : paths) diagnostics.records += static_cast<int>(path.records.size());
    diagnostics.start_objective.resize(R);
    diagnostics.gradient.resize(R);
    for (Eigen::Index s = 0; s < R; ++s) {
        const FitResult& start = trained.starts[static_cast<std::size_t>(s)];
        diagnostics.status.push_back(to_string(start.status));
        diagnostics.start_objective[s] = 2 * start.half_square;
        diagnostics.gradient[s] = start.gradient;
        diagnostics.iterations.push_back(start.iterations);
        diagnostics.evaluations.push_back(start.evaluations);
    }
    // measurements of tissue at rest give the long-term moduli; the model's constants are the instantaneous ones
    diagnostics.at_rest = cases.measurement && study.material.long_term;
    if (diagnostics.at_rest && !study.material.fits_shares) grow(*model.energy_model, 1 / (1 - model.energy_model->relaxation.contact_share.sum()));
    if (study.material.fits_shares) diagnostics.shares = fit_branches(study, cases, model, threads);
    diagnostics.lost = trained.lost;
    diagnostics.seconds = seconds;
    return model;
}

}  // namespace tissue
