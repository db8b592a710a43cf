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

/// What an objective makes its problems of.
struct TrainingData {
    const Study::Training& settings;
    const SpringMesh& mesh;
    const SpringLaw& law;
    const std::vector<LoadCase>& loads;  ///< (C)
    const NodeField& node_weight;        ///< diagonal of Q, one entry a node (C x N)
    const Eigen::VectorXd& heuristic;    ///< (7) with E2 = E t [N/m] (S), inside the box
    const Box& box;
    int threads;                         ///< change no result
};

/// How a problem came about: that of one load case, or that of the one set which serves all of them. f is the force the
/// springs are to hold, K the stiffness of the free nodes.
enum class ProblemStatus {
    posed,            ///< as the objective says it; what had to be solved for it converged (LsqStatus)
    floppy,           ///< "contact": a pivot of K <= 1e-10 of the largest, at the heuristic or one step from it, so the contact
                      ///< has no compliance of the set's own: the nodes count alone, or with the heuristic's compliance
    no_force,         ///< |f| = 0, of every case where it is the one set's: nothing is relative to it; of the one set: the heuristic
    singular,         ///< of the one set: a pivot <= 0 of the sum of normal matrices and its ridge (joint_loss); it is the heuristic
    stalled,          ///< LsqStatus::stalled of the one set; of a case, of the rough solution that "contact" takes compliance at
    iterations_done   ///< LsqStatus::iterations_done, likewise
};

/// The status in the words of reports: "posed", ...
const char* to_string(ProblemStatus status);

/// How a problem came about for which this was solved: `posed` where it converged.
ProblemStatus problem_status(LsqStatus status);

/// What the sets of a study are trained on: one convex problem a case, and a set that serves all.
struct TrainingProblems {
    std::vector<ForceLoss> base;           ///< (9) or its like, in which reports speak [N] (C)
    std::vector<ForceLoss> minimised;      ///< that with more rows, a ridge or the reaction, in the unit of base and with its scale [N] (C)
    std::vector<Eigen::VectorXd> start;    ///< where each set's training begins: inside the box, near the answer if known
    std::vector<ProblemStatus> status;     ///< (C)
    Eigen::VectorXd one_set;               ///< the single set that serves all cases best [N/m] (S)
    ProblemStatus one_set_status = ProblemStatus::posed;
    BoundedLsqOptions exact;               ///< how the exact solver should go about them
    bool nearly_solved = false;            ///< posing them was most of solving them: its time counts as the solver's
};

/// A way to say which springs are good.
class Objective {
   public:
    virtual ~Objective() = default;
    virtual std::string name() const = 0;

    /// Non-convergence is a status of its problem.
    virtual TrainingProblems pose(const TrainingData& data) const = 0;
};

/// Every objective there is; each in a file of its own. The paper's comes first, which a study has that names none.
const Registry<std::shared_ptr<const Objective>>& objectives();

/// One problem a case out of its target and nothing else, every start the heuristic: what objectives begin with.
TrainingProblems node_problems(const TrainingData& data, const std::vector<Target>& targets);

/// The set that serves all the losses best: their joint problem, solved exactly.
void solve_one_set(TrainingProblems& problems, const std::vector<ForceLoss>& losses, const TrainingData& data);

}  // namespace tissue
