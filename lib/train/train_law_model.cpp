#include "train/train_law_model.h"

#include "cases/study_law.h"
#include "error.h"
#include "mesh/free_surface.h"
#include "train/train_law.h"

namespace tissue {

TrainedModel train_law_model(const Study& study, const Cases& cases, int threads) {
    if (!study.springs.is_law()) throw MismatchError("study '" + study.name + "' has no law: its stiffness is sets");
    TrainedModel model = untrained_model(study, cases, load_cases(cases));
    const Cases kept = without_mirrors(cases);
    const std::vector<PressPath> paths = press_paths(kept);

    LawTrainingOptions options;
    options.force_scale = study.training.force_scale;
    options.shape_scale = study.training.shape_scale;
    options.ridge = study.training.ridge;
    options.starts = study.training.starts;
    options.seed = study.training.seed;
    options.threads = threads;
    options.disc_radius_m = study.indenter.radius_m;
    if (model.mesh.is_solid()) options.seen = seen_nodes(model.mesh);
    // a measured tissue's material is a guess: terms start from the heuristic that its forces speak for
    double factor = 1;
    if (cases.measurement)
        factor = heuristic_factor(model.mesh, study_law(study, kept.shape, model.mesh), paths, options);
    const EnergyLaw law = study_law(study, kept.shape, model.mesh, factor);
    const TrainedLaw trained = train_law(model.mesh, law, paths, options);
    model.energy_law = {law.terms(), trained.coefficients, law.constants(trained.coefficients), law.patch(trained.coefficients),
                        law.incompressible(), options.disc_radius_m, law.ground(), {},
                        study_relaxation(study, kept.shape, model.mesh, law)};

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
    book.lost = trained.lost;
    book.seconds = trained.seconds;
    return model;
}

}  // namespace tissue
