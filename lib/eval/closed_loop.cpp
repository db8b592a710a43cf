#include "eval/closed_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/free_surface.h"
#include "springs/heuristic.h"

namespace tissue {

ContactError error_of(const ContactAnswer& answer, const ContactReference& reference, const SpringMesh& mesh) {
    return error_of(answer, reference, mesh, compared_nodes(mesh));
}

ContactError error_of(const ContactAnswer& answer, const ContactReference& reference, const SpringMesh& mesh, const std::vector<int>& compared) {
    constexpr double missing = std::numeric_limits<double>::infinity();
    ContactError error{{}, {}, {}, answer.reason};
    const bool answered = answer.force_N && answer.force_N->allFinite() && answer.displacement_m.allFinite();
    if (answer.force_N && !answered) error.reason = "the result is not finite";
    if (reference.force_N.squaredNorm() > 0)
        error.force = answered ? (*answer.force_N - reference.force_N).norm() / reference.force_N.norm() : missing;
    else
        error.reason = "the reference force is zero";
    if (!answered) {
        if (reference.displacement_m.size() > 0) error.shape = error.shape_max_over_depth = missing;
        return error;
    }
    if (answer.displacement_m.size() == 0 || reference.displacement_m.size() == 0) return error;
    double off = 0, moved = 0, farthest = 0;  // squares
    for (int i : compared) {
        if (std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), i)) continue;
        const double here = (answer.displacement_m.row(i) - reference.displacement_m.row(i)).squaredNorm();
        off += here;
        moved += reference.displacement_m.row(i).squaredNorm();
        farthest = std::max(farthest, here);
    }
    if (moved > 0) error.shape = std::sqrt(off / moved);
    error.shape_max_over_depth = std::sqrt(farthest) / reference.push_m.norm();
    return error;
}

ContactAnswer answer_of(const SpringMesh& mesh, const SpringLaw& law, const Eigen::VectorXd& theta,
                        const ContactReference& reference) {
    return answer_of(solve_equilibrium(mesh, law, theta, reference.contact, reference.push_m));
}

ContactAnswer answer_of(const Equilibrium& state) {
    if (!state) return {{}, {}, reason_of(state.status)};
    return {state.contact_force, state.displacement, {}};
}

ContactAnswer answer_of(const IndentationSolver& solver, const Point& contact_m, const Point& push_m, double radius_m) {
    const IndentationSolver* of_radius = nullptr;
    try {
        of_radius = &solver.of(radius_m);
    } catch (const MismatchError& unknown_disc) {
        return {{}, {}, unknown_disc.what()};
    }
    ContactAnswer answer = answer_of(of_radius->at(contact_m, push_m));
    if (answer.force_N) answer.displacement_m = of_radius->displayed(contact_m, push_m, std::move(answer.displacement_m));
    return answer;
}

ContactAnswer answer_of(const BallIndentation& ball, const Point& contact_m, const Point& push_m) {
    try {
        return answer_of(ball.at(contact_m, push_m));
    } catch (const ContactTooLargeError& too_deep) {
        return {{}, {}, too_deep.what()};
    }
}

ContactStatistics contact_statistics(const std::vector<ContactError>& errors, int lost) {
    constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> force, shape, farthest;
    std::vector<std::pair<std::string, int>> reasons;  // in order of first occurrence
    for (const ContactError& e : errors) {
        force.push_back(e.force.value_or(nothing));
        shape.push_back(e.shape.value_or(nothing));
        farthest.push_back(e.shape_max_over_depth.value_or(nothing));
        if (e.reason.empty()) continue;
        const auto same = [&](const auto& known) { return known.first == e.reason; };
        if (const auto known = std::find_if(reasons.begin(), reasons.end(), same); known != reasons.end())
            ++known->second;
        else
            reasons.emplace_back(e.reason, 1);
    }
    std::string text;
    for (const auto& [reason, n] : reasons) text += fmt::format("{}{} ({})", text.empty() ? "" : "; ", reason, n);
    return {statistics_of(force, lost), statistics_of(shape, lost), statistics_of(farthest, lost), text};
}

std::optional<double> best_uniform_stiffness(const SpringMesh& mesh, const SpringLaw& law,
                                             const std::vector<ContactReference>& references, double low_N_m, double high_N_m) {
    // Spring forces are linear in theta. A common factor of theta scales the contact force and does not change the
    // equilibrium displacement, so one solve for each contact serves every candidate.
    std::vector<Eigen::VectorXd> unit_forces, fe_forces;  // empty where there is no equilibrium
    const Eigen::VectorXd unit = uniform_stiffness(mesh, 1.0);
    for (const ContactReference& reference : references) {
        if (reference.force_N.squaredNorm() == 0) continue;  // no relative error is defined
        const Equilibrium state = solve_equilibrium(mesh, law, unit, reference.contact, reference.push_m);
        unit_forces.push_back(state ? state.contact_force : Eigen::VectorXd());
        fe_forces.push_back(reference.force_N);
    }
    std::optional<double> best;
    double best_median = std::numeric_limits<double>::infinity();
    for (double k = low_N_m; k <= high_N_m; k *= 1.01) {
        std::vector<double> errors;
        for (std::size_t i = 0; i < fe_forces.size(); ++i)
            errors.push_back(unit_forces[i].size() > 0 ? (k * unit_forces[i] - fe_forces[i]).norm() / fe_forces[i].norm()
                                                       : std::numeric_limits<double>::infinity());
        const double median = statistics_of(errors).median;
        if (median < best_median) {
            best_median = median;
            best = k;
        }
    }
    return best;
}

}  // namespace tissue
