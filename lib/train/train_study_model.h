#pragma once

#include "train/untrained_model.h"

namespace tissue {

/// Trains the energy model of a study with train_energy_model (train/train_energy_model.h) on the training paths, without mirror images
/// of other paths. Measured cases have forces only, and the study's material is an assumption: the heuristic is then
/// scaled by `heuristic_factor`. With measured histories the relative moduli are fitted afterwards
/// (train/relative_moduli.h). The result does not depend on the number of threads.
/// Throws MismatchError for a study with spring sets, without a training path, when the cases are not on the study's
/// nodes or have another disc, and when a term does not fit the mesh.
TrainedModel train_study_model(const Study& study, const Cases& cases, int threads);

}  // namespace tissue
