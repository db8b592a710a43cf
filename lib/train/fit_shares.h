#pragma once

#include <string>
#include <vector>

#include "cases/history.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Shares of branches that make a law's force over time that of measured histories: with F the static force of the instantaneous law
/// and F_k the same through a branch of the time tau_k alone,
///   min sum over histories of |F_measured - F - sum_k g_k (F_k - F)|^2 / |F_measured|^2,   0 <= g_k <= most_share
/// time weighed evenly. Of a law that is what is left after all time, trained on readings of tissue that had come to rest,
///   min sum |F_measured - F - sum_k a_k F_k|^2 / |F_measured|^2,   a_k >= 0,   g_k = a_k / (1 + sum a),
/// and the instantaneous law is 1 + sum a times it: `grown`. Histories must be so slow that mass does not matter, half a second a stroke. Convex, solved to rounding (train/bounded_lsq.h). One number a branch for the whole tissue, which is enough where
/// it relaxes alike everywhere.
struct FittedShares {
    Eigen::VectorXd share;     ///< g (K)
    double grown = 1;          ///< of the law, to be the instantaneous one
    double kkt_residual = 0;   ///< of the optimum (train/certificate.h), before what `bounded` says
    double misfit = 0;         ///< root of the objective's mean over the histories: relative rms error that is left
    std::string status;        ///< of the solve, TrainStatus (train/optimizer.h); `bounded`: the optimum's shares sum to more than most_share,
                               ///< and are scaled to that sum, no optimum any more
};

/// Histories of `role` that are not lost. tau_s (K), ascending. model: with a law, whose own branches do not count.
/// Throws MismatchError without one, without a history, and where the law has no static answer on its way.
FittedShares fit_shares(const TissueModel& model, const std::vector<History>& histories, const std::string& role, const Eigen::VectorXd& tau_s, int threads,
                        bool long_term = false);

/// Times of branches for histories whose own nobody knows: half decades from twice their median step to the longest of them, eight at the most.
Eigen::VectorXd time_ladder(const std::vector<History>& histories, const std::string& role);

}  // namespace tissue
