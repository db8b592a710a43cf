#pragma once

#include <string>
#include <vector>

#include "train/training_diagnostics.h"

namespace tissue {

/// How the training of a model ended, as lines of a report.
struct Endings {
    std::vector<std::string> broken;  ///< parts that should converge and did not
    std::vector<std::string> other;   ///< parts that stopped for another reason, such as the number of iterations
};

/// `broken` contains:
///  - a certified optimum that is not `converged`;
///  - a problem, or the one set, whose ProblemStatus is not `posed`;
///  - a set that `stalled` with a gap above 1e-3 to the certified optimum;
///  - an energy model whose kept start ended with `no_progress`, `held_back` or `iterations_done` (studies do not set
///    their number), or with a training record that has not converged (SolverStatus in springs/equilibrium_solver.h).
/// A stop criterion of the study (`iterations_done`, `time_out`, `target_met`) and the regular end of the paper's
/// method (`restarts_exhausted`) are in `other`. A file of an earlier version has no status of the optimum.
Endings endings_of(const ProblemRecord& problems, const std::vector<SetDiagnostics>& trained, const OptimumCertificate& optimum);
Endings endings_of(const EnergyModelDiagnostics& diagnostics);
Endings endings_of(const TrainingDiagnostics& books);

}  // namespace tissue
