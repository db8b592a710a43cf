#pragma once

#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// Training diagnostics of all sets of one optimiser.
struct SetDiagnostics {
    std::string optimizer;
    Eigen::VectorXd loss_N, rel_loss;      ///< minimised loss; TrainingProblems::base over its scale (C)
    Eigen::VectorXd gap;                   ///< loss_gap to the certified optimum, train/certificate.h (C)
    std::vector<int> iterations, evaluations, restarts;  ///< (C)
    std::vector<std::string> status;       ///< TrainStatus of each set, train/optimizer.h (C)
    std::vector<int> curve_iteration;      ///< iterations of the learning curves (P)
    NodeField curve_loss_N;                ///< (C x P), NaN where a set has no point
    double seconds = 0;                    ///< wall time of all sets together; an attribute, not a dataset
};

/// Certificate of the optimal spring sets: no set inside the box has a smaller loss than the lower bound.
struct OptimumCertificate {
    Eigen::VectorXd loss_N, rel_loss;       ///< as in SetDiagnostics (C)
    Eigen::VectorXd lower_bound_N;          ///< L_lb of the minimised loss (C)
    Eigen::VectorXd kkt_residual;           ///< over the norm of the minimised loss's target, train/bounded_lsq.h (C)
    /// LsqStatus of each, train/bounded_lsq.h (C); empty: file of an earlier version.
    std::vector<std::string> status;
    double seconds = 0;                     ///< wall time of all sets together; an attribute, not a dataset
};

/// Status of the training problems of spring sets (train/objective.h). Empty in a file of an earlier version.
struct ProblemRecord {
    std::string objective;                  ///< the objective's name
    std::vector<std::string> status;        ///< ProblemStatus of each case (C)
    std::string one_set_status;             ///< ProblemStatus of the single set for all cases
};

/// Training diagnostics of an energy model (train/train_energy_model.h).
struct EnergyModelDiagnostics {
    Eigen::VectorXd untrained_constants;         ///< constants of the heuristic, as EnergyModel::constants (E)
    ContactParameters untrained_patch;                    ///< contact of the heuristic
    double objective = 0;                        ///< at the kept coefficients, ridge included
    int kept = 0;                                ///< index of the kept start (TrainedEnergyModel::kept)
    int paths = 0, records = 0;                  ///< numbers of training paths and records
    double factor = 1;                           ///< E2 of the heuristic over the study's: heuristic_factor for
                                                 ///< measured cases, else 1
    std::vector<std::string> status;             ///< FitStatus of each start, train/nonlinear_fit.h (R)
    Eigen::VectorXd start_objective, gradient;   ///< of each start: final objective, max |g_i| of its half (R)
    std::vector<int> iterations, evaluations;    ///< of each start (R)
    std::vector<std::string> lost;               ///< TrainedEnergyModel::lost
    double seconds = 0;                          ///< wall time; an attribute, not a dataset
    /// Fit of relative moduli to measured histories (FittedModuli of train/relative_moduli.h). Absent where the relative
    /// moduli are those of the study's material.
    struct Shares {
        int histories = 0;                       ///< number of histories of role "train"
        double kkt_residual = 0, misfit = 0, grown = 1;
        std::string status;
    };
    std::optional<Shares> shares = {};
    bool at_rest = false;                        ///< whether the cases are measurements of tissue at rest, which are
                                                 ///< compared with the long-term force of the model
};

/// Training diagnostics that the evaluation needs and a haptic session does not.
struct TrainingDiagnostics {
    unsigned long seed = 0;                ///< seed of the training; in the file it is part of Provenance
    NodeField node_weight;                 ///< diagonal of Q of each case, one entry for each node (C x N)
    std::vector<SetDiagnostics> trained;     ///< in the order of TissueModel::trained
    OptimumCertificate optimum;                  ///< of TissueModel::optimum
    ProblemRecord problems;
    std::optional<EnergyModelDiagnostics> energy_model;            ///< of TissueModel::energy_model; replaces all members except the seed
};

/// Complete content of a model.h5.
struct TrainedModel : TissueModel {
    TrainingDiagnostics books;
};

/// The energy model whose static forces correspond to the training cases: with long-term moduli where the cases are
/// measurements of tissue at rest (EnergyModelDiagnostics::at_rest). The model must have an energy model.
EnergyModel energy_model_of_cases(const TrainedModel& model);

void write_trained_model(const std::string& file, const TrainedModel& model, const Provenance& provenance);

/// Throws FileError when the file is not a model, its parts do not fit together, or it has no training diagnostics.
TrainedModel read_trained_model(const std::string& file);

}  // namespace tissue
