#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "springs/disc_sizes.h"
#include "springs/disc_tables.h"
#include "springs/energy_model_terms.h"
#include "springs/equilibrium_solver.h"
#include "train/nonlinear_fit.h"

namespace tissue {

/// Training data of one load path: a contact, with FE reference or measurement at each tool displacement.
struct IndentationPath {
    std::string name;
    Point contact_m;              ///< (D)
    double radius_m = 0;          ///< of the disc; 0: EnergyModelTrainingOptions::disc_radius_m
    struct Record {
        Point push_m, force_N;    ///< tool displacement; force of the tool on the tissue (D)
        NodeField displacement;   ///< u [m] (N x D); empty where only the force is known (measured contacts)
    };
    std::vector<Record> records;  ///< by ascending tool displacement
};

/// The training paths of the cases, with a record at each of their load_magnitudes. A path that ends early in FE gives
/// the records before its end; a path without any record is left out.
std::vector<IndentationPath> indentation_paths(const Cases& cases);

struct EnergyModelTrainingOptions {
    double force_scale = 0.01;    ///< relative force error with residual 1: 1 % of |F|
    double shape_scale = 0.03;    ///< relative displacement error with residual 1: 3 % of the rms displacement
    double ridge = 0.1;           ///< a coefficient of 10 (a factor of 22,000) has residual 1
    std::vector<int> compared;        ///< nodes whose displacement is compared; empty: all
    double disc_radius_m = 0;     ///< radius of the model's disc, in space
    Eigen::Vector2d curved_range{-INFINITY, INFINITY};  ///< DiscTables::curved_range
    FacetTable correction;        ///< lattice correction for that disc (DiscTables::correction)
    DiscSizes sizes;              ///< other disc radii of the paths, with their corrections
    int starts = 1;               ///< number of starts: one from `first`, the others drawn around the heuristic
    Eigen::VectorXd first;        ///< coefficients of the first start (P); empty: the heuristic (all 0)
    double spread = 0.5;          ///< standard deviation of the coefficients of a drawn start
    unsigned long seed = 1;
    FitOptions fit;
    SolverOptions equilibrium;
    int threads = 1;
};

/// Common factor of all constants of an untrained energy model (coefficients 0) that minimises the sum of squared
/// relative force errors over the paths. Forces are proportional to the factor; displacements do not depend on it. A
/// record without convergence, and the deeper records of its path, are left out. Throws MismatchError when no record
/// with a force remains.
double heuristic_factor(const SpringMesh& mesh, const EnergyModelTerms& model_terms, const std::vector<IndentationPath>& paths,
                        const EnergyModelTrainingOptions& options = {});

/// Result of the training of an energy model.
struct TrainedEnergyModel {
    Eigen::VectorXd coefficients;          ///< (P)
    double objective = 0;                  ///< at the coefficients, ridge included (train_energy_model)
    std::vector<FitResult> starts;         ///< result of each start
    std::size_t kept = 0;                  ///< index of the start that gives the coefficients
    std::vector<std::string> lost;         ///< "path at 10 mm: lost at 7.5 mm": records not converged at the end
    double seconds = 0;
};

/// Fits the coefficients p of an energy model to indentation errors. For every record the tool displacement is
/// prescribed, the mesh is in equilibrium, and force and displacement are compared with the FE reference. Objective:
///   mean over records of |F_model - F|^2 / (force_scale |F|)^2 + |u_model - u|^2 / (shape_scale |u|)^2
///   + |ridge p|^2
/// The second term is left out where u is not known. u has the nodes of options.compared, with the skin (springs/skin.h).
/// Derivatives of the equilibrium are implicit (EquilibriumSolver::derivative). A record without equilibrium (`lost`) counts
/// as if force and displacement of the model were 0. The fit accepts no step that loses a record (nonlinear_fit). Of
/// several starts the one with the fewest lost records is kept, then the one with the smallest objective. Parallel over
/// paths; the result does not depend on the number of threads.
/// Throws MismatchError without paths or without terms.
TrainedEnergyModel train_energy_model(const SpringMesh& mesh, const EnergyModelTerms& model_terms, const std::vector<IndentationPath>& paths,
                     const EnergyModelTrainingOptions& options = {});

/// Last equilibrium of every record (paths x records). In space the next evaluation starts from it, because solving
/// from rest would be most of the training time. Empty before the first evaluation.
using PathEquilibria = std::vector<std::vector<EquilibriumState>>;

/// Residuals f of that objective, which is their sum of squares, and their derivative J by the coefficients p.
/// Rows: for each record the force (D), then the displacement where known (D * compared nodes); at the end the ridge (P).
/// lost: appends a line for each record that has not converged. rests: starts of the equilibrium solves, updated. gone: 1
/// for each record without an equilibrium, else 0.
void energy_model_residuals(const SpringMesh& mesh, const EnergyModelTerms& model_terms, const std::vector<IndentationPath>& paths,
                   const EnergyModelTrainingOptions& options, const Eigen::VectorXd& p, Eigen::Ref<Eigen::VectorXd> f,
                   Eigen::Ref<RowMatrix> J, std::vector<std::string>* lost = nullptr,
                   PathEquilibria* rests = nullptr, std::vector<char>* gone = nullptr);
int energy_model_residual_count(const EnergyModelTerms& model_terms, const std::vector<IndentationPath>& paths, const EnergyModelTrainingOptions& options);

}  // namespace tissue
