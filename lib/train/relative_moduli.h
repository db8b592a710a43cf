#pragma once

#include <string>
#include <vector>

#include "cases/history.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Relative moduli g_k of Maxwell branches, fitted to measured displacement histories. F is the static force of the
/// model along a history; F_k is F through one branch with relaxation time tau_k alone. Norms are integrals over time.
/// Model with instantaneous moduli:
///   min sum over histories of |F_measured - F - sum_k g_k (F_k - F)|^2 / |F_measured|^2,   0 <= g_k <= 0.98
/// Model with long-term moduli, trained on measurements of tissue at rest:
///   min sum over histories of |F_measured - F - sum_k a_k F_k|^2 / |F_measured|^2,   0 <= a_k <= 49
///   g_k = a_k / (1 + sum a)
/// Its instantaneous moduli are then 1 + sum a times the long-term ones (`grown`).
/// Histories must be slow enough that inertia does not matter: half a second or more for each ramp. The problem is
/// convex and solved to rounding (train/bounded_lsq.h). Each branch has one relative modulus for the whole tissue,
/// which assumes that the tissue relaxes uniformly.
struct FittedModuli {
    Eigen::VectorXd share;     ///< g (K)
    double grown = 1;          ///< instantaneous moduli over the moduli of the model
    double kkt_residual = 0;   ///< of the optimum (train/bounded_lsq.h), before the scaling of `bounded`
    double misfit = 0;         ///< remaining relative rms error: root of the mean of the objective over the histories
    /// TrainStatus of the solve (train/optimizer.h). "bounded": the sum of the optimal g was above 0.98; they are
    /// scaled to that sum, and no longer optimal.
    std::string status;
};

/// model: has an energy model, whose own branches are ignored. role: of the histories that are fitted to; those without
/// force are left out. tau_s (K): relaxation times, ascending. threads: without influence on the result. long_term:
/// whether the model has long-term moduli. Throws MismatchError for a model without an energy model, without a history
/// to fit to, and where a history has a point without static equilibrium.
FittedModuli fit_relative_moduli(const TissueModel& model, const std::vector<History>& histories, const std::string& role, const Eigen::VectorXd& tau_s, int threads,
                        bool long_term = false);

/// Relaxation times [s] for histories of tissue with unknown ones, ascending. The last is the duration of the longest
/// history. The others descend in half decades and are not below twice the median time step. There are at most eight;
/// eight are spread evenly over that range on a logarithmic scale. Throws MismatchError without a history of that role.
Eigen::VectorXd time_ladder(const std::vector<History>& histories, const std::string& role);

}  // namespace tissue
