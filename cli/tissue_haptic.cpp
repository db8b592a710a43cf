// tissue-haptic: simulates a trained tissue model on a haptic device at 1 kHz (Sec. 4).
//
// Sample runs:
//   tissue-haptic results/paper/model.h5 --device virtual --seconds 10
//   tissue-haptic results/paper/model.h5 --motion poke --seconds 2 --record session.h5 --json
//   tissue-haptic results/paper/model.h5 --device replay --trajectory session.h5
//   tissue-haptic results/block3/model.h5 --device remote --port 5000 --second-device remote --second-port 5001
//   tissue-haptic results/paper/model.h5 --check results/paper/cases.h5 --out realtime.json
//   tissue-haptic results/surface-quick/model.h5 --motion probe --hidden target.h5 --learn learned.h5
// Exit status: 0 done (SIGINT, SIGTERM and SIGHUP too), 1 the work failed, 2 the command line was wrong.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "adapt/adapted_model.h"
#include "cases/load_path.h"
#include "command.h"
#include "error.h"
#include "generate.h"
#include "haptic/device_error.h"
#include "haptic/device_kinds.h"
#include "haptic/haply_device.h"
#include "haptic/target_tissue.h"
#include "haptic/learner.h"
#include "haptic/realtime_loop.h"
#include "haptic/recorder.h"
#include "haptic/remote_device.h"
#include "haptic/virtual_device.h"
#include "eval/session_indentation.h"
#include "haptic_options.h"
#include "haptic_report.h"
#include "io/atomic_file.h"
#include "io/one_line.h"
#include "journal.h"
#include "session_end.h"
#include "springs/energy_model_at_radius.h"
#include "version.h"

namespace {

using namespace tissue;

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void on_signal(int) {
    stop.store(true, std::memory_order_relaxed);
}

const std::string prefix[most_tools] = {"--", "--second-"};  ///< of the options of each tool

struct Options {
    struct DeviceChoice {
        std::string kind;
        DeviceValues values;
    };
    std::string model, record, check, out, learn, journal, hidden;
    bool forget = false;
    /// of each tool; an empty second kind: there is one tool
    DeviceChoice device[most_tools] = {{device_kinds().names().front(), {}}, {}};
    int tools() const { return device[1].kind.empty() ? 1 : 2; }
    std::optional<double> seconds;
    unsigned long seed = 2008;
    bool json = false, no_clock = false;
    cli::HapticChoices choices;
};

/// The indentations of --check: the first 50 contacts of the test set if the study draws one, else every load case.
/// Contacts drawn over the full range (held_out_full) fill up the 50. Contacts of discs other than the one in use are
/// left out. own_m, disc_m: radius of the model's disc and of the one in use [m]; 0 in the plane.
std::vector<IndentationReference> indentation_references(const Cases& cases, double own_m, double disc_m) {
    const auto of_other_disc = [&](const LoadPath& path) { return (path.radius_m > 0 ? path.radius_m : own_m) != disc_m; };
    constexpr std::size_t enough = 50;
    std::vector<IndentationReference> references;
    for (const char* role : {"held_out", "held_out_full"})
        for (const LoadPath& path : cases.paths) {
            if (path.role != role || !path.lost.empty() || of_other_disc(path) || references.size() >= enough) continue;
            references.push_back({path.name, path.contact_m, path.direction, path.records.back().magnitude_m,
                              path.records.back().contact_force_N});
        }
    if (!references.empty()) return references;
    for (const LoadCase& c : load_cases(cases))
        if (!of_other_disc(*c.path)) references.push_back({c.name, c.path->contact_m, c.path->direction, c.record->magnitude_m, c.record->contact_force_N});
    return references;
}

/// --check: indentations of the study in the running simulation, and switches between the magnitudes of its first
/// contacts. own_m: radius of the model's disc without --tool [m].
void check(const Options& o, const TissueModel& tissue, const HapticModel& model, double own_m) {
    if (tissue.energy_model && !tissue.energy_model->relaxation.empty())
        throw MismatchError(o.model + ": --check needs tissue at rest, and this model relaxes; use tissuectl eval, which evaluates displacement histories");
    if (model.tools[0].shape == ToolChoice::Shape::ball) throw MismatchError("--check compares with FE references of discs; --tool must not be a ball");
    const Cases cases = read_cases(o.check);
    std::vector<IndentationResult> indentations;
    for (const IndentationReference& reference : indentation_references(cases, own_m, model.tools[0].radius_m)) {
        if (stop.load()) throw tissue::Error("interrupted");
        indentations.push_back(indent(model, tissue, reference));
        const IndentationResult& p = indentations.back();
        std::cerr << (p.reason.empty()
                          ? fmt::format("  {:<26} {:.1f} s  {:.4g} N  {:.3f} % from the static force{}\n", p.name, p.seconds,
                                        p.force_N.norm(), 100 * p.static_error,
                                        p.fe_error ? fmt::format(", {:.1f} % from the FE force", 100 * *p.fe_error) : "")
                          : fmt::format("  {:<26} no result: {}\n", p.name, p.reason));
    }
    std::vector<SwitchJump> jumps;
    constexpr int shown = 18;
    for (int from = 0; !model.is_energy_model() && from + 1 < std::min(shown, tissue.case_count()); ++from) {
        const bool same_place = (tissue.contact_m.row(from) - tissue.contact_m.row(from + 1)).norm() < 1e-9 &&
                                (tissue.direction.row(from) - tissue.direction.row(from + 1)).norm() < 1e-9;
        if (!same_place) continue;
        for (double innovation : {1.0, *model.options.innovation})
            jumps.push_back(switch_jump(tissue, model.options, from, from + 1, innovation));
    }
    write_file(o.out, cli::realtime_json(model, indentations, jumps));
}

/// "tissue-haptic 12.5 s: learned, measured 0.2 N, expected 0.3 N +- 5 %", and a line with the warning, if any.
std::string told(const Learner::Line& line) {
    const UpdateResult& a = line.answer;
    std::string text = fmt::format("tissue-haptic {:.1f} s: {}{}\n", line.time_s, to_string(a.status),
                                   a.status == UpdateStatus::learned ? fmt::format(", measured {:.3g} N, expected {:.3g} N +- {:.2g} %", line.poke.force_N.norm(), a.expected_N.norm(), 100 * a.expected_sd)
                                                                   : ": " + a.why);
    if (!a.warning.empty()) text += "tissue-haptic: " + a.warning + '\n';
    return text;
}

/// Applies the options of the second tool and its device, where they differ from those of the first.
void begin_second(const Options& o, Simulation& simulation) {
    HapticOptions second = o.choices.second();
    second.device = stricter(second.device, device_kinds().at(o.device[1].kind)->impedance);
    try {
        simulation.change(second, 1);
    } catch (const MismatchError& e) {
        throw MismatchError(std::string("the second tool: ") + e.what());
    }
}

void run(const Options& o, Provenance provenance) {
    cli::ignore_broken_pipes();
    HapticOptions haptic = o.choices.haptic;
    TissueModel tissue = read_model(o.model);
    const double own_m = tissue.energy_model ? tissue.energy_model->disc_radius_m : 0;
    if (o.check.empty()) haptic.device = stricter(haptic.device, device_kinds().at(o.device[0].kind)->impedance);
    else haptic.safety.force_max_N = 1e3;  // so that no device limits the force
    std::unique_ptr<Adaptation> adaptation;
    if (!o.learn.empty()) {
        if (!all_default(haptic.tool)) throw MismatchError("--tool: not possible with --learn: a model that learns keeps its own disc");
        adaptation = live_adaptation(o.model);
        if (o.forget) adaptation->forget();
        // check now, because otherwise the session would be lost at its end
        const Hdf5Writer can_be_written(o.learn, "model", provenance);
        tissue = adaptation->base();
        haptic = live_options(haptic, *adaptation);
    }
    HapticModel model(tissue, haptic);
    if (!o.check.empty()) return check(o, with_tool(tissue, haptic.tool[0]), model, own_m);

    Simulation simulation(model);
    if (o.tools() > 1) begin_second(o, simulation);
    std::unique_ptr<Recorder> recorder;
    if (!o.record.empty()) {
        provenance.seed = o.seed;
        provenance.inputs[std::filesystem::path(o.model).filename().string()] = file_hash(o.model);
        recorder = std::make_unique<Recorder>(o.record, model.dimension(), provenance, o.tools());
    }
    std::unique_ptr<cli::Journal> journal;
    std::unique_ptr<Learner> learner;
    if (adaptation) journal = std::make_unique<cli::Journal>(o.journal, model.dimension());
    // devices last, so that none is open while anything else can fail
    std::vector<std::unique_ptr<Device>> owned;
    for (int t = 0; t < o.tools(); ++t) owned.push_back(make_device(o.device[t].kind, o.device[t].values, {*o.seconds, o.seed + static_cast<unsigned long>(t), t, &model.rest, simulation.options(t).map, !o.choices.no_realtime}));
    if (!o.hidden.empty()) owned[0] = std::make_unique<TargetTissue>(std::move(owned[0]), read_model(o.hidden), o.choices.haptic);
    std::vector<Device*> devices;
    for (const auto& device : owned) devices.push_back(device.get());
    std::cerr << cli::describe("tissue-haptic", simulation, devices);
    LoopOptions loop;
    loop.seconds = *o.seconds;
    loop.stop = &stop;
    loop.clock = !o.no_clock;
    loop.realtime = !o.choices.no_realtime;
    if (recorder) loop.hooks.push_back(recorder.get());
    if (adaptation) {
        learner = std::make_unique<Learner>(model, *adaptation);
        learner->on_line(
            [](const Learner::Line& line, const Adaptation&, void* with) {
                std::cerr << told(line);
                static_cast<cli::Journal*>(with)->add(line);
            },
            journal.get(),
            [](const char* why, void*) { std::cerr << "tissue-haptic: learning has stopped, the session continues without it: " << why << '\n'; });
        loop.hooks.push_back(learner.get());
    }
    const LoopReport report = run_loop(simulation, devices, loop);
    if (learner) learner->stop();
    cli::SessionEnd end("tissue-haptic");
    end.then([&] {
        if (recorder) recorder->close(simulation);
    });
    end.then([&] {
        if (!learner) return;
        provenance.seed = o.seed;
        write_adapted_model(o.learn, *adaptation, provenance);
        const Adaptation::State& state = adaptation->state();
        std::cerr << fmt::format("tissue-haptic: {} measurements, {} learned, {} gated, {} refused, {} dropped: {}\n", learner->readings(), state.learned, state.gated,
                                 state.refused, learner->dropped(), o.learn);
    });
    end.then([&] {
        if (learner && *learner->failure()) throw tissue::Error(fmt::format("learning stopped before the end of the session: {}", learner->failure()));
    });
    end.then([&] {
        if (journal) journal->close();
    });
    for (const Device* device : devices)
        end.then([&] {
            if (const std::string why = device->failure(); !why.empty()) throw DeviceError(why);
        });
    for (const std::string& notice : report.notices) std::cerr << "tissue-haptic: " << notice << '\n';
    const std::string model_file = std::filesystem::path(o.model).filename().string();
    const long long dropped = recorder ? recorder->dropped() : 0;
    std::cout << (o.json ? cli::statistics_json(model_file, devices, simulation, report, dropped)
                         : cli::statistics_text(model_file, devices, simulation, report, dropped));
    end.done();
}

void add_options(CLI::App& app, Options& o) {
    using cli::add_number, cli::quiet;
    app.add_option("model", o.model, "model.h5 of tissuectl train")->required()->type_name("FILE");
    app.add_option("--device", o.device[0].kind, fmt::format("{}", fmt::join(device_kinds().names(), ", ")))
        ->type_name("NAME")->capture_default_str()->check(quiet(CLI::IsMember(device_kinds().names())));
    CLI::Option* second = app.add_option("--second-device", o.device[1].kind, "device of a second tool; for an energy model")
        ->type_name("NAME")->check(quiet(CLI::IsMember(device_kinds().names())))->group(cli::second_tool);
    add_number(app, "--seconds", o.seconds, "s", "duration; 0: until a device ends or a signal comes. Default: 10 if every device is virtual, else 0")->check(quiet(CLI::Range(0.0, longest_session_s)));
    app.add_flag("--json", o.json, "print session statistics as JSON");
    app.add_flag("--no-clock", o.no_clock, "run ticks without waiting for the clock, so that there are no overruns; --seconds is simulated time. For scripted motions: devices virtual and replay");
    app.add_option("--record", o.record, "HDF5 file that records every tick")->type_name("FILE");
    app.add_option("--seed", o.seed, "seed of the motions poke and probe; a second device has the next one")->type_name("integer")->capture_default_str();
    for (int t = 0; t < most_tools; ++t)
        for (const DeviceKind* kind : device_kinds().kinds())
            for (const DeviceOption& option : kind->options) {
                std::string& value = o.device[t].values[option.name] = option.initial;
                CLI::Option* added = app.add_option(prefix[t] + option.name, value, t == 0 ? option.meaning : "as --" + option.name)->type_name(option.unit);
                if (!option.initial.empty()) added->capture_default_str();
                if (option.wrong) added->check(CLI::Validator([wrong = option.wrong](std::string& text) { return wrong(text); }, ""));
                if (t > 0) added->needs(second)->group(cli::second_tool);
            }
    cli::add_haptic_options(app, tissue_haptic, o.choices);
    cli::add_second_options(app, tissue_haptic, second, o.choices);
    CLI::Option* learn = app.add_option("--learn", o.learn, "learn from a device that measures force, and write the adapted model here at the end; for energy models")->type_name("FILE");
    app.add_option("--journal", o.journal, "CSV of the learned measurements, written as they are learned; must be a new file. tissuectl adapt --live makes the same model from it, or from its first rows")->type_name("FILE")->needs(learn);
    app.add_flag("--forget", o.forget, "start again from the trained model")->needs(learn);
    CLI::Option* hidden = app.add_option("--hidden", o.hidden, "model.h5 of a target tissue that the device touches and whose force it measures: to try --learn")->type_name("FILE");
    CLI::Option* check = app.add_option("--check", o.check, "simulate the test set, or if there is none the load cases, of this cases.h5, without device and clock")->type_name("FILE");
    CLI::Option* out = app.add_option("--out", o.out, "realtime.json to write, with --check")->type_name("FILE");
    check->needs(out);
    out->needs(check);
    // these options are of a session, and --check runs none
    for (CLI::Option* alone : {learn, hidden, check}) alone->excludes(second);
    for (const char* name : {"--device", "--record", "--learn", "--hidden", "--json", "--seconds", "--seed", "--no-clock", "--no-realtime", "--force-max"}) check->excludes(app.get_option(name));
    for (const DeviceKind* kind : device_kinds().kinds())
        for (const DeviceOption& option : kind->options) check->excludes(app.get_option("--" + option.name));
}

void finish(Options& o, const CLI::App& app) {
    bool ends = true;  // whether every device ends by itself
    for (int t = 0; t < o.tools(); ++t) {
        const auto& [name, values] = o.device[t];
        const DeviceKind& own = *device_kinds().at(name);
        ends = ends && own.seconds > 0;
        for (const DeviceKind* kind : device_kinds().kinds())
            for (const DeviceOption& option : kind->options)
                if (kind->name != name && app.count(prefix[t] + option.name) > 0) throw CLI::ValidationError(prefix[t] + option.name, fmt::format("is an option of device {}, not of {}", kind->name, name));
        for (const DeviceOption& option : own.options)
            if (option.needed && values.at(option.name).empty())
                throw CLI::ValidationError(fmt::format("{}device {}", prefix[t], name), fmt::format("needs {}{} {}", prefix[t], option.name, option.unit));
        if (o.no_clock && !own.scripted) throw CLI::ValidationError("--no-clock", "device " + name + " needs the clock");
        if (t > 0 && !own.several && name == o.device[0].kind) throw CLI::ValidationError("--second-device", fmt::format("a session can have only one device {}", name));
    }
    // 0: any free port, or no port
    const auto port = [&](int t) { return o.device[t].kind == RemoteDevice::kind.name ? std::stoi(o.device[t].values.at("port")) : 0; };
    if (o.tools() > 1 && port(0) != 0 && port(0) == port(1))
        throw CLI::ValidationError("--second-port", "is the port of the first device: give each device its own port");
    const auto haply = [&](int t) { return o.device[t].kind == HaplyDevice::kind.name; };
    if (o.tools() > 1 && haply(0) && haply(1) && o.device[0].values.at("haply-device-id") == o.device[1].values.at("haply-device-id"))
        throw CLI::ValidationError("--second-haply-device-id", "names the first device again: name each device by its own id, the first by --haply-device-id");
    if (!o.seconds) o.seconds = ends ? device_kinds().at(o.device[0].kind)->seconds : 0;
    o.choices.press_with(o.tools());
    cli::check(o.choices);
}

}  // namespace

int main(int argc, char** argv) {
    cli::hold_standard_descriptors();
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    if (std::signal(SIGHUP, on_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // under nohup the program continues
    std::string command;
    for (int i = 0; i < argc; ++i) {
        const std::string word = argv[i];
        const bool path = i == 0 || (!word.empty() && word[0] == '/');
        command += (i > 0 ? " " : "") + (path ? std::filesystem::path(word).filename().string() : word);
    }
    Options o;
    CLI::App app("Simulate soft tissue on a haptic device at 1 kHz.", "tissue-haptic");
    app.formatter(std::make_shared<cli::HelpTable>());
    app.set_version_flag("--version", std::string("tissue-haptic ") + tissue::version, "print the version");
    add_options(app, o);
    try {
        if (cli::generated(app, argc, argv)) return cli::printed(app);
        app.parse(argc, argv);
        finish(o, app);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? cli::printed(app) : 2;
    } catch (const std::exception& e) {
        std::cerr << "tissue-haptic: " << tissue::one_line(e.what()) << '\n';
        return 2;
    }
    try {
        run(o, {command, 0, {}});
        if (!std::cout.flush()) throw FileError("standard output: cannot write: the disk is full, or it is closed");
    } catch (const std::exception& e) {
        std::cerr << "tissue-haptic: " << tissue::one_line(e.what()) << '\n';
        return 1;
    }
    return 0;
}
