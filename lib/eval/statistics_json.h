#pragma once

#include <nlohmann/json.hpp>

#include "eval/closed_loop.h"
#include "eval/statistics.h"

namespace tissue {

/// {"median", "p95", "max", "n", "of", "missing", "no_reference"}. JSON has no infinity: an infinite quantile is null,
/// and `missing` is then above 0. Without any error the quantiles are null too, and n and `missing` are 0.
nlohmann::ordered_json to_value(const Statistics& s);

/// The same for the force error, with the reasons of missing answers, and with the members `shape` and
/// `shape_max_over_depth`. Both are null for a model that predicts only a force. seen_inside: whether the reference has
/// displacements; false leaves both out.
nlohmann::ordered_json to_value(const ContactStatistics& s, bool seen_inside);

}  // namespace tissue
