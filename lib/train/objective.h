#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "registry.h"
#include "springs/spring_law.h"
#include "study/study.h"
#include "train/bounded_lsq.h"
#include "train/loss_terms.h"
#include "train/optimizer.h"

namespace tissue {

/// Input of an objective.
struct TrainingData {
    const Study::Training& settings;
    const SpringMesh& mesh;
    const SpringLaw& law;
    const std::vector<LoadCase>& loads;  ///< (C)
    const NodeField& node_weight;        ///< diagonal of Q, one entry a node (C x N)
    const Eigen::VectorXd& heuristic;    ///< (7) with E2 = E t [N/m] (S), inside the box
    const Box& box;
    int threads;                         ///< without influence on the result
};

/// Whether the problem of one load case, or of the single set for all cases ("one set"), could be set up. f: force of
/// the target; K: stiffness matrix of the free nodes.
enum class ProblemStatus {
    set_up,           ///< set up as the objective defines it; preliminary solves converged (LsqStatus)
    /// Objective "contact": at the heuristic or at the rough solution K is not positive definite (a pivot <= 1e-10 of
    /// the largest), or the contact is on fixed nodes. The loss then has no reaction, or the heuristic's.
    not_positive_definite,
    no_force,         ///< |f| = 0; one set: in every case, and the set is the heuristic
    singular,         ///< one set: joint_loss has a pivot <= 0, and the set is the heuristic
    stalled,          ///< LsqStatus::stalled, of the one set or of the rough solution of "contact"
    iterations_done   ///< LsqStatus::iterations_done, of the one set or of the rough solution of "contact"
};

/// The name of the status in files and reports: "posed", ...
const char* to_string(ProblemStatus status);

/// Status of a problem with such a preliminary solve: `posed` where it converged.
ProblemStatus problem_status(LsqStatus status);

/// Training problems of a study: one convex problem for each case, and the single set for all cases.
struct TrainingProblems {
    std::vector<ForceLoss> base;           ///< (9) of the target, as reported [N] (C)
    std::vector<ForceLoss> minimised;      ///< base, with rows of a ridge or the reaction, and base's scale [N] (C)
    std::vector<Eigen::VectorXd> start;    ///< start of each training [N/m] (C of S), inside the box
    std::vector<ProblemStatus> status;     ///< (C)
    Eigen::VectorXd one_set;               ///< single set with the least joint loss over all cases [N/m] (S)
    ProblemStatus one_set_status = ProblemStatus::set_up;
    BoundedLsqOptions exact;               ///< options of the exact solver for these problems
    bool nearly_solved = false;            ///< whether the time of pose() counts as time of the exact solver
};

/// Training objective of spring sets: defines the loss of each load case.
class Objective {
   public:
    virtual ~Objective() = default;
    virtual std::string name() const = 0;

    /// Sets up the problems of all load cases. Non-convergence is a ProblemStatus.
    virtual TrainingProblems pose(const TrainingData& data) const = 0;
};

/// All objectives, each in its own file. The first is the paper's, the default of a study.
const Registry<std::shared_ptr<const Objective>>& objectives();

/// Problems with (9) of each target as `base` and the heuristic as start; `minimised` and the one set are left empty.
TrainingProblems node_problems(const TrainingData& data, const std::vector<Target>& targets);

/// Fills one_set and its status: exact minimum of joint_loss(losses), or the heuristic where that does not exist.
void solve_one_set(TrainingProblems& problems, const std::vector<ForceLoss>& losses, const TrainingData& data);

}  // namespace tissue
