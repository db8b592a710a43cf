#pragma once

#include "train/objective.h"

namespace tissue {

/// (9) at every node where FE has it, the paper's; a ridge, if the study has one, pulls towards the heuristic.
class ForceObjective final : public Objective {
   public:
    std::string name() const override { return "force"; }
    TrainingProblems pose(const TrainingData& data) const override;
};

/// The force a hand feels: the contact's whole force at the contact (contact_target), and its reaction in closed loop
/// through the set's own compliance (with_reaction), found in two passes.
class ContactObjective final : public Objective {
   public:
    std::string name() const override { return "contact"; }
    TrainingProblems pose(const TrainingData& data) const override;
};

}  // namespace tissue
