#pragma once

#include <string>
#include <vector>

#include "cases/history.h"
#include "cases/load_path.h"
#include "eval/force_error.h"
#include "haptic/simulation.h"

namespace tissue {

/// How far a force over time is from the truth's: rms over time of |F - F_fe| over that of |F_fe|, and the largest |F - F_fe|
/// over the largest |F_fe|. Infinity where the answer is not finite to its end; NaN where there is no truth, or it is no force at all.
struct HistoryError {
    double rms, peak;
};

/// time_s (T), ascending; truth, answer (T x D) [N]. Between times they go straight.
HistoryError history_error(const Eigen::VectorXd& time_s, const NodeField& truth_N, const NodeField& answer_N);

/// The tool's force on the learned mesh [N] (T x D) at a history's times, tick by tick as the device would have it, the tool held where
/// the history has it: it pushes and draws, as the finite elements' contact does. NaN from where the mesh flies apart.
NodeField play_history(const HapticModel& model, const History& history);

/// What models say of one history.
struct HistoryAnswer {
    std::string name, group, kind;
    std::vector<double> time_s, fe_N, learned_N, elastic_N;  ///< force along the push's direction; elastic: of best_factor
    HistoryError elastic;                         ///< of the instantaneous law against FE that does not relax: what the law itself is off; NaN where FE has none
    std::vector<HistoryError> error;              ///< of each model
};

/// Models in time, against histories held out. Drawn ones stand at contacts that nothing was trained on; measured ones at contacts that no
/// history was fitted at, and some of them where pushes trained the law (near_training): they judge behaviour in time, not the law.
///   learned         the law with its branches, as it plays
///   long_term       the law without branches, what is left of it after long,
///   instantaneous   and what it is at once
///   best_factor     the instantaneous one times the factor that is best on all these histories: the elastic springs that come nearest
///   kelvin_voigt    a F + b dF/dt of it, a and b the best: dampers beside the springs, in proportion to them
///   one_branch      the instantaneous one through one branch, its share and time the best
///   prony           no springs: FE's own force without relaxation, through the material's branches
/// Those in between are fitted to those of the very histories that judge them in which mass does not matter (prony within 5 %), or to all of them where none is such, all the same
/// weight, which flatters them.
struct HistoryTable {
    std::vector<std::string> models;
    std::vector<HistoryAnswer> answers;
    std::vector<std::string> lost;   ///< "name: why", histories that FE gave up
    std::vector<std::string> lost_group;  ///< and the group of each
    double factor = 0;               ///< of best_factor
    double kelvin_voigt[2] = {0, 0};  ///< a, b [s]
    double branch[2] = {0, 0};        ///< share, time [s] of one_branch
    bool fitted_to_all = false;       ///< those in between: to every history that has an answer, as no history has an elastic run of FE by which to tell where mass does not matter
    int near_training = 0;            ///< of measured histories, how many of the answers are near_training

    bool empty() const { return answers.empty() && lost.empty(); }
    std::vector<std::string> groups() const;  ///< in the order of the histories, then those all of which FE lost
    /// rms or peak of a model's errors over a group, those that FE lost among them; "" is all of them.
    Statistics rms(std::size_t model, const std::string& group) const;
    Statistics peak(std::size_t model, const std::string& group) const;
    Statistics elastic_rms(const std::string& group) const;
};

/// role: of the histories that count. Throws MismatchError for a model without a law.
HistoryTable evaluate_histories(const TissueModel& model, const std::vector<History>& histories, const std::string& role, int threads);

/// How many histories of `role` that are not lost have their contact within 2 mm of a training path's.
int near_training(const Cases& cases, const std::string& role);

}  // namespace tissue
