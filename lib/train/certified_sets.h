#pragma once

#include "train/objective.h"
#include "train/training_diagnostics.h"

namespace tissue {

/// Exact solution of every problem, with its certificate (train/certificate.h).
struct CertifiedSets {
    NodeField theta;                 ///< [N/m] (C x S)
    OptimumCertificate proof;
    std::vector<TrainSummary> sets;  ///< theta, loss and status, as an exact optimiser returns them (C)
};
/// threads: without influence on the result.
CertifiedSets certify(const TrainingProblems& problems, const Box& box, int threads);

/// Summaries of one optimiser for all problems, with gaps to the certified optimum. sets (C); seconds: wall time.
SetDiagnostics gather(const std::string& optimizer, const std::vector<TrainSummary>& sets, const TrainingProblems& problems,
                    const OptimumCertificate& optimum, double seconds);

/// theta of all summaries [N/m] (C x S).
NodeField theta_of(const std::vector<TrainSummary>& sets);

}  // namespace tissue
