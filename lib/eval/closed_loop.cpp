#include "eval/closed_loop.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>

#include "eval/force_error.h"
#include "springs/heuristic.h"

namespace tissue {

std::optional<double> closed_loop_error(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                                        const ContactTruth& truth, EquilibriumStatus& status) {
    const Equilibrium state = solve_equilibrium(mesh, law, theta, truth.contact, truth.push_m);
    status = state.status;
    return closed_loop_error(state, truth);
}

std::optional<double> closed_loop_error(const Equilibrium& answer, const ContactTruth& truth) {
    if (!answer) return std::nullopt;
    return (answer.contact_force - truth.force_N).norm() / truth.force_N.norm();
}

std::string reasons_of(const std::vector<EquilibriumStatus>& statuses) {
    std::map<EquilibriumStatus, int> count;
    for (EquilibriumStatus s : statuses)
        if (s != EquilibriumStatus::balanced) ++count[s];
    std::string text;
    for (const auto& [status, n] : count) text += fmt::format("{}{} ({})", text.empty() ? "" : "; ", reason_of(status), n);
    return text;
}

std::optional<double> best_uniform_stiffness(const SpringMesh& mesh, const SpringLaw& law,
                                             const std::vector<ContactTruth>& truths, double low_N_m, double high_N_m) {
    // Every law is linear in theta, so the mesh's equilibrium does not depend on a common factor and its force is
    // proportional to it: one solve a contact serves every candidate.
    std::vector<Eigen::VectorXd> unit_forces, fe_forces;
    const Eigen::VectorXd unit = uniform_stiffness(mesh, 1.0);
    for (const ContactTruth& truth : truths) {
        const Equilibrium state = solve_equilibrium(mesh, law, unit, truth.contact, truth.push_m);
        if (!state) continue;
        unit_forces.push_back(state.contact_force);
        fe_forces.push_back(truth.force_N);
    }
    if (2 * fe_forces.size() < truths.size() || fe_forces.empty()) return std::nullopt;
    double best = low_N_m, best_median = std::numeric_limits<double>::infinity();
    for (double k = low_N_m; k <= high_N_m; k *= 1.01) {
        std::vector<double> errors;
        for (std::size_t i = 0; i < fe_forces.size(); ++i)
            errors.push_back((k * unit_forces[i] - fe_forces[i]).norm() / fe_forces[i].norm());
        const double median = statistics_of(errors).median;
        if (median < best_median) {
            best_median = median;
            best = k;
        }
    }
    return best;
}

}  // namespace tissue
