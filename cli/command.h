#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "error.h"
#include "io/hdf5_store.h"

namespace tissue::cli {

/// What every command shares: the program's own arguments as they were typed, for provenance.
struct Invocation {
    std::string command;  ///< absolute paths shortened to their last part
};

/// The work is done and written, but did not end as it promises; what() is the line that says so. Exit status 3.
struct NotAsPromised : Error {
    using Error::Error;
};

/// Adds one command to the program. Each lives in a file of its own, cmd_NAME.cpp: parse, call lib, write.
void add_new(CLI::App& app, const Invocation& invocation);
void add_plan(CLI::App& app, const Invocation& invocation);
void add_shape(CLI::App& app, const Invocation& invocation);
void add_surface(CLI::App& app, const Invocation& invocation);
void add_rim(CLI::App& app, const Invocation& invocation);
void add_collect(CLI::App& app, const Invocation& invocation);
void add_import(CLI::App& app, const Invocation& invocation);
void add_train(CLI::App& app, const Invocation& invocation);
void add_eval(CLI::App& app, const Invocation& invocation);
void add_adapt(CLI::App& app, const Invocation& invocation);
void add_ablate(CLI::App& app, const Invocation& invocation);
void add_serve(CLI::App& app, const Invocation& invocation);
void add_info(CLI::App& app, const Invocation& invocation);
void add_export(CLI::App& app, const Invocation& invocation);
void add_doctor(CLI::App& app, const Invocation& invocation);

/// Units of length that a file's numbers may have [m], and the option that names one.
extern const std::map<std::string, double> units_m;
void add_unit_option(CLI::App& command, std::string& unit);

/// Checks of an option's text. CLI11's own ranges let NaN through, which is neither less nor more, and its positive numbers end at one of 309 digits.
const CLI::Validator& is_number();
const CLI::Validator& is_positive();
/// Every number of a program's commands, by its unit: NaN is none.
void refuse_nan(CLI::App& program);

/// Prints the options in use, given and default, on standard error: "tissuectl train: study=... threads=2".
void echo_options(const CLI::App& command);

/// Exit status of a program that has printed what it was asked for: 0; 1, with a line, where standard output did not take all of it.
int printed(const CLI::App& program);

/// Where the program was started with standard input, output or error closed: opens what can neither be read nor written there. Else the next file that
/// the program opens would get their number, and what is printed.
void hold_standard_descriptors();

/// Help as a table: option, default, unit, meaning. An option's type name is its unit.
class HelpTable : public CLI::Formatter {
   public:
    std::string make_option(const CLI::Option* option, bool is_positional) const override;
    std::string make_group(std::string group, bool is_positional,
                           std::vector<const CLI::Option*> options) const override;
};

}  // namespace tissue::cli
