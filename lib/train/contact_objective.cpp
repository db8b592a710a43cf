#include "parallel.h"
#include "springs/equilibrium.h"
#include "train/objectives.h"

namespace tissue {
namespace {

/// Weight of the contact's reaction over that of nodal forces: large enough to make the reaction's error negligible.
constexpr double reaction_factor = 30;

}  // namespace

TrainingProblems ContactObjective::pose(const TrainingData& data) const {
    std::vector<Target> targets;
    std::vector<SurfacePoint> contacts;
    for (std::size_t c = 0; c < data.loads.size(); ++c) {
        contacts.push_back(locate_on_surface(data.mesh, data.loads[c].path->contact_m));
        targets.push_back(contact_target(data.mesh, data.loads[c], contacts.back(),
                                         data.node_weight.row(static_cast<Eigen::Index>(c))));
    }
    TrainingProblems p = node_problems(data, targets);
    p.nearly_solved = true;
    const int count = static_cast<int>(targets.size());
    /// Loss of case i with its reaction, through the compliance at theta; absent without a compliance (`not_positive_definite`).
    const auto seen_from = [&](std::size_t i, const Eigen::VectorXd& theta) -> std::optional<ForceLoss> {
        const std::optional<Eigen::MatrixXd> G =
            contact_sensitivity(data.mesh, data.law, theta, contacts[i], targets[i].displacement);
        if (!G) return std::nullopt;
        return with_reaction(p.base[i], data.mesh, data.law, targets[i], *G, reaction_factor);
    };
    const auto ridged = [&](const ForceLoss& loss) {
        return data.settings.ridge > 0 ? with_ridge(loss, data.settings.ridge, data.heuristic) : loss;
    };

    std::vector<ForceLoss> seen = p.base;  // with the reaction, through the heuristic's compliance
    p.minimised = p.base;
    parallel_for(count, data.threads, [&](int c) {
        const auto i = static_cast<std::size_t>(c);
        if (const auto loss = seen_from(i, data.heuristic))
            seen[i] = *loss;
        else if (p.status[i] == ProblemStatus::set_up)
            p.status[i] = ProblemStatus::not_positive_definite;
        p.minimised[i] = ridged(seen[i]);
    });
    solve_one_set(p, seen, data);
    parallel_for(count, data.threads, [&](int c) {
        const auto i = static_cast<std::size_t>(c);
        if (p.status[i] == ProblemStatus::not_positive_definite) return;
        // The compliance that maps force residuals to the error of the reaction should be that of the trained set. It
        // is taken at a rough solution, in one step, without further iteration.
        BoundedLsqOptions rough = p.exact;
        rough.kkt_tolerance = 1e-6;
        const BoundedLsqSummary towards = solve_bounded_lsq(p.minimised[i], p.start[i], data.box, rough);
        if (p.status[i] == ProblemStatus::set_up) p.status[i] = problem_status(towards.status);
        p.start[i] = towards.theta;
        if (const auto loss = seen_from(i, p.start[i]))
            p.minimised[i] = ridged(*loss);
        else if (p.status[i] != ProblemStatus::no_force)
            p.status[i] = ProblemStatus::not_positive_definite;
    });
    return p;
}

}  // namespace tissue
