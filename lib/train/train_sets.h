#pragma once

#include <functional>
#include <string>

#include "cases/load_path.h"
#include "study/study.h"
#include "train/untrained_model.h"

namespace tissue {

/// Called from any thread, one call at a time, whenever a set is done.
using TrainProgress = std::function<void(int done, int total, const std::string& set)>;

/// Sec. 3: one spring set for every load case of the study, by its optimiser and by those it compares with.
/// Every set draws its Q and its perturbations from streams of its own, seeded by the study's seed and the set's
/// name, so the result is the same for any number of threads.
/// Throws MismatchError when the cases are not on the study's lattice, have no load case, or are measured: nothing inside is
/// known of those.
TrainedModel train_sets(const Study& study, const Cases& cases, int threads, const TrainProgress& progress = {});

}  // namespace tissue
