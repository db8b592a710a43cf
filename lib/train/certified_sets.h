#pragma once

#include "springs/tissue_model.h"
#include "train/objective.h"

namespace tissue {

/// The exact solution of every problem, and its certificate: what no set inside the box can beat.
struct CertifiedSets {
    CertifiedOptimum optimum;
    std::vector<TrainSummary> sets;  ///< what an optimiser that is exact has to say: theta, loss and status (C)
};
CertifiedSets certify(const TrainingProblems& problems, const Box& box, int threads);

/// What an optimiser made of every problem, as the model keeps it, beside the certified optimum. `seconds`: wall time.
TrainedSets gather(const std::string& optimizer, const std::vector<TrainSummary>& sets, const TrainingProblems& problems,
                   const CertifiedOptimum& optimum, double seconds);

}  // namespace tissue
