#include "train/relative_moduli.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "error.h"
#include "parallel.h"
#include "springs/indentation_solver.h"
#include "train/bounded_lsq.h"
#include "train/certificate.h"

namespace tissue {
namespace {

constexpr double most_share = 0.98;  ///< of one branch and of their sum, so that the long-term modulus stays positive

}  // namespace

FittedModuli fit_relative_moduli(const TissueModel& model, const std::vector<History>& histories, const std::string& role, const Eigen::VectorXd& tau_s, int threads,
                        bool long_term) {
    if (!model.energy_model) throw MismatchError("displacement histories need an energy model; this model has spring sets");
    std::vector<const History*> used;
    for (const History& h : histories)
        if (h.role == role && h.lost.empty() && h.force_N.squaredNorm() > 0) used.push_back(&h);
    if (used.empty()) throw MismatchError("there is no displacement history to fit relative moduli to");
    TissueModel at_once = model;
    at_once.energy_model = instantaneous(*model.energy_model);
    const IndentationSolver solver(at_once);
    std::vector<NodeField> now(used.size());
    std::vector<std::string> lost(used.size());
    parallel_for(static_cast<int>(used.size()), threads, [&](int i) {
        const auto k = static_cast<std::size_t>(i);
        const History& h = *used[k];
        now[k] = NodeField::Zero(h.force_N.rows(), h.force_N.cols());
        for (Eigen::Index n = 0; n < now[k].rows() && lost[k].empty(); ++n) {
            if (h.contact[static_cast<std::size_t>(n)] == 0 || h.push_m.row(n).squaredNorm() == 0) continue;
            if (n > 0 && h.contact[static_cast<std::size_t>(n)] == h.contact[static_cast<std::size_t>(n - 1)] && h.push_m.row(n) == h.push_m.row(n - 1)) {
                now[k].row(n) = now[k].row(n - 1);  // same displacement, same equilibrium
                continue;
            }
            const Point& at = h.contact[static_cast<std::size_t>(n)] == 2 ? *h.second_contact_m : h.contact_m;
            const Equilibrium answer = solver.at(at, h.push_m.row(n).transpose());
            if (answer)
                now[k].row(n) = answer.contact_force.transpose();
            else
                lost[k] = fmt::format("history '{}' at {:g} s: {}", h.name, h.time_s[n], reason_of(answer.status));
        }
    });
    for (const std::string& why : lost)
        if (!why.empty()) throw MismatchError(why);

    const Eigen::Index K = tau_s.size();
    Eigen::Index rows = 0;
    for (const History* h : used) rows += h->force_N.size();
    Eigen::MatrixXd A(rows, K);
    Eigen::VectorXd wanted(rows), weight(rows);
    Eigen::Index at = 0;
    for (std::size_t i = 0; i < used.size(); ++i) {
        const History& h = *used[i];
        const Eigen::Index T = h.force_N.rows(), D = h.force_N.cols(), n = T * D;
        const NodeField off = h.force_N - now[i];
        wanted.segment(at, n) = Eigen::Map<const Eigen::VectorXd>(off.data(), n);
        for (Eigen::Index k = 0; k < K; ++k) {
            NodeField column = relaxed(h.time_s, now[i], tau_s.segment(k, 1), Eigen::VectorXd::Ones(1));
            if (!long_term) column -= now[i];
            A.col(k).segment(at, n) = Eigen::Map<const Eigen::VectorXd>(column.data(), n);
        }
        for (Eigen::Index t = 0; t < T; ++t) {
            const double span = ((t + 1 < T ? h.time_s[t + 1] : h.time_s[t]) - (t > 0 ? h.time_s[t - 1] : h.time_s[t])) / 2;
            weight.segment(at + t * D, D).setConstant(span);
        }
        const double square = weight.segment(at, n).dot(Eigen::Map<const Eigen::VectorXd>(h.force_N.data(), n).cwiseAbs2());
        weight.segment(at, n) /= square * static_cast<double>(used.size());
        at += n;
    }
    const ForceLoss loss(A.sparseView(0, 0), wanted, weight);
    const Box box{Eigen::VectorXd::Zero(K), Eigen::VectorXd::Constant(K, long_term ? most_share / (1 - most_share) : most_share)};
    const BoundedLsqSummary best = solve_bounded_lsq(loss, Eigen::VectorXd::Constant(K, 0.5 / static_cast<double>(K)), box);
    FittedModuli fitted{best.theta, 1, best.kkt_residual, best.residual_norm, to_string(train_status(best.status))};
    if (long_term) {
        fitted.grown = 1 + best.theta.sum();
        fitted.share = best.theta / fitted.grown;
        return fitted;
    }
    if (const double sum = fitted.share.sum(); sum > most_share) {  // the optimum is a tissue that flows
        fitted.share *= most_share / sum;
        fitted.misfit = loss(fitted.share);
        fitted.status = "bounded";
    }
    return fitted;
}

Eigen::VectorXd time_ladder(const std::vector<History>& histories, const std::string& role) {
    std::vector<double> steps;
    double longest_s = 0;
    for (const History& h : histories) {
        if (h.role != role) continue;
        for (Eigen::Index n = 1; n < h.time_s.size(); ++n) steps.push_back(h.time_s[n] - h.time_s[n - 1]);
        longest_s = std::max(longest_s, h.time_s[h.time_s.size() - 1]);
    }
    if (steps.empty()) throw MismatchError("there is no displacement history from which to take relaxation times");
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
    const double first_s = std::min(2 * steps[steps.size() / 2], longest_s), decades = std::log10(longest_s / first_s);
    const auto count = static_cast<Eigen::Index>(std::clamp(std::floor(2 * decades + 1e-9) + 1, 1.0, 8.0));
    Eigen::VectorXd tau_s(count);
    for (Eigen::Index k = 0; k < count; ++k) tau_s[k] = longest_s * std::pow(10, -(static_cast<double>(count - 1 - k)) * (count == 8 ? decades / 7 : 0.5));
    return tau_s;
}

}  // namespace tissue
