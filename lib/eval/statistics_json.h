#pragma once

#include <nlohmann/json.hpp>

#include "eval/closed_loop.h"
#include "eval/statistics.h"

namespace tissue {

/// {"median", "p95", "max", "n", "of", "missing", "no_reference"}. JSON has no infinity: a quantile that is infinite is null, and `missing` is
/// then above 0; one of nothing is null, and n and `missing` are 0.
nlohmann::ordered_json to_value(const Statistics& s);

/// The same of the force, with the reasons of those missing, and inside it `shape` and `shape_max_over_depth`. Both are null for a model that says a
/// force alone, and absent where nobody saw the tissue's inside.
nlohmann::ordered_json to_value(const ContactStatistics& s, bool seen_inside);

}  // namespace tissue
