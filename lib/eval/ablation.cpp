#include "eval/ablation.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "cases/sweep.h"
#include "train/endings.h"
#include "train/train_sets.h"
#include "version.h"

namespace tissue {

std::vector<VariantResult> ablate(const Study& study, const Cases& cases, int threads,
                                  const std::function<void(int, int, const std::string&)>& progress) {
    std::vector<Study::Variant> variants = {{study.name, study.springs.topology, study.springs.law,
                                             study.training.objective, study.training.ridge,
                                             study.loads.sweep->spacing_m, study.loads.sweep->angles_deg,
                                             study.loads.magnitudes_m}};
    variants.insert(variants.end(), study.variants.begin(), study.variants.end());
    std::vector<VariantResult> results;
    for (const Study::Variant& v : variants) {
        Study changed = study;
        changed.springs.topology = v.topology;
        changed.springs.law = v.law;
        changed.training.objective = v.objective;
        changed.training.ridge = v.ridge;
        changed.loads.magnitudes_m = v.magnitudes_m;
        const Cases kept = thinned(study, cases, v);
        VariantResult result{v, 0, 0, 0, {}, {}};
        for (const LoadPath& path : kept.paths)
            if (path.role == "train" && path.name.find("-mirror") == std::string::npos) ++result.fe_paths;
        const auto start = std::chrono::steady_clock::now();
        const TrainedModel model = train_sets(changed, kept, threads);
        result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        result.sets = model.case_count();
        result.broken = endings_of(model.books).broken;
        result.held_out = evaluate_held_out(model, kept, threads, false);
        results.push_back(std::move(result));
        if (progress) progress(static_cast<int>(results.size()), static_cast<int>(variants.size()), v.name);
    }
    return results;
}

std::string to_json(const std::vector<VariantResult>& results) {
    nlohmann::ordered_json j;
    j["version"] = version;
    j["format_version"] = format_version;
    for (const VariantResult& r : results) {
        nlohmann::ordered_json row = {{"name", r.variant.name},           {"topology", r.variant.topology},
                                      {"law", r.variant.law},             {"objective", r.variant.objective},
                                      {"ridge", r.variant.ridge},         {"spacing_m", r.variant.spacing_m},
                                      {"angles_deg", r.variant.angles_deg}, {"magnitudes_m", r.variant.magnitudes_m},
                                      {"fe_paths", r.fe_paths},           {"sets", r.sets},
                                      {"seconds", r.seconds}};
        if (!r.broken.empty()) row["broken"] = r.broken;
        for (const DrawnContacts& role : r.held_out.roles)
            for (std::size_t m = 0; m < r.held_out.models.size(); ++m) {
                const Statistics s = role.statistics(m).force;
                if (s.n > 0)
                    row[role.role][r.held_out.models[m]] = {{"median", s.median}, {"p95", s.p95}, {"max", s.max}, {"n", s.n}};
            }
        j["variants"].push_back(std::move(row));
    }
    return j.dump(1) + "\n";
}

}  // namespace tissue
