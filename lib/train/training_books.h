#pragma once

#include <string>
#include <vector>

#include "springs/tissue_model.h"

namespace tissue {

/// What training wrote down of one optimiser's sets.
struct TrainingBook {
    std::string optimizer;
    Eigen::VectorXd loss_N, rel_loss;      ///< L(theta) and over sqrt(f_fe' Q f_fe) (C)
    Eigen::VectorXd gap;                   ///< how far from the certified optimum, train/certificate.h (C)
    std::vector<int> iterations, evaluations, restarts;  ///< (C)
    std::vector<std::string> status;       ///< TrainStatus of each, train/optimizer.h (C)
    std::vector<int> curve_iteration;      ///< of the learning curves (P)
    NodeField curve_loss_N;                ///< (C x P), NaN after a set has stopped
    double seconds = 0;                    ///< wall time of all sets together; an attribute, not a dataset
};

/// The proof that goes with the best spring sets: no set inside the box has a smaller loss than the lower bound.
struct OptimumProof {
    Eigen::VectorXd loss_N, rel_loss;       ///< (C)
    Eigen::VectorXd lower_bound_N;          ///< L_lb (C)
    Eigen::VectorXd kkt_residual;           ///< of the optimality conditions, as a part of the target of what is minimised (C)
    std::vector<std::string> status;        ///< LsqStatus of each, train/bounded_lsq.h (C); empty: of an earlier program
    double seconds = 0;                     ///< wall time of all sets together; an attribute, not a dataset
};

/// How the problems that the sets solve came about (train/objective.h). Empty of a model of an earlier program.
struct ProblemRecord {
    std::string objective;                  ///< the objective's name
    std::vector<std::string> status;        ///< ProblemStatus of each case (C)
    std::string one_set_status;             ///< and of the single set that serves all
};

/// How the training of a law ended (train/train_law.h).
struct LawBook {
    Eigen::VectorXd untrained_constants;         ///< the heuristic's, as LawModel::constants (E)
    PatchLaw untrained_patch;                    ///< and its contact
    double objective = 0;                        ///< of the coefficients kept, its ridge included
    int kept = 0;                                ///< the start whose coefficients they are: of those that lost the fewest presses the one with the smallest objective
    int paths = 0, records = 0;                  ///< trained on
    double factor = 1;                           ///< E2 of the heuristic that the coefficients are over, over the study's: of
                                                 ///< measured cases heuristic_factor, else 1
    std::vector<std::string> status;             ///< FitStatus of each start, train/nonlinear_fit.h (R)
    Eigen::VectorXd start_objective, gradient;   ///< of each start: objective, max |g_i| of its half (R)
    std::vector<int> iterations, evaluations;    ///< of each start (R)
    std::vector<std::string> lost;               ///< pushes trained on, not held at the end: where, how deep, as what
    double seconds = 0;                          ///< wall time; an attribute, not a dataset
    /// How shares were fitted to measured histories (train/fit_shares.h); nothing where they are the material's.
    struct Shares {
        int histories = 0;                       ///< fitted to
        double kkt_residual = 0, misfit = 0, grown = 1;
        std::string status;
    };
    std::optional<Shares> shares = {};
    bool at_rest = false;                        ///< whether its cases are readings of tissue that had come to rest, so that they are
                                                 ///< of what is left of the law after long
};

/// Training's own books: what the evaluation needs beside the cases, and no hand that touches the tissue.
struct TrainingBooks {
    unsigned long seed = 0;                ///< that training drew from; as read, the writer's Provenance says it
    NodeField node_weight;                 ///< Q of each case, one entry a node (C x N)
    std::vector<TrainingBook> trained;     ///< in the order of TissueModel::trained
    OptimumProof optimum;                  ///< of TissueModel::optimum
    ProblemRecord problems;
    std::optional<LawBook> law;            ///< of TissueModel::energy_law, in place of all but the seed
};

/// All that model.h5 holds.
struct TrainedModel : TissueModel {
    TrainingBooks books;
};

/// The law whose forces the cases are that it was trained on. The model must have one.
LawModel law_of_cases(const TrainedModel& model);

void write_trained_model(const std::string& file, const TrainedModel& model, const Provenance& provenance);

/// Throws FileError when the file is not a model, its parts do not fit together, or it has no books.
TrainedModel read_trained_model(const std::string& file);

}  // namespace tissue
