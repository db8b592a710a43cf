#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "adapt/adapted_model.h"
#include "adapt/next_measurement.h"
#include "adapt/measurements_csv.h"
#include "command.h"
#include "error.h"
#include "eval/statistics_json.h"
#include "haptic/learner.h"
#include "io/atomic_file.h"
#include "io/one_line.h"
#include "springs/indentation_solver.h"
#include "springs/push_refusal.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string model, data, out, held_out, readings = "long-term";
    AdaptOptions adapt;
    double next_depth_m = usual_depth_m;
    int first = 0, next = 0;
    bool stream = false, forget = false, json = false, no_rival = false, live = false;
    std::set<std::string> given;  ///< options that were given, of those that an adapted file keeps
};

/// An option of the adaptation that a file keeps: its name, how to copy it, and its value as text.
struct Kept {
    const char* option;
    void (*set)(AdaptOptions& to, const AdaptOptions& from);
    std::string (*text)(const AdaptOptions&);
};
const Kept kept_options[] = {
    {"--unknowns", [](AdaptOptions& to, const AdaptOptions& from) { to.unknowns = from.unknowns; }, [](const AdaptOptions& o) { return o.unknowns; }},
    {"--no-rival", [](AdaptOptions& to, const AdaptOptions& from) { to.rival = from.rival; }, [](const AdaptOptions& o) { return std::string(o.rival ? "no" : "yes"); }},
    {"--noise", [](AdaptOptions& to, const AdaptOptions& from) { to.force_noise = from.force_noise; }, [](const AdaptOptions& o) { return fmt::format("{:g}", o.force_noise); }},
    {"--model-error", [](AdaptOptions& to, const AdaptOptions& from) { to.model_error = from.model_error; }, [](const AdaptOptions& o) { return fmt::format("{:g}", o.model_error); }},
    {"--place-error", [](AdaptOptions& to, const AdaptOptions& from) { to.place_error_m = from.place_error_m; }, [](const AdaptOptions& o) { return fmt::format("{:g}", o.place_error_m); }},
    {"--readings", [](AdaptOptions& to, const AdaptOptions& from) { to.at_rest = from.at_rest; }, [](const AdaptOptions& o) { return std::string(o.at_rest ? "long-term" : "instantaneous"); }},
};

/// The adaptation of the file, with the options that it was begun with. A different value of one of them is refused,
/// unless --forget is given.
std::unique_ptr<Adaptation> continued(const Options& o) {
    std::unique_ptr<Adaptation> adaptation = read_adaptation(o.model, o.adapt);
    if (o.given.count("--readings") > 0 && adaptation->base().energy_model->relaxation.empty())
        throw MismatchError(o.model + ": the model does not relax; --readings needs a model that relaxes");
    AdaptOptions wanted = adaptation->options();
    for (const Kept& k : kept_options) {
        if (o.given.count(k.option) == 0) continue;
        k.set(wanted, o.adapt);
        if (const std::string begun = k.text(adaptation->options()), asked = k.text(wanted); !o.forget && begun != asked)
            throw MismatchError(fmt::format("{}: was adapted with {} {}, not {}: leave the option out, or start again with --forget", o.model, k.option, begun, asked));
    }
    return o.forget ? std::make_unique<Adaptation>(adaptation->base(), wanted) : std::move(adaptation);
}

/// Relative error |model - measurement| / |measurement| over measurements that are not learned from. Where the model
/// has no answer, the error is infinite. A measurement that cannot be of this tissue (push_refusal), or that has no
/// force, is no reference (eval/statistics.h).
Statistics held_out_error(const TissueModel& model, const std::vector<ForceMeasurement>& pokes) {
    const IndentationSolver solver(model);
    const FreeSurface surface(model.mesh);
    std::vector<double> sample;
    for (const ForceMeasurement& poke : pokes) {
        if (!(poke.force_N.norm() > 0) || !push_refusal(model.mesh, surface, poke.contact_m, poke.push_m).empty()) {
            sample.push_back(std::numeric_limits<double>::quiet_NaN());
            continue;
        }
        const Equilibrium answer = solver.at(poke.contact_m, poke.push_m);
        sample.push_back(answer ? (answer.contact_force - poke.force_N).norm() / poke.force_N.norm() : std::numeric_limits<double>::infinity());
    }
    return statistics_of(sample);
}

/// The model whose forces are measured: long-term or instantaneous, where it relaxes.
TissueModel as_read(const Adaptation& adaptation) {
    TissueModel model = adaptation.model();
    if (!model.energy_model->relaxation.empty()) model.energy_model = adaptation.options().at_rest ? long_term(*model.energy_model) : instantaneous(*model.energy_model);
    return model;
}

std::string millimetres(const Point& p) {
    std::string text;
    for (double v : p) text += fmt::format("{}{:.1f}", text.empty() ? "" : ", ", 1e3 * v);
    return text;
}

std::vector<double> listed(const Point& p) { return {p.begin(), p.end()}; }

/// Output of one line per measurement: text on standard error, JSON on standard output.
class Lines {
   public:
    Lines(const Options& o, int dimension) : o_(o) {
        if (!o.held_out.empty()) held_out_ = read_measurements(o.held_out, dimension);
    }

    void begin(const Adaptation& adaptation) {
        if (held_out_.empty()) return;
        const Statistics error = held_out_error(as_read(adaptation), held_out_);
        std::cerr << fmt::format("adapt: before the first measurement: test error {} / {} (median / p95, {})\n", percent(error.median), percent(error.p95), n_of_N(error, "measurements"));
    }

    void poke(int line, const ForceMeasurement& poke, const UpdateResult& answer, const Adaptation& adaptation) {
        const Adaptation::State& state = adaptation.state();
        nlohmann::ordered_json j = {{"line", line},
                                    {"status", to_string(answer.status)},
                                    {"why", answer.why},
                                    {"contact_m", listed(poke.contact_m)},
                                    {"push_m", listed(poke.push_m)},
                                    {"force_N", listed(poke.force_N)},
                                    {"expected_N", listed(answer.expected_N)},
                                    {"expected_sd", answer.expected_sd},
                                    {"chi2", answer.chi2},
                                    {"gate", answer.gate},
                                    {"error_before", answer.error_before},
                                    {"error_after", answer.error_after},
                                    {"learned", state.learned},
                                    {"one_scale_plays", adaptation.single_scale_in_use()},
                                    {"warning", answer.warning}};
        std::string line_text = fmt::format("adapt {}: at {} mm by {} mm: {}", line, millimetres(poke.contact_m), millimetres(poke.push_m), to_string(answer.status));
        if (answer.status == UpdateStatus::learned)
            line_text += fmt::format(", measured {:.3g} N, expected {:.3g} N +- {:.2g} %, chi2 {:.2g}", poke.force_N.norm(), answer.expected_N.norm(), 100 * answer.expected_sd, answer.chi2);
        else
            line_text += ": " + answer.why;
        if (!held_out_.empty() && answer.status == UpdateStatus::learned) {
            const Statistics error = held_out_error(as_read(adaptation), held_out_);
            j["held_out"] = to_value(error);
            line_text += fmt::format("; test error {} / {} ({})", percent(error.median), percent(error.p95), n_of_N(error));
        }
        say(line_text, j);
        if (!answer.warning.empty()) std::cerr << "adapt: " << answer.warning << '\n';
    }

    void fault(int line, const std::string& fault) {
        const std::string why = one_line(fault);  // a terminal executes control bytes
        say("adapt: " + why, {{"line", line}, {"status", "refused"}, {"why", why}});
    }

    void next(Adaptation& adaptation) {
        if (o_.next == 0) return;
        const std::vector<Push> pushes =
            pushes_over(adaptation.surface(), adaptation.base().mesh, o_.next_depth_m, adaptation.surface().spacing_m());
        const std::vector<MeasurementGain> worth = rank_measurements(adaptation, pushes, pushes);
        for (std::size_t i = 0; i < worth.size() && i < static_cast<std::size_t>(o_.next); ++i) {
            const Push& push = pushes[worth[i].push];
            say(fmt::format("adapt next: at {} mm by {} mm: standard deviation {:.2g} % of the force; a measurement here would remove {:.0f} % of the surface's variance", millimetres(push.contact_m),
                            millimetres(push.push_m), 100 * worth[i].sd_before, 100 * worth[i].gain),
                {{"next", i + 1}, {"contact_m", listed(push.contact_m)}, {"push_m", listed(push.push_m)}, {"sd", worth[i].sd_before}, {"gain", worth[i].gain}});
        }
    }

   private:
    void say(const std::string& line, const nlohmann::ordered_json& j) {
        std::cerr << line << '\n';
        if (o_.json) std::cout << j.dump() << std::endl;  // flush each line, for readers of a stream
    }

    const Options& o_;
    std::vector<ForceMeasurement> held_out_;
};

/// Warns where the gated measurements differ from the predictions by a factor that no tissue explains.
void warn_unit(const std::string& name, std::vector<double> times) {
    constexpr std::size_t few = 3;
    constexpr double factor = 100;
    if (times.size() < few) return;
    std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
    const double median = times[times.size() / 2];
    if (median < factor && median > 1 / factor) return;
    std::cerr << fmt::format("adapt {}: warning: {} gated measurements are {:.2g} times the predicted force: is a unit in the header wrong (N or mN, m or mm)?\n", name, times.size(), median);
}

void run(const Options& o, Provenance provenance) {
    provenance.inputs[std::filesystem::path(o.model).filename().string()] = file_hash(o.model);
    const bool standard_input = o.data == "-";
    const std::string name = standard_input ? "standard input" : o.data;
    std::istringstream read_once;  // a pipe can be read only once
    if (!o.stream) {
        std::string text = standard_input ? read_all(std::cin, name) : read_file(o.data);
        provenance.inputs[std::filesystem::path(o.data).filename().string()] = text_hash(text);
        read_once.str(std::move(text));
    }
    const std::unique_ptr<Adaptation> adaptation = o.live ? live_adaptation(o.model) : continued(o);
    if (o.live && o.forget) adaptation->forget();
    std::string kept = "adapt: options";
    for (const Kept& k : kept_options)
        if (std::string(k.option) != "--readings" || !adaptation->base().energy_model->relaxation.empty()) kept += fmt::format(" {}={}", k.option + 2, k.text(adaptation->options()));
    std::cerr << kept << '\n';
    const int D = adaptation->base().mesh.dimension();
    Lines lines(o, D);
    lines.begin(*adaptation);
    auto rows = !o.stream        ? std::make_unique<MeasurementLines>(read_once, name, D)
                : standard_input ? std::make_unique<MeasurementLines>(std::cin, name, D)
                                 : std::make_unique<MeasurementLines>(o.data, D);
    // a file is read to its end before anything is learned from it: a bad line refuses the whole file
    std::vector<MeasurementLines::Row> whole;
    while (!o.stream) {
        auto row = rows->next();
        if (!row) break;
        if (!row->fault.empty()) throw FileError(row->fault);
        whole.push_back(std::move(*row));
    }
    int read = 0;
    std::vector<double> gated;  // measured force over predicted force
    while (o.first == 0 || read < o.first) {
        const auto row = o.stream ? rows->next() : read < static_cast<int>(whole.size()) ? std::optional(whole[static_cast<std::size_t>(read)]) : std::nullopt;
        if (!row) break;
        ++read;
        if (!row->fault.empty()) {
            lines.fault(row->line, row->fault);
            continue;
        }
        const UpdateResult answer = adaptation->learn(row->poke);
        lines.poke(row->line, row->poke, answer, *adaptation);
        if (answer.status == UpdateStatus::gated) gated.push_back(row->poke.force_N.norm() / answer.expected_N.norm());
        if (!o.stream) continue;
        if (answer.status == UpdateStatus::learned) write_adapted_model(o.out, *adaptation, provenance);
        lines.next(*adaptation);
    }
    if (read == 0) throw FileError(name + ": has no rows");
    warn_unit(name, gated);
    write_adapted_model(o.out, *adaptation, provenance);
    if (!o.stream) lines.next(*adaptation);
    const Adaptation::State& state = adaptation->state();
    if (adaptation->single_scale_in_use()) std::cerr << fmt::format("adapt: one scale explains the measurements: {:.3g} times as stiff as trained\n", std::exp(state.scale));
    std::cerr << fmt::format("adapt: {} learned, {} gated, {} refused: {}\n", state.learned, state.gated, state.refused, o.out);
}

}  // namespace

void add_adapt(CLI::App& app, const Invocation& invocation) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand(
        "adapt", "Adapt a model to force measurements of another tissue, one by one; the result has the adapted stiffness and its standard deviation.");
    command->add_option("model", o->model, "model.h5 of an energy model; an adapted model is adapted further, with its options")->required()->type_name("FILE");
    command->add_option("--data", o->data, "CSV of measurements, in the format of measured contacts; - is standard input")->required()->type_name("FILE");
    command->add_option("--out", o->out, "model.h5 to write, whole or not at all")->required()->type_name("FILE");
    command->add_flag("--stream", o->stream, "learn from lines as they arrive: an invalid line is refused with a message, and the model is written after every measurement");
    command->add_option("--held-out", o->held_out, "CSV of the test set: the error on it is printed after each measurement; never learned from")->type_name("FILE");
    command->add_option("--first", o->first, "number of rows to learn from, from the first; 0: all")->type_name("count")->capture_default_str()->check(CLI::Range(0, 100000000));
    command->add_flag("--forget", o->forget, "start again from the trained model; options that are not given keep the values in the file");
    command->add_option("--next", o->next, "number of places to measure next to print, the most informative first")->type_name("count")->capture_default_str()->check(CLI::Range(0, 1000));
    command->add_option("--next-depth", o->next_depth_m, "tool displacement of those measurements")->type_name("m")->capture_default_str()->check(CLI::Range(1e-4, 0.1));
    command->add_option("--unknowns", o->adapt.unknowns, "what is adapted: scale, terms, field or elements")->type_name("NAME")->capture_default_str()->check(CLI::IsMember(unknown_kinds()));
    command->add_flag("--no-rival", o->no_rival, "for field and elements: without the single scale for all the tissue, which is used while it is more probable");
    command->add_option("--noise", o->adapt.force_noise, "standard deviation of a component of force, over the force")->type_name("1")->capture_default_str()->check(CLI::Range(0.0, 0.5));
    command->add_option("--model-error", o->adapt.model_error, "standard deviation of the model's error, over the force")->type_name("1")->capture_default_str()->check(CLI::Range(0.001, 0.5));
    command->add_option("--readings", o->readings, "for a model that relaxes, when the forces were measured: long-term, at rest, or instantaneous, before relaxation")
        ->type_name("WORD")->capture_default_str()->check(CLI::IsMember({"long-term", "instantaneous"}));
    command->add_option("--place-error", o->adapt.place_error_m, "standard deviation of a contact's place along the surface")->type_name("m")->capture_default_str()->check(CLI::Range(0.0, 0.05));
    CLI::Option* live = command->add_flag("--live", o->live, "learn from the --journal of a session, with the options of a session: place error 0.001 m, at most 4.5 times as stiff or as soft");
    for (const Kept& k : kept_options) live->excludes(command->get_option(k.option));
    command->add_flag("--json", o->json, "one line of JSON per measurement on standard output");
    command->callback([o, command, &invocation] {
        echo_options(*command);
        o->adapt.rival = !o->no_rival;
        o->adapt.at_rest = o->readings == "long-term";
        for (const Kept& k : kept_options)
            if (command->count(k.option) > 0) o->given.insert(k.option);
        run(*o, {invocation.command, 0, {}});
    });
}

}  // namespace tissue::cli
