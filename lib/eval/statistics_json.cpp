#include "eval/statistics_json.h"

namespace tissue {

using Json = nlohmann::ordered_json;

Json to_value(const Statistics& s) {
    const auto or_null = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
    return {{"median", or_null(s.median)}, {"p95", or_null(s.p95)}, {"max", or_null(s.max)}, {"n", s.n},
            {"of", s.of()}, {"missing", s.missing}, {"no_reference", s.no_reference}};
}

Json to_value(const ContactStatistics& s, bool seen_inside) {
    Json entry = to_value(s.force);
    if (!s.reasons.empty()) entry["reason"] = s.reasons;
    if (!seen_inside) return entry;
    const bool force_alone = s.force.n > 0 && s.shape.n + s.shape.missing == 0;
    entry["shape"] = force_alone ? Json() : to_value(s.shape);
    entry["shape_max_over_depth"] = force_alone ? Json() : to_value(s.shape_max_over_depth);
    return entry;
}

}  // namespace tissue
