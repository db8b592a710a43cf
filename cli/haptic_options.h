#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptic/session_options.h"

namespace tissue::cli {

/// What `tissue-haptic` and `tissuectl serve` have of the rows of session_options(), and beside them how the loop runs.
struct HapticChoices {
    HapticOptions haptic;
    bool no_realtime = false;
    std::vector<std::pair<const SessionOption*, std::string>> of_second;  ///< what a second tool has otherwise, as it was given

    void press_with(int tools);  ///< two press the learned mesh alone
    HapticOptions second() const;
};

/// The rows of `program`. Their values are checked as they are read.
void add_haptic_options(CLI::App& app, Where program, HapticChoices& choices);

/// The rows that each tool may have values of its own of, as --second-NAME; `needed`: without which they are none.
void add_second_options(CLI::App& app, Where program, CLI::Option* needed, HapticChoices& choices);

/// Where help lists them.
inline const char* const second_tool = "Second tool: each as the option without second-, yes or no in place of a flag";

/// After parsing. Throws CLI::ValidationError for numbers that no model takes (check_options).
void check(const HapticChoices& choices);

/// lib/api/OPTIONS.md.
std::string options_page();

/// A number with its unit, its default and its meaning.
CLI::Option* add_number(CLI::App& app, const char* name, double& value, const char* unit, const char* meaning);
CLI::Option* add_number(CLI::App& app, const char* name, std::optional<double>& value, const char* unit, const char* meaning);  ///< of no default

/// A check whose own words stay out of the help's column of units.
CLI::Validator quiet(CLI::Validator check);

}  // namespace tissue::cli
