#include "train/objective.h"

#include "study/kinds.h"
#include "train/objectives.h"

namespace tissue {

const char* to_string(ProblemStatus status) {
    switch (status) {
        case ProblemStatus::set_up:
            return "posed";
        case ProblemStatus::not_positive_definite:
            return "floppy";
        case ProblemStatus::no_force:
            return "no_force";
        case ProblemStatus::singular:
            return "singular";
        case ProblemStatus::stalled:
            return "stalled";
        case ProblemStatus::iterations_done:
            return "iterations_done";
    }
    return "unknown";
}

ProblemStatus problem_status(LsqStatus status) {
    switch (status) {
        case LsqStatus::converged:
            return ProblemStatus::set_up;
        case LsqStatus::stalled:
            return ProblemStatus::stalled;
        case LsqStatus::iterations_done:
            break;
    }
    return ProblemStatus::iterations_done;
}

const Registry<std::shared_ptr<const Objective>>& objectives() {
    static const Registry<std::shared_ptr<const Objective>> all(
        "objective",
        {
            std::make_shared<ForceObjective>(),
            std::make_shared<ContactObjective>(),
        },
        [](const auto& objective) { return objective->name(); });
    return all;
}

std::vector<std::string> objective_names() { return objectives().names(); }

TrainingProblems node_problems(const TrainingData& data, const std::vector<Target>& targets) {
    TrainingProblems p;
    for (const Target& target : targets) {
        p.base.push_back(loss_of(data.mesh, data.law, target));
        p.status.push_back(p.base.back().scale() > 0 ? ProblemStatus::set_up : ProblemStatus::no_force);
    }
    p.start.assign(targets.size(), data.heuristic);
    // with a ridge the problem is well conditioned: start with unshifted Newton steps
    if (data.settings.ridge > 0) p.exact.first_shift = p.exact.shift;
    return p;
}

void solve_one_set(TrainingProblems& problems, const std::vector<ForceLoss>& losses, const TrainingData& data) {
    problems.one_set = data.heuristic;
    const std::optional<ForceLoss> joint = joint_loss(losses);
    if (!joint) {
        problems.one_set_status = ProblemStatus::no_force;
        for (const ForceLoss& loss : losses)
            if (loss.scale() > 0) problems.one_set_status = ProblemStatus::singular;
        return;
    }
    const BoundedLsqSummary exact = solve_bounded_lsq(*joint, data.heuristic, data.box);
    problems.one_set = exact.theta;
    problems.one_set_status = problem_status(exact.status);
}

}  // namespace tissue
