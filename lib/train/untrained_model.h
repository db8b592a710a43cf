#pragma once

#include <string>
#include <vector>

#include "cases/load_path.h"
#include "study/study.h"
#include "train/training_diagnostics.h"

namespace tissue {

/// Spring mesh of the study. Throws MismatchError when the nodes of the cases are not those of the mesh.
SpringMesh spring_mesh_of(const Study& study, const Cases& cases);

/// A model before training: mesh, masses, heuristics and the load cases for training. Of the diagnostics it has the
/// seed. Throws as spring_mesh_of.
TrainedModel untrained_model(const Study& study, const Cases& cases, const std::vector<LoadCase>& loads);

/// Message for cases without a load case to train on, in one line: the number of training paths that ended in FE before
/// their first load case, with place, depth and cause of the first three.
std::string nothing_to_train_on(const Cases& cases);

}  // namespace tissue
