#pragma once

#include <string>
#include <vector>

#include "train/training_books.h"

namespace tissue {

/// How the training of a model ended, in words for people.
struct Endings {
    std::vector<std::string> broken;  ///< a line each: what promises convergence, and did not reach it
    std::vector<std::string> other;   ///< a line each: ends that are neither that nor convergence, such as all iterations done
};

/// What counts as broken:
///  - a certified optimum, or a set of "exact", that is not `converged`;
///  - a problem, or the one set, whose ProblemStatus is not `posed`;
///  - a set that `stalled` farther than a gap of 1e-3 from the certified optimum;
///  - a law whose kept start ended with `no_progress`, `held_back` or `iterations_done` (no study sets how many), or a
///    push it was trained on that is not `held` (springs/press.h).
/// A stop criterion that the study sets (`iterations_done`, `time_out`, `target_met`) and the end the paper's method has
/// by itself (`restarts_exhausted`) promise nothing. A model of an earlier program says nothing of its optimum.
Endings endings_of(const ProblemRecord& problems, const std::vector<TrainingBook>& trained, const OptimumProof& optimum);
Endings endings_of(const LawBook& law);
Endings endings_of(const TrainingBooks& books);

}  // namespace tissue
