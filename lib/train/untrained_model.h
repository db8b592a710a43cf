#pragma once

#include <string>
#include <vector>

#include "cases/load_path.h"
#include "study/study.h"
#include "train/training_books.h"

namespace tissue {

/// The study's spring mesh. Throws MismatchError when the cases are not on its nodes.
SpringMesh spring_mesh_of(const Study& study, const Cases& cases);

/// A model as it is before training: mesh, masses, heuristics, and the load cases it is about to be trained on; of the
/// books, the seed. Throws as spring_mesh_of.
TrainedModel untrained_model(const Study& study, const Cases& cases, const std::vector<LoadCase>& loads);

/// Why there is nothing to train on, in one line: how many training paths FE lost before their first load case, and of the first three place, depth and
/// cause.
std::string nothing_to_train_on(const Cases& cases);

}  // namespace tissue
