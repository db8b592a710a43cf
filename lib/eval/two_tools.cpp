#include "eval/two_tools.h"

#include <algorithm>

#include "error.h"
#include "mesh/free_surface.h"
#include "parallel.h"
#include "springs/indentation_solver.h"

namespace tissue {
namespace {

/// Equilibrium with both tools at once: an answer for each. There is no answer for discs that overlap, or whose radius
/// is outside the range of the training.
std::array<ContactAnswer, 2> together(const IndentationSolver& solver, const IndentationPair& pair) {
    const auto none = [](const std::string& reason) { return std::array<ContactAnswer, 2>{ContactAnswer{{}, {}, reason}, ContactAnswer{{}, {}, reason}}; };
    try {
        const ToolsEquilibrium rest = solver.of(pair.radius_m).at({{pair.contact_m[0], pair.push_m[0]}, {pair.contact_m[1], pair.push_m[1]}});
        if (!rest) return none(reason_of(rest.status));
        return {ContactAnswer{rest.contact_force[0]}, ContactAnswer{rest.contact_force[1]}};
    } catch (const MismatchError& refused) {
        return none(refused.what());
    }
}

std::array<ContactAnswer, 2> one_by_one(const IndentationSolver& solver, const IndentationPair& pair) {
    std::array<ContactAnswer, 2> answers;
    for (std::size_t t = 0; t < 2; ++t) answers[t] = answer_of(solver, pair.contact_m[t], pair.push_m[t], pair.radius_m);
    for (ContactAnswer& answer : answers) answer.displacement_m.resize(0, 0);  // only forces are compared
    return answers;
}

}  // namespace

ContactStatistics IndentationPairs::statistics(std::size_t model) const {
    std::vector<ContactError> errors;
    for (const IndentationPair& pair : pairs) errors.insert(errors.end(), pair.error[model].begin(), pair.error[model].end());
    return contact_statistics(errors, 2 * static_cast<int>(lost.size()));
}

TwoTools evaluate_two_tools(const TrainedModel& model, const Cases& cases, int threads) {
    TwoTools result;
    if (!model.energy_model) return result;
    for (const LoadPath& path : cases.paths) {
        if (!path.second) continue;
        auto role = std::find_if(result.roles.begin(), result.roles.end(), [&](const IndentationPairs& r) { return r.role == path.role; });
        if (role == result.roles.end()) role = result.roles.insert(role, {path.role, {}, {}});
        if (!path.lost.empty()) {
            role->lost.push_back(path.name + ": " + path.lost);
            continue;
        }
        const PathRecord& record = path.records.back();
        role->pairs.push_back({path.name, {path.contact_m, path.second->contact_m}, {path.push_m(record), path.second_push_m(record)},
                               {record.contact_force_N, record.second_force_N}, path.radius_m > 0 ? path.radius_m : model.energy_model->disc_radius_m});
    }
    if (result.empty()) return result;
    result.models = {"learned", "alone"};
    const IndentationSolver solver(model.mesh, energy_model_of_cases(model));
    const std::vector<int> compared = compared_nodes(model.mesh);
    for (IndentationPairs& role : result.roles)
        parallel_for(static_cast<int>(role.pairs.size()), threads, [&](int i) {
            IndentationPair& pair = role.pairs[static_cast<std::size_t>(i)];
            for (const auto& answers : {together(solver, pair), one_by_one(solver, pair)}) {
                std::array<ContactError, 2>& error = pair.error.emplace_back();
                for (std::size_t t = 0; t < 2; ++t) error[t] = error_of(answers[t], ContactReference{{}, pair.push_m[t], pair.fe_force_N[t]}, model.mesh, compared);
            }
        });
    return result;
}

}  // namespace tissue
