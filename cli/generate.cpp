#include "generate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iostream>

#include "error.h"
#include "haptic_options.h"
#include "version.h"

namespace tissue::cli {
namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App*) { return true; });
}

/// "--out" for an option, "" for a positional.
std::string long_name(const CLI::Option& option) {
    return option.get_lnames().empty() ? "" : "--" + option.get_lnames().front();
}

bool takes_value(const CLI::Option& option) {
    return option.get_items_expected_max() > 0;
}

bool names_a_file(const CLI::Option& option) {
    const std::string name = unit_of(option);
    return name == "FILE" || name == "FOLDER" || name == "PATH";
}

/// The lines of an option's description after the first.
std::string long_text(const CLI::Option& option) {
    const std::string more = option.get_description().substr(meaning_of(option).size());
    return more.size() < 2 ? "" : ". " + more.substr(1);
}

/// Long names of the options for which `wanted` is true.
template <class Wanted>
std::vector<std::string> long_names(const CLI::App& app, Wanted wanted) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        if (!long_name(*option).empty() && wanted(*option)) names.push_back(long_name(*option));
    return names;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
        text.replace(at, from.size(), to);
    return text;
}

// ---- man page

std::string roff(const std::string& text) {
    const std::string safe = replaced(replaced(text, "\\", "\\e"), "-", "\\-");
    return !safe.empty() && (safe[0] == '.' || safe[0] == '\'') ? "\\&" + safe : safe;
}

std::string man_options(const CLI::App& app) {
    std::string text;
    for (const CLI::Option* option : app.get_options()) {
        const std::string name = option->get_name(long_name(*option).empty(), true);
        const std::string initial = option->get_required() ? "required" : option->get_default_str();
        text += fmt::format(
            ".TP\n\\fB{}\\fR{}\n{}{}\n", roff(name), takes_value(*option) ? " \\fI" + roff(unit_of(*option)) + "\\fR" : "",
            roff(meaning_of(*option) + range_of(*option) + long_text(*option)),
            initial.empty() ? ""
                            : roff(initial == "required" ? " (required)" : fmt::format(" (default: {})", initial)));
    }
    return text;
}

std::string man(const CLI::App& app) {
    std::string upper = app.get_name();
    for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    const std::vector<const CLI::App*> commands = commands_of(app);
    std::string text =
        fmt::format(".TH {} 1 \"\" \"tissuectl {}\" \"User commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
                    roff(upper), version, roff(app.get_name()), roff(app.get_description()));
    text += fmt::format("\\fB{}\\fR {}[\\fIOPTIONS\\fR]\n", roff(app.get_name()),
                        commands.empty() ? "\\fIFILE\\fR " : "\\fICOMMAND\\fR ");
    text += ".SH OPTIONS\n" + man_options(app);
    if (!commands.empty()) text += ".SH COMMANDS\n";
    for (const CLI::App* command : commands)
        text += fmt::format(".SS {}\n{}\n{}", roff(command->get_name()), roff(command->get_description()),
                            man_options(*command));
    text += ".SH EXIT STATUS\n0 success, 1 failure, 2 wrong command line";
    if (!commands.empty())
        text += ", 3 \\fBtrain\\fR has written the model, but part of the training did not converge; \\fBsurface\\fR found faults";
    text += ".\n";
    return text;
}

// ---- completion

/// Every command with its name. The program itself has the name "".
std::vector<std::pair<std::string, const CLI::App*>> parts_of(const CLI::App& app) {
    std::vector<std::pair<std::string, const CLI::App*>> parts = {{"", &app}};
    for (const CLI::App* command : commands_of(app)) parts.emplace_back(command->get_name(), command);
    return parts;
}

std::string bash(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* command : commands_of(app)) names.push_back(command->get_name());
    const std::string function = "_" + replaced(app.get_name(), "-", "_");
    std::string files, values, words;
    for (const auto& [name, part] : parts_of(app)) {
        for (const std::string& option : long_names(*part, names_a_file))
            files += fmt::format("{}{},{}", files.empty() ? "" : "|", name, option);
        for (const std::string& option :
             long_names(*part, [](const CLI::Option& o) { return takes_value(o) && !names_a_file(o); }))
            values += fmt::format("{}{},{}", values.empty() ? "" : "|", name, option);
        words += fmt::format("        '{}') words='{}{}' ;;\n", name,
                             fmt::join(long_names(*part, [](const CLI::Option&) { return true; }), " "),
                             name.empty() && !names.empty() ? fmt::format(" {}", fmt::join(names, " ")) : "");
    }
    std::string text = fmt::format(
        "# bash completion of {}\n{}() {{\n"
        "    local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} command= words= word\n"
        "    COMPREPLY=()\n",
        app.get_name(), function);
    if (!names.empty())
        text += fmt::format(
            "    for word in \"${{COMP_WORDS[@]:1:COMP_CWORD-1}}\"; do\n"
            "        case $word in {}) command=$word; break ;; esac\n    done\n",
            fmt::join(names, "|"));
    text += "    case $command,$prev in\n";
    if (!files.empty()) text += fmt::format("        {}) COMPREPLY=($(compgen -f -- \"$cur\")); return ;;\n", files);
    if (!values.empty()) text += fmt::format("        {}) return ;;\n", values);
    text += fmt::format(
        "    esac\n    case $command in\n{}    esac\n"
        "    if [[ $cur == -* {}]]; then COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n"
        "    else COMPREPLY=($(compgen -f -- \"$cur\")); fi\n}}\n"
        "complete -o filenames -F {} {}\n",
        words, names.empty() ? "" : "|| -z $command ", function, app.get_name());
    return text;
}

std::string fish(const CLI::App& app) {
    std::string text = fmt::format("# fish completion of {}\n", app.get_name());
    for (const auto& [name, part] : parts_of(app)) {
        const bool alone = commands_of(app).empty();
        const std::string when = alone          ? ""
                                 : name.empty() ? " -n __fish_use_subcommand"
                                                : fmt::format(" -n '__fish_seen_subcommand_from {}'", name);
        const auto quoted = [](const std::string& words) {
            return "'" + replaced(replaced(words, "\\", "\\\\"), "'", "\\'") + "'";
        };
        if (!name.empty())
            text += fmt::format("complete -c {} -n __fish_use_subcommand -f -a {} -d {}\n", app.get_name(), name,
                                quoted(part->get_description()));
        for (const CLI::Option* option : part->get_options())
            if (!long_name(*option).empty())
                text +=
                    fmt::format("complete -c {}{} -l {}{} -d {}\n", app.get_name(), when, option->get_lnames().front(),
                                !takes_value(*option)   ? ""
                                : names_a_file(*option) ? " -r -F"
                                                        : " -x",
                                quoted(meaning_of(*option)));
    }
    return text;
}

std::string zsh(const CLI::App& app) {
    const auto quoted = [](std::string words) {
        for (const char* special : {"\\", "[", "]", ":"}) words = replaced(words, special, std::string("\\") + special);
        return replaced(words, "'", "'\\''");
    };
    const auto arguments = [&](const CLI::App& part) {
        std::string text;
        for (const CLI::Option* option : part.get_options())
            if (!long_name(*option).empty())
                text += fmt::format(
                    " \\\n            '{}[{}]{}'", long_name(*option), quoted(meaning_of(*option)),
                    !takes_value(*option)
                        ? ""
                        : fmt::format(":{}:{}", quoted(unit_of(*option)), names_a_file(*option) ? "_files" : " "));
        return text;
    };
    std::string text = fmt::format("#compdef {}\n# zsh completion of {}\n", app.get_name(), app.get_name());
    if (commands_of(app).empty()) return text + "_arguments" + arguments(app) + " \\\n            '*:FILE:_files'\n";
    std::string described, cases;
    for (const CLI::App* command : commands_of(app)) {
        described +=
            fmt::format(" {}\\:\"{}\"", command->get_name(), quoted(replaced(command->get_description(), "\"", "")));
        cases += fmt::format("        {}) _arguments{} \\\n            '*:FILE:_files' ;;\n", command->get_name(),
                             arguments(*command));
    }
    return text + fmt::format(
                      "local line state\n_arguments -C{} \\\n            '1:command:(({}))' '*::argument:->argument'\n"
                      "if [[ $state == argument ]]; then\n    case $line[1] in\n{}    esac\nfi\n",
                      arguments(app), described, cases);
}

}  // namespace

std::string unit_of(const CLI::Option& option) {
    const std::string name = option.get_type_name();
    return name.substr(0, name.find(':'));
}

std::string meaning_of(const CLI::Option& option) {
    const std::string text = option.get_description();
    return text.substr(0, text.find('\n'));
}

std::string range_of(const CLI::Option& option) {
    const std::string name = option.get_type_name();
    const std::size_t open = name.find(" in ["), dash = name.find(" - ", open), close = name.find(']', open);
    if (open == std::string::npos || dash == std::string::npos || close == std::string::npos) return "";
    return fmt::format(", {} to {}", name.substr(open + 5, dash - open - 5), name.substr(dash + 3, close - dash - 3));
}

namespace {

struct Product {
    const char* name;
    std::string (*make)(const CLI::App&);
};
constexpr Product products[] = {{"man", man}, {"bash", bash}, {"zsh", zsh}, {"fish", fish}, {"options", [](const CLI::App&) { return options_page(); }}};

}  // namespace

std::string generate(const CLI::App& app, const std::string& what) {
    std::vector<std::string> names;
    for (const Product& product : products) {
        if (what == product.name) return product.make(app);
        names.push_back(product.name);
    }
    throw MismatchError(fmt::format("--generate '{}' is not known; allowed: {}", what, fmt::join(names, ", ")));
}

bool generated(const CLI::App& app, int argc, char** argv) {
    if (argc != 3 || std::string(argv[1]) != "--generate") return false;
    std::cout << generate(app, argv[2]);
    return true;
}

}  // namespace tissue::cli
