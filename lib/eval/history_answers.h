#pragma once

#include <string>
#include <vector>

#include "cases/history.h"
#include "cases/load_path.h"
#include "eval/force_error.h"
#include "haptic/simulation.h"

namespace tissue {

/// Relative errors of a force over time. rms: rms over time of |F - F_fe| over that of |F_fe|. peak: largest |F - F_fe|
/// over the largest |F_fe|. Infinity where the model's force is not finite; NaN where the reference is missing or 0.
struct HistoryError {
    double rms, peak;
};

/// Errors of answer_N against the reference truth_N (T x D) [N] at times time_s (T), ascending. Integrals over time are
/// by the trapezoidal rule.
HistoryError history_error(const Eigen::VectorXd& time_s, const NodeField& truth_N, const NodeField& answer_N);

/// Force of the tool on the first mesh of the model [N] (T x D) at the times of a history, advanced tick by tick as in
/// a session. The tool follows the displacement history; its contact is bilateral (it can pull), as in FE. NaN from the
/// time at which the mesh diverges. Throws MismatchError for a model without an energy model.
NodeField play_history(const HapticModel& model, const History& history);

/// Forces and errors of all models for one displacement history.
struct HistoryAnswer {
    std::string name, group, kind;
    std::vector<double> time_s, fe_N, learned_N, elastic_N;  ///< force along `direction`; elastic_N: of best_factor
    /// Error of the instantaneous energy model against FE without relaxation: the error of the elastic part. NaN where
    /// FE has no such run.
    HistoryError elastic;
    std::vector<HistoryError> error;              ///< of each model, in the order of HistoryTable::models
};

/// Errors of the force over time on displacement histories of the test set. Drawn histories are at contacts without any
/// training. Measured ones are at contacts where no history was fitted, but some of these contacts have static training
/// data (near_training): they test the behaviour in time, not the static force. Models:
///   learned         the energy model with its Maxwell branches, as in a session
///   long_term       the energy model without branches, with its long-term moduli
///   instantaneous   the same with its instantaneous moduli
///   best_factor     the instantaneous force F times one fitted factor: the best elastic model
///   kelvin_voigt    a F + b dF/dt with fitted a and b: dampers parallel and proportional to the springs
///   one_branch      F through one Maxwell branch, with fitted factor, relative modulus and relaxation time
///   prony           no springs: the FE force without relaxation, through the branches of the model
/// best_factor, kelvin_voigt and one_branch are fitted by least squares to the histories that they are evaluated on,
/// all with the same weight, so their errors are too low. Only histories in which inertia does not matter are fitted
/// to: those where the rms error of prony is below 5 %. Without any such history all are used (fitted_to_all).
struct HistoryTable {
    std::vector<std::string> models;
    std::vector<HistoryAnswer> answers;
    std::vector<std::string> lost;   ///< "name: why", histories without an FE reference
    std::vector<std::string> lost_group;  ///< group of each of these
    double factor = 0;               ///< of best_factor
    double kelvin_voigt[2] = {0, 0};  ///< a, b [s]
    double branch[2] = {0, 0};        ///< relative modulus, relaxation time [s] of one_branch
    bool fitted_to_all = false;       ///< whether baselines were fitted to every history that has a finite answer
    int near_training = 0;            ///< measured histories: result of near_training()

    bool empty() const { return answers.empty() && lost.empty(); }
    std::vector<std::string> groups() const;  ///< in the order of the histories; groups with only `lost` histories last
    /// Statistics of a model's errors over a group; "" means all groups. `lost` histories count as missing references.
    Statistics rms(std::size_t model, const std::string& group) const;
    Statistics peak(std::size_t model, const std::string& group) const;
    Statistics elastic_rms(const std::string& group) const;
};

/// Evaluates the histories of one role. threads: without influence on the result. Throws MismatchError for a model
/// without an energy model.
HistoryTable evaluate_histories(const TissueModel& model, const std::vector<History>& histories, const std::string& role, int threads);

/// Number of histories of `role` that have a reference and whose contact is within 2 mm of a training contact.
int near_training(const Cases& cases, const std::string& role);

}  // namespace tissue
