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
    std::string token;  // "true" as a flag; what else stands behind --token= is refused
    bool json = false;
    HapticChoices choices;
    serve::ServerOptions server;
};

void run(const Options& o, Provenance provenance) {
    std::unique_ptr<Recorder> recorder;  // outlives the tick that pushes into it
    std::unique_ptr<Journal> journal;    // and the learner that writes into it
    serve::Stage stage(o.models, {o.choices.haptic, !o.choices.no_realtime, o.surface, units_m.at(o.unit), o.hidden});
    if (!o.learn.empty()) const Hdf5Writer can_be_written(o.learn, "model", provenance);  // or a session would be lost at its end
    serve::Server server(stage, o.server);
    for (const std::string& warning : stage.warnings()) std::cerr << "tissuectl serve: warning: " << warning << '\n';
    if (!o.record.empty()) {
        const std::string& file = o.models.front();
        provenance.inputs[std::filesystem::path(file).filename().string()] = file_hash(file);
        recorder = std::make_unique<Recorder>(o.record, stage.model().dimension(), provenance, stage.tools());
    }
    if (!o.journal.empty()) {  // last: a session that does not begin leaves no file
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
        std::cerr << fmt::format("tissuectl serve: {} readings learned: {}\n", stage.lesson()->adaptation().state().learned, o.learn);
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
        if (*stage.learning_failure()) throw Error(fmt::format("learning ended before the session did: {}", stage.learning_failure()));
    });
    end.done();
}

/// The token, which stands on no command line, since every user of a machine sees those; and what the options must not be together.
void settle(Options& o) {
    if (const char* given = std::getenv("TISSUECTL_TOKEN")) o.server.token = given;
    if (!o.token.empty()) {
        // a token behind --token would be a model that is not there, and its text the name in a message
        const char* const own = "takes no text: the variable TISSUECTL_TOKEN gives a token of one's own";
        if (o.token != "true") throw CLI::ValidationError("--token", own);
        for (std::size_t k = 0; k < o.models.size(); ++k)
            if (std::error_code error; !std::filesystem::exists(o.models[k], error))
                throw CLI::ValidationError("--token", fmt::format("{}; and model {} of {} is not there", own, k + 1, o.models.size()));
    }
    if (!o.record.empty() && o.models.size() > 1)
        throw CLI::ValidationError("--record", "a recording is of one model");
    if (!o.hidden.empty() && o.models.size() > 1)
        throw CLI::ValidationError("--hidden", "one model learns, not one of several");
    if (!o.server.token.empty() && !serve::is_token(o.server.token))
        throw CLI::ValidationError("TISSUECTL_TOKEN", "wanted 16 to 128 letters, digits, - and _");
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
    CLI::App* command = app.add_subcommand("serve", "Press learned tissue from a page in the browser.");
    command->add_option("model", o->models, "model.h5 of tissuectl train; several to choose from. A cases.h5 beside one "
                                                 "gives FE's surface, an eval.json of that model gives its error map")->required()->type_name("FILE");
    command->add_option("--port", o->server.port, "TCP; 0: any that is free")
        ->type_name("number")->capture_default_str()->check(quiet(CLI::Range(0, 65535)));
    command->add_option("--bind", o->server.bind, "address to listen on; all but this machine's own bring --token")
        ->type_name("address")->capture_default_str();
    command->add_flag("--token", o->token, "let in only who has a token: drawn, and printed once in the page's address; the variable TISSUECTL_TOKEN gives "
                                                "one of your own");
    command->add_option("--clients", o->server.clients, "pages at a time")
        ->type_name("count")->capture_default_str()->check(quiet(CLI::Range(1, 32)));
    add_number(*command, "--seconds", o->server.seconds, "s", "how long; 0: until a signal comes")->check(quiet(CLI::Range(0.0, longest_session_s)));
    command->add_flag("--json", o->json, "print session statistics as JSON");
    command->add_option("--record", o->record, "HDF5 file for every tick, of one model")->type_name("FILE");
    command->add_option("--surface", o->surface, "the organ's own surface, such as its .stl, which the page draws in place of the model's coarser one; of the first model, in space")->type_name("FILE");
    add_unit_option(*command, o->unit);
    command->get_option("--unit")->needs("--surface");
    CLI::Option* hidden = command->add_option("--hidden", o->hidden, "model.h5 of another tissue: the tool touches it too, unseen, and the model, an energy model, "
                                                                    "learns from its force whenever the hand holds still")->type_name("FILE");
    command->add_option("--learn", o->learn, "model.h5 to write at the end, as it has learned to be")->type_name("FILE")->needs(hidden);
    command->add_option("--journal", o->journal, "learned measurements, CSV, as they come; a new file: tissuectl adapt --live makes the same model of it")->type_name("FILE")->needs(hidden);
    add_haptic_options(*command, tissuectl_serve, o->choices);
    command->callback([o, &invocation] {
        settle(*o);
        o->choices.press_with(o->choices.haptic.tools);
        check(o->choices);
        run(*o, {invocation.command, 0, {}});
    });
}

}  // namespace tissue::cli
