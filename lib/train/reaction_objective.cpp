#include <cmath>

#include "mesh/outline.h"
#include "parallel.h"
#include "train/objectives.h"
#include "train/reaction.h"

namespace tissue {
namespace {

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

ProblemStatus problem_status(ReactionStatus status) {
    switch (status) {
        case ReactionStatus::converged:
            return ProblemStatus::posed;
        case ReactionStatus::stalled:
            return ProblemStatus::stalled;
        case ReactionStatus::iterations_done:
            break;
    }
    return ProblemStatus::iterations_done;
}

}  // namespace

TrainingProblems ReactionObjective::pose(const TrainingData& data) const {
    std::vector<Reading> readings;
    std::vector<double> places;
    const Outline outline(data.mesh);
    for (const LoadCase& load : data.loads) {
        places.push_back(outline.arc_of(load.path->contact_m));
        readings.push_back({locate_on_surface(data.mesh, load.path->contact_m), load.path->push_m(*load.record),
                            load.record->contact_force_N});
    }
    const Study::Training& settings = data.settings;
    TrainingProblems p;
    p.nearly_solved = true;
    if (settings.ridge > 0) p.exact.first_shift = p.exact.shift;
    const Eigen::VectorXd prior =
        data.box.project(best_factor(data.mesh, data.law, readings, data.heuristic) * data.heuristic);
    const ReactionFit all =
        fit_reactions(data.mesh, data.law, readings, prior, prior, settings.one_set_ridge, data.box);
    p.one_set = all.theta;
    p.one_set_status = problem_status(all.status);

    std::vector<std::optional<ReactionFit>> fits(readings.size());
    parallel_for(static_cast<int>(readings.size()), data.threads, [&](int c) {
        const auto i = static_cast<std::size_t>(c);
        fits[i] = fit_reactions(data.mesh, data.law, neighbours(readings, places, i, settings.reach_m), p.one_set,
                                p.one_set, settings.ridge, data.box);
    });
    for (const std::optional<ReactionFit>& fit : fits) {
        p.start.push_back(fit->theta);
        p.base.push_back(fit->losses.front());
        p.minimised.push_back(fit->inner);
        p.status.push_back(p.base.back().scale() > 0 ? problem_status(fit->status) : ProblemStatus::no_force);
    }
    return p;
}

}  // namespace tissue
