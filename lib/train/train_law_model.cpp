#include "train/train_law_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>

#include "cases/study_law.h"
#include "cases/study_mesh.h"
#include "error.h"
#include "mesh/free_surface.h"
#include "springs/lattice_correction.h"
#include "springs/law_kernel.h"
#include "train/fit_shares.h"
#include "train/train_law.h"

namespace tissue {
namespace {

/// All of a law in the plane so many times as stiff.
void grow(LawModel& law, double factor) {
    law.constants *= factor;
    law.patch.log_N_m.col(0).array() += std::log(factor);
}

/// DiscTables::curved_range.
Eigen::Vector2d curved_range(const SpringMesh& mesh, double disc_radius_m, const std::vector<PressPath>& paths) {
    std::map<double, std::unique_ptr<ContactKernel>> kernels;
    Eigen::VectorXd seen(static_cast<Eigen::Index>(paths.size()));
    for (Eigen::Index i = 0; i < seen.size(); ++i) {
        const PressPath& path = paths[static_cast<std::size_t>(i)];
        std::unique_ptr<ContactKernel>& kernel = kernels[path.radius_m];
        if (!kernel) kernel = make_contact_kernel(mesh, path.radius_m > 0 ? path.radius_m : disc_radius_m);
        seen[i] = kernel->rows_at(path.contact_m).factors[PatchLaw::curved_factor];
    }
    return {seen.minCoeff(), seen.maxCoeff()};
}

/// DiscSizes::radii_m of these paths, the law's own among them: none where all have that.
Eigen::VectorXd radii_of(double own_m, const std::vector<PressPath>& paths) {
    std::set<double> radii_m{own_m};
    for (const PressPath& path : paths)
        if (path.radius_m > 0) radii_m.insert(path.radius_m);
    if (radii_m.size() == 1) return {};
    return with_means({radii_m.begin(), radii_m.end()});
}

/// The law's branches, as measured histories say; those that they have no use for are left out.
LawBook::Shares fit_branches(const Study& study, const Cases& cases, TissueModel& model, int threads) {
    LawModel& law = *model.energy_law;
    Eigen::VectorXd tau_s(static_cast<Eigen::Index>(study.material.viscosity.size()));
    for (Eigen::Index k = 0; k < tau_s.size(); ++k) tau_s[k] = study.material.viscosity[static_cast<std::size_t>(k)].tau_s;
    if (tau_s.size() == 0) tau_s = time_ladder(cases.histories, "train");
    const FittedShares fitted = fit_shares(model, cases.histories, "train", tau_s, threads, study.material.long_term);
    grow(law, fitted.grown);
    constexpr double none = 1e-6;
    std::vector<int> used;
    for (Eigen::Index k = 0; k < tau_s.size(); ++k)
        if (fitted.share[k] > none) used.push_back(static_cast<int>(k));
    if (!used.empty()) {
        law.relaxation.tau_s = tau_s(used);
        law.relaxation.contact_share = fitted.share(used);
        law.relaxation.share = Eigen::VectorXd::Ones(law.constants.size()) * law.relaxation.contact_share.transpose();
    }
    const auto count = std::count_if(cases.histories.begin(), cases.histories.end(), [](const History& h) { return h.role == "train"; });
    return {static_cast<int>(count), fitted.kkt_residual, fitted.misfit, fitted.grown, fitted.status};
}

}  // namespace

TrainedModel train_law_model(const Study& study, const Cases& cases, int threads) {
    if (!study.springs.is_law()) throw MismatchError("study '" + study.name + "' has no law: its stiffness is sets");
    TrainedModel model = untrained_model(study, cases, load_cases(cases));
    const Cases kept = without_mirrors(cases);
    const std::vector<PressPath> paths = press_paths(kept);
    if (paths.empty()) throw MismatchError(nothing_to_train_on(kept));

    LawTrainingOptions options;
    options.force_scale = study.training.force_scale;
    options.shape_scale = study.training.shape_scale;
    options.ridge = study.training.ridge;
    options.starts = study.training.starts;
    options.seed = study.training.seed;
    options.threads = threads;
    options.disc_radius_m = study.indenter.radius_m;
    if (cases.disc_radius_m > 0 && cases.disc_radius_m != study.indenter.radius_m)
        throw MismatchError(fmt::format("the cases are of a study whose disc has {:g} mm, this one's has {:g} mm", 1e3 * cases.disc_radius_m, 1e3 * study.indenter.radius_m));
    if (model.mesh.is_solid()) options.seen = seen_nodes(model.mesh);
    if (model.mesh.is_solid()) options.sizes = {radii_of(options.disc_radius_m, paths), model.mesh.embedding.spacing_m};
    if (model.mesh.is_solid()) options.fit.most_step = 2;  // from the heuristic longer steps lose contacts, which takes long to find out
    // a measured tissue's material is a guess: terms start from the heuristic that its forces speak for
    double factor = 1;
    if (cases.measurement)
        factor = heuristic_factor(model.mesh, study_law(study, kept.shape, model.mesh), paths, options);
    const EnergyLaw law = study_law(study, kept.shape, model.mesh, factor);
    const auto law_at = [&](const EnergyLaw& of, const Eigen::VectorXd& p) {
        LawModel made{of.terms(), p, of.constants(p), of.patch(p), of.incompressible(), options.disc_radius_m};
        made.curve = of.curve();
        made.disc = {of.ground(), options.curved_range, options.correction};
        made.sizes = options.sizes;
        return made;
    };
    const auto correct = [&](const Eigen::VectorXd& p) {
        const auto law_on = [&](const SpringMesh& mesh) { return law_at(study_law(study, kept.shape, mesh, factor), p); };
        const bool several = !options.sizes.empty();
        const Eigen::VectorXd radii_m = several ? options.sizes.radii_m : Eigen::VectorXd::Constant(1, options.disc_radius_m);
        const std::vector<FacetTable> tables = lattice_corrections(study_solid(study, kept.shape), model.mesh, law_on, radii_m, threads);
        for (std::size_t k = 0; k < tables.size(); ++k)
            if (radii_m[static_cast<Eigen::Index>(k)] == options.disc_radius_m) options.correction = tables[k];
        if (several) options.sizes.correction = tables;
    };
    const auto begin = std::chrono::steady_clock::now();
    if (model.mesh.is_solid()) {
        options.curved_range = curved_range(model.mesh, options.disc_radius_m, paths);
        // the correction depends on the law a little: of the untrained one first, then of one that was roughly trained with that
        correct(Eigen::VectorXd::Zero(law.size()));
        LawTrainingOptions rough = options;
        rough.starts = 1;
        rough.fit.gain_tolerance = 1e-2;
        options.first = train_law(model.mesh, law, paths, rough).coefficients;
        correct(options.first);
    }
    const TrainedLaw trained = train_law(model.mesh, law, paths, options);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    model.energy_law = law_at(law, trained.coefficients);
    model.energy_law->relaxation = study_relaxation(study, kept.shape, model.mesh, law);

    LawBook& book = model.books.law.emplace();
    const auto R = static_cast<Eigen::Index>(trained.starts.size());
    const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(law.size());
    book.untrained_constants = law.constants(nothing);
    book.untrained_patch = law.patch(nothing);
    book.objective = trained.objective;
    book.factor = factor;
    book.kept = static_cast<int>(trained.kept);
    book.paths = static_cast<int>(paths.size());
    for (const PressPath& path : paths) book.records += static_cast<int>(path.records.size());
    book.start_objective.resize(R);
    book.gradient.resize(R);
    for (Eigen::Index s = 0; s < R; ++s) {
        const FitResult& start = trained.starts[static_cast<std::size_t>(s)];
        book.status.push_back(to_string(start.status));
        book.start_objective[s] = 2 * start.half_square;
        book.gradient[s] = start.gradient;
        book.iterations.push_back(start.iterations);
        book.evaluations.push_back(start.evaluations);
    }
    // measured pushes of tissue that had come to rest: what they say is what is left of the law
    book.at_rest = cases.measurement && study.material.long_term;
    if (book.at_rest && !study.material.fits_shares) grow(*model.energy_law, 1 / (1 - model.energy_law->relaxation.contact_share.sum()));
    if (study.material.fits_shares) book.shares = fit_branches(study, cases, model, threads);
    book.lost = trained.lost;
    book.seconds = seconds;
    return model;
}

}  // namespace tissue
