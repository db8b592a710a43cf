#include "springs/spring_sets.h"

#include <fmt/format.h>

#include "error.h"

namespace tissue {

const NodeField& sets_of(const TissueModel& model, const std::string& optimizer) {
    if (optimizer == "optimum") return model.optimum;
    std::string known;
    for (const SpringSets& t : model.trained) {
        if (optimizer.empty() || t.optimizer == optimizer) return t.theta;
        known += t.optimizer + ", ";
    }
    throw MismatchError(fmt::format("spring sets '{}' are not in the model; it has {}optimum", optimizer, known));
}

std::vector<NamedSet> spring_sets(const TissueModel& model, const std::string& optimizer, const std::string& set) {
    const NodeField& theta = sets_of(model, optimizer);
    if (set == "one_set") return {{set, -1, model.one_set}};
    if (set == "heuristic_a") return {{set, -1, model.heuristic_a}};
    if (set == "heuristic_b") return {{set, -1, model.heuristic_b}};
    std::vector<NamedSet> sets;
    for (int c = 0; c < model.case_count(); ++c) {
        const std::string& name = model.case_names[static_cast<std::size_t>(c)];
        if (set.empty() || name == set) sets.push_back({name, c, theta.row(c).transpose()});
    }
    if (sets.empty())
        throw MismatchError(
            fmt::format("spring set '{}' is not in the model; it has one_set, heuristic_a, heuristic_b "
                        "and one per load case, such as {}",
                        set, model.case_count() > 0 ? model.case_names.front() : "none"));
    return sets;
}

}  // namespace tissue
