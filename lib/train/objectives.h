#pragma once

#include "train/objective.h"

namespace tissue {

/// The paper's objective: (9) with every node at its FE position, and the study's ridge towards the heuristic, if any.
class ForceObjective final : public Objective {
   public:
    std::string name() const override { return "force"; }
    TrainingProblems pose(const TrainingData& data) const override;
};

/// Objective for the contact force: the whole indenter force acts at the contact (contact_target), and the error of the
/// contact's reaction in equilibrium is added through the set's compliance (with_reaction). Two passes: with the
/// compliance of the heuristic, then with that of the solution.
class ContactObjective final : public Objective {
   public:
    std::string name() const override { return "contact"; }
    TrainingProblems pose(const TrainingData& data) const override;
};

}  // namespace tissue
