#pragma once

#include <functional>
#include <string>

#include "cases/load_path.h"
#include "study/study.h"
#include "train/untrained_model.h"

namespace tissue {

/// Called when a set is trained, from any thread, one call at a time. done, total: numbers of sets; set: name.
using TrainProgress = std::function<void(int done, int total, const std::string& set)>;

/// Trains one spring set for every load case of the study (Sec. 3), with its optimiser and with those in `also`. Q and
/// the perturbations of each set have their own random streams, seeded by the study's seed and the name of the case, so
/// the result does not depend on the number of threads.
/// Throws MismatchError for a study with an energy model, when the cases are not on the study's nodes, have no load
/// case, or are measured (displacements inside measured tissue are not known).
TrainedModel train_sets(const Study& study, const Cases& cases, int threads, const TrainProgress& progress = {});

}  // namespace tissue
