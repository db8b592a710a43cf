#pragma once

#include <string>
#include <vector>

namespace tissue {

/// What a study file can name and who knows the names: declared here, where the reader asks, and defined beside the
/// registries of those who make the things, so that every kind is named once and the reader needs nothing below it.

/// Names of the objectives of training, of the registry in train/objective.cpp.
std::vector<std::string> objective_names();

/// Names of the optimisers, of the registry in train/optimizer.cpp.
std::vector<std::string> optimizer_names();

}  // namespace tissue
