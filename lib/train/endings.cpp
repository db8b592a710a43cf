#include "train/endings.h"

#include <fmt/format.h>

#include <map>

#include "train/nonlinear_fit.h"

namespace tissue {
namespace {

constexpr double near_enough = 1e-3;  // SpsaOptions::gap_tolerance, the convergence criterion of spsa

/// Counts of each status for the sets c where fine(c) is false: "3 stalled, 2 iterations_done", or "".
template <class Fine>
std::string counted(const std::vector<std::string>& status, const Fine& fine) {
    std::map<std::string, int> counts;
    for (std::size_t c = 0; c < status.size(); ++c)
        if (!fine(c)) ++counts[status[c]];
    std::string text;
    for (const auto& [word, count] : counts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, word);
    return text;
}

}  // namespace

Endings endings_of(const ProblemRecord& problems, const std::vector<SetDiagnostics>& trained, const OptimumCertificate& optimum) {
    Endings e;
    const auto say = [](std::vector<std::string>& lines, const std::string& what, const std::string& text, std::size_t of) {
        if (!text.empty()) lines.push_back(fmt::format("{}: of {} sets {}", what, of, text));
    };
    say(e.broken, "objective " + problems.objective,
        counted(problems.status, [&](std::size_t c) { return problems.status[c] == "posed"; }), problems.status.size());
    if (!problems.one_set_status.empty() && problems.one_set_status != "posed")
        e.broken.push_back("objective " + problems.objective + ": the single set for all cases " + problems.one_set_status);
    say(e.broken, "certified optimum",
        counted(optimum.status, [&](std::size_t c) { return optimum.status[c] == "converged"; }), optimum.status.size());
    for (const SetDiagnostics& t : trained) {
        const auto stalled = [&](std::size_t c) {
            return t.status[c] == "stalled" && !(t.gap[static_cast<Eigen::Index>(c)] <= near_enough);
        };
        say(e.broken, t.optimizer, counted(t.status, [&](std::size_t c) { return !stalled(c); }), t.status.size());
        say(e.other, t.optimizer,
            counted(t.status, [&](std::size_t c) { return stalled(c) || t.status[c] == "converged"; }), t.status.size());
    }
    return e;
}

Endings endings_of(const EnergyModelDiagnostics& diagnostics) {
    Endings e;
    const std::string& status = diagnostics.status.at(static_cast<std::size_t>(diagnostics.kept));
    if (status == to_string(FitStatus::no_progress) || status == to_string(FitStatus::held_back) || status == to_string(FitStatus::iterations_done))
        e.broken.push_back(fmt::format("energy model: {} after {} iterations, largest derivative {:.1e}", status,
                                       diagnostics.iterations.at(static_cast<std::size_t>(diagnostics.kept)), diagnostics.gradient[diagnostics.kept]));
    if (!diagnostics.lost.empty())
        e.broken.push_back(fmt::format("energy model: of {} load cases {} have no equilibrium", diagnostics.records, diagnostics.lost.size()));
    return e;
}

Endings endings_of(const TrainingDiagnostics& books) {
    return books.energy_model ? endings_of(*books.energy_model) : endings_of(books.problems, books.trained, books.optimum);
}

}  // namespace tissue
