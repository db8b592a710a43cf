#include <fmt/format.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "command.h"
#include "error.h"
#include "haptic/realtime_loop.h"
#include "haptic_options.h"
#include "haptic_report.h"
#include "io/atomic_file.h"
#include "journal.h"
#include "serve/access.h"
#include "serve/network/server.h"
#include "session_end.h"

namespace tissue::cli {
namespace {

struct Options {
    std::vector<std::string> models;
    std::string record, hidden, learn, journal, surface, unit = "m";
    std::string token;  // "true" as a flag; other texts after --token= are refused
    bool json = false;
    HapticChoices choices;
    serve::ServerOptions server;
};

void run(const Options& o, Provenance provenance) {
    std::unique_ptr<Recorder> recorder;  // outlives the tick, which pushes into it
    std::unique_ptr<Journal> journal;    // outlives the learner, which writes into it
    serve::Stage stage(o.models, {o.choices.haptic, !o.choices.no_realtime, o.surface, units_m.at(o.unit), o.hidden});
    // check now, because otherwise the session would be lost at its end
    if (!o.learn.empty()) const Hdf5Writer can_be_written(o.learn, "model", provenance);
    serve::Server server(stage, o.server);
    for (const std::string& warning : stage.warnings()) std::cerr << "tissuectl serve: warning: " << warning << '\n';
    if (!o.record.empty()) {
        const std::string& file = o.models.front();
        provenance.inputs[std::filesystem::path(file).filename().string()] = file_hash(file);
        recorder = std::make_unique<Recorder>(o.record, stage.model().dimension(), provenance, stage.tools());
    }
    if (!o.journal.empty()) {  // last, so that a session that does not start leaves no file
        journal = std::make_unique<Journal>(o.journal, stage.model().dimension());
        stage.lesson()->also_tell([&journal](const Learner::Line& line) { journal->add(line); });
    }
    ignore_broken_pipes();
    std::cerr << describe("tissuectl serve", stage.simulation(), stage.pointers());
    std::cerr << "tissuectl serve: " << server.url() << std::endl;
    stage.start(recorder.get());
    server.run();
    stage.stop();
    SessionEnd end("tissuectl serve");
    end.then([&] {
        if (recorder) recorder->close(stage.simulation());
    });
    end.then([&] {
        if (o.learn.empty()) return;
        write_adapted_model(o.learn, stage.lesson()->adaptation(), provenance);
        std::cerr << fmt::format("tissuectl serve: {} measurements learned: {}\n", stage.lesson()->adaptation().state().learned, o.learn);
    });
    end.then([&] {
        if (journal) journal->close();
    });
    for (const std::string& notice : stage.report().notices) std::cerr << "tissuectl serve: " << notice << '\n';
    const std::string file = std::filesystem::path(o.models[static_cast<std::size_t>(stage.index())]).filename().string();
    const long long dropped = recorder ? recorder->dropped() : 0;
    std::cout << (o.json ? statistics_json(file, stage.pointers(), stage.simulation(), stage.report(), dropped)
                         : statistics_text(file, stage.pointers(), stage.simulation(), stage.report(), dropped));
    end.then([&] {
        if (stage.failed()) throw Error("the simulation has failed");
        if (*stage.learning_failure()) throw Error(fmt::format("learning stopped before the end of the session: {}", stage.learning_failure()));
    });
    end.done();
}

/// Settles the token, which is not given on the command line because all users of a machine can see it; and refuses
/// options that exclude each other.
void settle(Options& o) {
    if (const char* given = std::getenv("TISSUECTL_TOKEN")) o.server.token = given;
    if (!o.token.empty()) {
        // a token after --token would be read as the name of a missing model, and a message would print it
        const char* const own = "takes no value: to give a token of your own, set the variable TISSUECTL_TOKEN";
        if (o.token != "true") throw CLI::ValidationError("--token", own);
        for (std::size_t k = 0; k < o.models.size(); ++k)
            if (std::error_code error; !std::filesystem::exists(o.models[k], error))
                throw CLI::ValidationError("--token", fmt::format("{}; and model {} of {} does not exist", own, k + 1, o.models.size()));
    }
    if (!o.record.empty() && o.models.size() > 1)
        throw CLI::ValidationError("--record", "needs one model, not several");
    if (!o.hidden.empty() && o.models.size() > 1)
        throw CLI::ValidationError("--hidden", "needs one model, not several");
    if (!o.server.token.empty() && !serve::is_token(o.server.token))
        throw CLI::ValidationError("TISSUECTL_TOKEN", "must have 16 to 128 letters, digits, - and _");
    bool loopback = true;
    try {
        loopback = serve::is_loopback(o.server.bind);
    } catch (const Error& e) {
        throw CLI::ValidationError("--bind", e.what());
    }
    if (o.server.token.empty() && (!o.token.empty() || !loopback)) o.server.token = serve::draw_secret();
}

}  // namespace

void add_serve(CLI::App& app, const Invocation& invocation) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("serve", "Serve a web page on which trained tissue can be indented.");
    command->add_option("model", o->models, "model.h5 of tissuectl train; the page chooses among several. A cases.h5 in its folder "
                                                 "gives the FE surface, an eval.json of the model its error map")->required()->type_name("FILE");
    command->add_option("--port", o->server.port, "TCP port; 0: any free port")
        ->type_name("number")->capture_default_str()->check(quiet(CLI::Range(0, 65535)));
    command->add_option("--bind", o->server.bind, "address to listen on; any but a loopback address implies --token")
        ->type_name("address")->capture_default_str();
    command->add_flag("--token", o->token, "admit only pages with a token: drawn, and printed once in the page's address; the variable TISSUECTL_TOKEN gives "
                                                "a token of your own");
    command->add_option("--clients", o->server.clients, "largest number of pages at a time")
        ->type_name("count")->capture_default_str()->check(quiet(CLI::Range(1, 32)));
    add_number(*command, "--seconds", o->server.seconds, "s", "duration; 0: until a signal comes")->check(quiet(CLI::Range(0.0, longest_session_s)));
    command->add_flag("--json", o->json, "print session statistics as JSON");
    command->add_option("--record", o->record, "HDF5 file that records every tick, for one model")->type_name("FILE");
    command->add_option("--surface", o->surface, "the organ's own surface, for example an .stl, which the page draws in place of the model's coarser one; for the first model, in space")->type_name("FILE");
    add_unit_option(*command, o->unit);
    command->get_option("--unit")->needs("--surface");
    CLI::Option* hidden = command->add_option("--hidden", o->hidden, "model.h5 of a target tissue: the tool touches it too, it is not drawn, and the energy model "
                                                                    "learns from its force whenever the hand is at rest")->type_name("FILE");
    command->add_option("--learn", o->learn, "adapted model.h5 to write at the end")->type_name("FILE")->needs(hidden);
    command->add_option("--journal", o->journal, "CSV of the learned measurements, written as they are learned; must be a new file. tissuectl adapt --live makes the same model from it")->type_name("FILE")->needs(hidden);
    add_haptic_options(*command, tissuectl_serve, o->choices);
    command->callback([o, &invocation] {
        settle(*o);
        o->choices.press_with(o->choices.haptic.tools);
        check(o->choices);
        run(*o, {invocation.command, 0, {}});
    });
}

}  // namespace tissue::cli
