#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace tissue::cli {

/// An option's unit, without what a check has added to its type name.
std::string unit_of(const CLI::Option& option);
/// An option's meaning in one line: the first of its description. A man page has the others too.
std::string meaning_of(const CLI::Option& option);
/// What that check says, in words: ", 0.1 to 100"; empty where it says nothing of a range.
std::string range_of(const CLI::Option& option);

/// What `make install` asks a program for with `--generate WHAT`, made from its own table of options: "man" (a page of
/// section 1), the completion for "bash", "zsh" or "fish"; or "options", lib/api/OPTIONS.md. Throws MismatchError for anything else.
std::string generate(const CLI::App& app, const std::string& what);

/// True, and printed, when the command line is `--generate WHAT` and nothing else.
bool generated(const CLI::App& app, int argc, char** argv);

}  // namespace tissue::cli
