#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "error.h"
#include "io/hdf5_store.h"

namespace tissue::cli {

/// Arguments of the program as they were typed, for the provenance of files. Shared by all commands.
struct Invocation {
    std::string command;  ///< absolute paths shortened to their last part
};

/// The command has run, but its result is incomplete: training did not converge, or a surface has faults. what() is one
/// line.
/// Exit status 3.
struct IncompleteResult : Error {
    using Error::Error;
};

/// Each adds one command to the program. It is in its own file cmd_NAME.cpp: parse, call the library, write.
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

/// Units of length that a file's numbers may have [m], and the option that selects one.
extern const std::map<std::string, double> units_m;
void add_unit_option(CLI::App& command, std::string& unit);

/// Checks of an option's text. CLI11's ranges accept NaN, which is neither less nor more than a bound, and the message
/// of its PositiveNumber prints a bound of 309 digits.
const CLI::Validator& is_number();
const CLI::Validator& is_positive();
/// Refuses NaN for all numbers of a program's commands; an option is a number if its unit is one of a number.
void refuse_nan(CLI::App& program);

/// Prints the options in use, given and default, to standard error: "tissuectl train: study=... threads=2".
void echo_options(const CLI::App& command);

/// Exit status of a program that has printed its output: 0; 1, with a message, where standard output did not take all
/// of it.
int printed(const CLI::App& program);

/// For a program started with standard input, output or error closed: opens /dev/null there, so that reading or writing
/// fails. Else the next file that the program opens would get this descriptor, and the program's output.
void hold_standard_descriptors();

/// Help as a table: option, default, unit, meaning. An option's type name is its unit.
class HelpTable : public CLI::Formatter {
   public:
    std::string make_option(const CLI::Option* option, bool is_positional) const override;
    std::string make_group(std::string group, bool is_positional,
                           std::vector<const CLI::Option*> options) const override;
};

}  // namespace tissue::cli
