#include "command.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <set>

#include "generate.h"

namespace tissue::cli {

const std::map<std::string, double> units_m = {{"mm", 0.001}, {"cm", 0.01}, {"m", 1}, {"inch", 0.0254}};

const CLI::Validator& is_number() {
    static const CLI::Validator check([](std::string& given) { return CLI::detail::to_lower(given).find("nan") == std::string::npos ? std::string() : given + " is not a number"; }, "");
    return check;
}

const CLI::Validator& is_positive() {
    static const CLI::Validator check(
        [](std::string& given) {
            double value = 0;
            return CLI::detail::lexical_cast(given, value) && value > 0 && std::isfinite(value) ? std::string() : given + " is not a finite number above 0";
        },
        "");
    return check;
}

void refuse_nan(CLI::App& program) {
    for (CLI::App* command : program.get_subcommands({})) {
        if (command->get_name() == "serve") continue;  // the options of a session have their own messages
        for (CLI::Option* option : command->get_options([](const CLI::Option* o) {
                 static const std::set<std::string> units = {"m", "s", "1", "N", "kg", "Hz", "Pa/m", "Ns/m", "N/m", "rad", "m/s", "N/s"};
                 const std::string type = o->get_type_name();  // validators append their description after a colon
                 return units.count(type.substr(0, type.find(':'))) > 0;
             }))
            option->check(is_number());
    }
}

void add_unit_option(CLI::App& command, std::string& unit) {
    command.add_option("--unit", unit, "unit of length of the file: mm, cm, m or inch")->check(CLI::IsMember({"mm", "cm", "m", "inch"}))->type_name("unit")->capture_default_str();
}

void echo_options(const CLI::App& command) {
    std::string line = "tissuectl " + command.get_name() + ":";
    for (const CLI::Option* option : command.get_options()) {
        const std::string name = option->get_single_name();
        if (name == "help") continue;
        const std::string value = option->count() > 0 ? CLI::detail::join(option->results(), ",")
                                                      : option->get_default_str();
        if (!value.empty()) line += " " + name + "=" + value;
    }
    std::cerr << line << '\n';
}

int printed(const CLI::App& program) {
    if (std::cout.flush()) return 0;
    std::cerr << program.get_name() << ": standard output: cannot write: the disk is full, or it is closed\n";
    return 1;
}

void hold_standard_descriptors() {
    for (int descriptor = 0; descriptor <= 2; ++descriptor)
        // open() returns the lowest free number
        if (::fcntl(descriptor, F_GETFD) < 0) ::open("/dev/null", descriptor == 0 ? O_WRONLY : O_RDONLY);
}

std::string HelpTable::make_option(const CLI::Option* option, bool is_positional) const {
    const std::string initial = option->get_required() ? "required" : option->get_default_str(), unit = unit_of(*option);
    // the first of two spellings; the second is that of an earlier version
    const std::string name = is_positional || option->get_lnames().size() < 2 ? option->get_name(is_positional, true) : "--" + option->get_lnames().front();
    return fmt::format("  {:<22} {:<12} {:<10} {}{}\n", name, initial.empty() ? "-" : initial, unit.empty() ? "-" : unit, meaning_of(*option), range_of(*option));
}

std::string HelpTable::make_group(std::string group, bool is_positional,
                                  std::vector<const CLI::Option*> options) const {
    std::string out = fmt::format("\n{}:\n  {:<22} {:<12} {:<10} {}\n", group, "option", "default", "unit", "meaning");
    for (const CLI::Option* option : options) out += make_option(option, is_positional);
    return out;
}

}  // namespace tissue::cli
