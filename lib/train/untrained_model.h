#pragma once

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

}  // namespace tissue
