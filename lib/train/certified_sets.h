#pragma once

#include "train/objective.h"
#include "train/training_books.h"

namespace tissue {

/// The exact solution of every problem, and its certificate: what no set inside the box can beat.
struct CertifiedSets {
    NodeField theta;                 ///< [N/m] (C x S)
    OptimumProof proof;
    std::vector<TrainSummary> sets;  ///< what an optimiser that is exact has to say: theta, loss and status (C)
};
CertifiedSets certify(const TrainingProblems& problems, const Box& box, int threads);

/// What an optimiser wrote down of every problem, beside the certified optimum. `seconds`: wall time.
TrainingBook gather(const std::string& optimizer, const std::vector<TrainSummary>& sets, const TrainingProblems& problems,
                    const OptimumProof& optimum, double seconds);

/// The spring sets of an optimiser's summaries [N/m] (C x S).
NodeField theta_of(const std::vector<TrainSummary>& sets);

}  // namespace tissue
