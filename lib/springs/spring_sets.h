#pragma once

#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// Spring sets theta (C x S) [N/m] of an optimiser: "" for the study's own, "optimum" for the certified optimum. Throws
/// MismatchError for a name that is not in the model.
const NodeField& sets_of(const TissueModel& model, const std::string& optimizer);

/// One stiffness per spring, under the name by which users select it.
struct NamedSet {
    std::string name;       ///< that of its load case, or one_set, heuristic_a, heuristic_b
    int load_case = -1;     ///< load case that it was trained on; -1: none
    Eigen::VectorXd theta;  ///< [N/m] (S)
};

/// The set called `set`, or those of all cases if `set` is empty; `optimizer` as above. Throws MismatchError for a name
/// that is not in the model.
std::vector<NamedSet> spring_sets(const TissueModel& model, const std::string& optimizer, const std::string& set);

}  // namespace tissue
