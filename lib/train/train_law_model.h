#pragma once

#include "train/untrained_model.h"

namespace tissue {

/// A study whose stiffness is a law: train_law (train/train_law.h) on its training paths, without those that are but the
/// mirror images of others. Measured cases say forces alone, and the study's material is a guess: the law's heuristic
/// is then `heuristic_factor` of the study's. The same for any number of threads.
/// Throws MismatchError when the cases are not on the study's nodes, or a term is not possible there.
TrainedModel train_law_model(const Study& study, const Cases& cases, int threads);

}  // namespace tissue
