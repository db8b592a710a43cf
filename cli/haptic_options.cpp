#include "haptic_options.h"

#include "command.h"
#include "error.h"
#include "io/one_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace tissue::cli {
namespace {

/// Calls `act`, and reports its MismatchError as a wrong command line. of: text before the message.
template <class Act>
void or_usage(Act act, const std::string& of = "") {
    try {
        act();
    } catch (const MismatchError& e) {
        throw CLI::ValidationError(of + one_line(e.what()));
    }
}

}  // namespace

CLI::Validator quiet(CLI::Validator check) {
    check.description("");
    return check;
}

CLI::Option* add_number(CLI::App& app, const char* name, double& value, const char* unit, const char* meaning) {
    return app.add_option(name, value, meaning)->type_name(unit)->capture_default_str()->check(is_number());
}

CLI::Option* add_number(CLI::App& app, const char* name, std::optional<double>& value, const char* unit, const char* meaning) {
    return app.add_option(name, value, meaning)->type_name(unit)->check(is_number());
}

namespace {

/// Adds --NAME VALUE. set(text): takes a value.
template <class Set>
CLI::Option* add_option(CLI::App& app, const SessionOption& row, const std::string& name, const std::string& meaning, const Set& set) {
    CLI::Option* option = row.is_list() ? app.add_option_function<std::vector<std::string>>("--" + name, [set](const auto& words) { set(fmt::format("{}", fmt::join(words, " "))); }, meaning)->expected(2, 3)
                                        : app.add_option_function<std::string>("--" + name, set, meaning);
    return option->type_name(row.unit);
}

}  // namespace

void add_haptic_options(CLI::App& app, Where program, HapticChoices& choices) {
    HapticOptions& haptic = choices.haptic;
    for (const SessionOption& row : session_options()) {
        if (!(row.where & program)) continue;
        const auto set = [&row, &haptic](const std::string& text) { or_usage([&] { row.set(haptic, text); }); };
        const std::string initial = row.initial(program), more = "\n" + row.more;
        if (row.is_switch()) {
            const bool on = initial == "yes";
            app.add_flag_callback(fmt::format("--{}{}", on ? "no-" : "", row.name), [set, on] { set(on ? "no" : "yes"); }, (on ? "turn off: " : "") + row.meaning + more);
            continue;
        }
        const std::string values = row.values();
        add_option(app, row, row.name, row.meaning + (values.empty() ? "" : row.is_number() ? ", " + values : ": " + values) + more, set)->default_str(initial);
    }
    app.add_flag("--no-realtime", choices.no_realtime, "do not request SCHED_FIFO and locked memory");
}

void add_second_options(CLI::App& app, Where program, CLI::Option* needed, HapticChoices& choices) {
    for (const SessionOption& row : session_options()) {
        if (!(row.where & program) || !(row.where & (live | limits))) continue;
        const std::string name = std::string("second-") + row.name;
        const auto set = [&row, &choices, name](const std::string& text) {
            HapticOptions tried;
            or_usage([&] { row.set(tried, text); }, "--" + name + ": ");
            choices.of_second.emplace_back(&row, text);
        };
        add_option(app, row, name, "as for the first tool, whose value is the default", set)->needs(needed)->group(second_tool);
    }
}

void HapticChoices::press_with(int tools) {
    haptic.tools = tools;
    if (tools > 1) haptic.heuristic_mesh = false;
}

HapticOptions HapticChoices::second() const {
    HapticOptions options = haptic;
    for (const auto& [row, text] : of_second) row->set(options, text);
    return options;
}

void check(const HapticChoices& choices) {
    or_usage([&] { check_options(choices.haptic); });
    if (!choices.of_second.empty()) or_usage([&] { check_options(choices.second()); }, "the second tool: ");
}

std::string options_page() {
    std::string page = "# Options of a session\n\n<!-- tissuectl --generate options; the rows are in lib/haptic/session_options.cpp -->\n\n"
                       "`tissue-haptic` and `tissuectl serve` take them as `--NAME VALUE`, `tissue_open` as `\"NAME\", \"VALUE\"`, `tissue.Simulation` as\n"
                       "`NAME=VALUE` with `_` for `-`. In the programs a `yes|no` is a flag: `--NAME`, or `--no-NAME` where the default is yes. A wrong value is refused\n"
                       "everywhere with the same message.\n\n"
                       "| name | unit | default | values | where | while it runs | meaning |\n|---|---|---|---|---|---|---|\n";
    const auto cell = [](std::string text) {
        for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
        return text;
    };
    for (const SessionOption& row : session_options()) {
        std::vector<std::string> where;
        for (const auto& [place, name] : {std::pair(tissue_haptic, "tissue-haptic"), std::pair(tissuectl_serve, "serve"), std::pair(interfaces, "C, Python")})
            if (row.where & place) where.emplace_back(name);
        const std::string initial = row.initial(programs), other = row.initial(interfaces);
        page += fmt::format("| `{}` | {} | {} | {} | {} | {} | {}{}{} |\n", row.name, cell(row.unit), initial + (other == initial ? "" : "; C, Python: " + other), row.values(),
                            fmt::join(where, ", "), row.where & live ? "may change" : row.where & limits ? "until the first tick" : "", cell(row.meaning), row.more.empty() ? "" : ". ", cell(row.more));
    }
    return page;
}

}  // namespace tissue::cli
