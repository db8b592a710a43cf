#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace tissue::cli {

/// An option's unit, without what a check appends to its type name.
std::string unit_of(const CLI::Option& option);
/// An option's meaning in one line: the first line of its description. The man page has the other lines too.
std::string meaning_of(const CLI::Option& option);
/// The range of an option's check, in words: ", 0.1 to 100"; empty where the check states none.
std::string range_of(const CLI::Option& option);

/// What `make install` gets from a program by `--generate WHAT`, made from its own table of options: "man" (a page of
/// section 1), the completion for "bash", "zsh" or "fish", or "options" (lib/api/OPTIONS.md). Throws MismatchError for
/// anything else.
std::string generate(const CLI::App& app, const std::string& what);

/// If the command line is exactly `--generate WHAT`: prints it and returns true.
bool generated(const CLI::App& app, int argc, char** argv);

}  // namespace tissue::cli
