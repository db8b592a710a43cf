#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptic/session_options.h"

namespace tissue::cli {

/// Options of `tissue-haptic` and `tissuectl serve`: the rows of session_options(), and how the loop runs.
struct HapticChoices {
    HapticOptions haptic;
    bool no_realtime = false;
    /// values of the second tool that differ from the first's, as they were typed
    std::vector<std::pair<const SessionOption*, std::string>> of_second;

    void press_with(int tools);  ///< sets the number of tools; with two there is no heuristic mesh
    HapticOptions second() const;
};

/// Adds the rows of `program`. Values are checked as they are read.
void add_haptic_options(CLI::App& app, Where program, HapticChoices& choices);

/// Adds --second-NAME for the rows that may differ between tools. `needed`: the option without which they are refused.
void add_second_options(CLI::App& app, Where program, CLI::Option* needed, HapticChoices& choices);

/// The group of these options in the help.
inline const char* const second_tool = "Second tool: each as the option without second-, yes or no in place of a flag";

/// Call after parsing. Throws CLI::ValidationError for numbers that are out of range for every model (check_options).
void check(const HapticChoices& choices);

/// The text of lib/api/OPTIONS.md.
std::string options_page();

/// Adds an option that is a number, with its unit, default and meaning.
CLI::Option* add_number(CLI::App& app, const char* name, double& value, const char* unit, const char* meaning);
/// without a default
CLI::Option* add_number(CLI::App& app, const char* name, std::optional<double>& value, const char* unit, const char* meaning);

/// Removes a check's description, which the help would print in the column of units.
CLI::Validator quiet(CLI::Validator check);

}  // namespace tissue::cli
