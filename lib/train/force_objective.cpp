#include "train/objectives.h"

namespace tissue {

TrainingProblems ForceObjective::pose(const TrainingData& data) const {
    std::vector<Target> targets;
    for (std::size_t c = 0; c < data.loads.size(); ++c)
        targets.push_back(force_target(data.loads[c], data.node_weight.row(static_cast<Eigen::Index>(c))));
    TrainingProblems p = node_problems(data, targets);
    solve_one_set(p, p.base, data);
    for (const ForceLoss& loss : p.base)
        p.minimised.push_back(data.settings.ridge > 0 ? with_ridge(loss, data.settings.ridge, data.heuristic) : loss);
    return p;
}

}  // namespace tissue
