#pragma once

#include <string>
#include <vector>

#include "io/hdf5_store.h"
#include "mesh/spring_mesh.h"

namespace tissue {

/// What one optimiser made of every load case: one row of theta a case.
struct TrainedSets {
    std::string optimizer;
    NodeField theta;                       ///< [N/m] (C x S)
    Eigen::VectorXd loss_N, rel_loss;      ///< L(theta) and over sqrt(f_fe' Q f_fe) (C)
    Eigen::VectorXd gap;                   ///< how far from the certified optimum, train/certificate.h (C)
    std::vector<int> iterations, evaluations, restarts;  ///< (C)
    std::vector<std::string> status;       ///< TrainStatus of each, train/optimizer.h (C)
    std::vector<int> curve_iteration;      ///< of the learning curves (P)
    NodeField curve_loss_N;                ///< (C x P), NaN after a set has stopped
    double seconds = 0;                    ///< wall time of all sets together; an attribute, not a dataset
};

/// The best spring sets there are inside the box, and the proof: no set has a smaller loss than the lower bound.
struct CertifiedOptimum {
    NodeField theta;                        ///< [N/m] (C x S)
    Eigen::VectorXd loss_N, rel_loss;       ///< (C)
    Eigen::VectorXd lower_bound_N;          ///< L_lb (C)
    Eigen::VectorXd kkt_residual;           ///< of the optimality conditions, as a part of the FE force (C)
    std::vector<std::string> status;        ///< LsqStatus of each, train/bounded_lsq.h (C); empty: of an earlier program
    double seconds = 0;                     ///< wall time of all sets together; an attribute, not a dataset
};

/// How the problems that the sets solve came about (train/objective.h). Empty of a model of an earlier program.
struct ProblemRecord {
    std::string objective;                  ///< the objective's name
    std::vector<std::string> status;        ///< ProblemStatus of each case (C)
    std::string one_set_status;             ///< and of the single set that serves all
};

/// Everything the realtime core needs, and everything the evaluation needs beside the cases: what model.h5 holds.
struct TissueModel {
    std::string study, law;
    unsigned long seed = 0;                ///< that its training drew from
    SpringMesh mesh;
    double modulus_N_m;                    ///< E2 = E t
    Eigen::VectorXd node_mass_kg;          ///< (8) (N)
    Eigen::VectorXd heuristic_a, heuristic_b;  ///< theta of (7) with E2 = E t and (C1 + C2) t [N/m] (S)

    Eigen::VectorXd one_set;               ///< the single set that serves all cases best [N/m] (S)

    std::vector<std::string> case_names;   ///< (C)
    NodeField contact_m, direction;        ///< of each case (C x D)
    Eigen::VectorXd magnitude_m;           ///< (C)
    NodeField contact_force_N;             ///< FE's, of the indenter on the tissue (C x D); 0 rows when the file has none
    NodeField node_weight;                 ///< Q of each case, one entry a node (C x N)
    std::vector<TrainedSets> trained;      ///< the study's optimiser first
    CertifiedOptimum optimum;
    ProblemRecord problems;

    int case_count() const { return static_cast<int>(case_names.size()); }
};

void write_model(const std::string& file, const TissueModel& model, const Provenance& provenance);

/// Throws FileError when the file is not a model, or its parts do not fit together.
TissueModel read_model(const std::string& file);

}  // namespace tissue
