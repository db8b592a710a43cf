#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "haptic/simulation.h"

namespace tissue::cli {

/// Options of the realtime core that `tissue-haptic` and `tissuectl serve` share.
struct HapticChoices {
    std::string select_by = "displacement";
    bool no_heuristic = false, no_passivity = false, no_realtime = false;
    HapticOptions haptic;     ///< whole after settle()
};

void add_haptic_options(CLI::App& app, HapticChoices& choices);

/// After parsing: names and flags into `haptic`. Throws CLI::ValidationError for numbers that no model takes (check_options).
void settle(HapticChoices& choices);

/// A number with its unit, its default and its meaning.
CLI::Option* add_number(CLI::App& app, const char* name, double& value, const char* unit, const char* meaning);

/// A check whose own words stay out of the help's column of units.
CLI::Validator quiet(CLI::Validator check);

}  // namespace tissue::cli
