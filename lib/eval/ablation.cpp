#include "eval/ablation.h"

#include <nlohmann/json.hpp>

#include "cases/sweep.h"
#include "eval/statistics_json.h"
#include "train/endings.h"
#include "train/train_study_model.h"
#include "version.h"

namespace tissue {

using Json = nlohmann::ordered_json;

std::vector<VariantResult> ablate(const Study& study, const Cases& cases, int threads,
                                  const std::function<void(int, int, const std::string&)>& progress) {
    std::vector<Study::Variant> variants = {study.whole()};
    variants.insert(variants.end(), study.variants.begin(), study.variants.end());
    std::vector<VariantResult> results;
    for (const Study::Variant& v : variants) {
        Study changed = study;
        changed.springs.terms = v.terms;
        changed.springs.area_cap_E2 = v.area_cap_E2;
        changed.training.shape_scale = v.shape_scale;
        changed.loads.magnitudes_m = v.magnitudes_m;
        const Cases kept = thinned(study, cases, v);
        const TrainedModel model = train_study_model(changed, kept, threads);
        const EnergyModelDiagnostics& diagnostics = *model.books.energy_model;
        VariantResult result{v, diagnostics.paths, diagnostics.records, diagnostics.seconds, diagnostics.objective, endings_of(model.books).broken, {}, !kept.measurement};
        result.held_out = evaluate_held_out(model, kept, threads, false);
        results.push_back(std::move(result));
        if (progress) progress(static_cast<int>(results.size()), static_cast<int>(variants.size()), v.name);
    }
    return results;
}

std::string to_json(const std::vector<VariantResult>& results) {
    Json j;
    j["version"] = version;
    j["format_version"] = format_version;
    for (const VariantResult& r : results) {
        Json row = {{"name", r.variant.name},
                                      {"terms", r.variant.terms},
                                      {"area_cap_E2", r.variant.area_cap_E2},
                                      {"shape_scale", r.variant.shape_scale},
                                      {"arcs_m", r.variant.arcs_m},
                                      {"angles_deg", r.variant.angles_deg},
                                      {"magnitudes_m", r.variant.magnitudes_m},
                                      {"numbers", r.variant.terms.size()},
                                      {"fe_paths", r.fe_paths},
                                      {"records", r.records},
                                      {"seconds", r.seconds},
                                      {"objective", r.objective}};
        if (!r.broken.empty()) row["broken"] = r.broken;
        for (const DrawnContacts& role : r.held_out.roles)
            for (std::size_t m = 0; m < r.held_out.models.size(); ++m) row[role.role][r.held_out.models[m]] = to_value(role.statistics(m), r.seen_inside);
        j["variants"].push_back(std::move(row));
    }
    return j.dump(1) + "\n";
}

}  // namespace tissue
