#pragma once

#include <string>
#include <vector>

namespace tissue {

/// Names of objectives and optimisers that a study file may give. They are declared here and defined beside their
/// registries in lib/train, so that the reader of studies does not depend on that module.

/// Names of the training objectives in the registry of train/objective.cpp.
std::vector<std::string> objective_names();

/// Names of the optimisers in the registry of train/optimizer.cpp.
std::vector<std::string> optimizer_names();

}  // namespace tissue
