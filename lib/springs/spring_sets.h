#pragma once

#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// theta (C x S) [N/m] of an optimiser's sets; "" for the study's own, "optimum" for the certified ones. Throws
/// MismatchError for a name that is not in the model.
const NodeField& sets_of(const TissueModel& model, const std::string& optimizer);

/// One stiffness for every spring, by the name a person asks for it.
struct NamedSet {
    std::string name;       ///< of its load case, or one_set, heuristic_a, heuristic_b
    int load_case = -1;     ///< that it was trained on; -1: none
    Eigen::VectorXd theta;  ///< [N/m] (S)
};

/// The set called `set`, or every case's where it is empty; `optimizer` as above. Throws MismatchError for a name that
/// is not in the model.
std::vector<NamedSet> spring_sets(const TissueModel& model, const std::string& optimizer, const std::string& set);

}  // namespace tissue
