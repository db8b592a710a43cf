// tissuectl: the commands of the batch pipeline. Each is in a file cmd_NAME.cpp; this file selects one.
//
// Sample runs:
//   tissuectl train --study fem/studies/paper.toml --cases results/paper/cases.h5 --out model.h5
//   tissuectl eval --study fem/studies/paper.toml --model model.h5 --cases results/paper/cases.h5 --out eval.json
//   tissuectl serve results/paper/model.h5
//   tissuectl info model.h5
// Exit status: 0 done; 1 the work failed; 2 the command line was wrong; 3 (train) the model is written, but a part that
// should have converged did not; 3 (surface) the answer is printed: the surface cannot be filled.
#include <cblas.h>

#include <filesystem>
#include <iostream>

#include "command.h"
#include "generate.h"
#include "io/one_line.h"
#include "parallel.h"
#include "version.h"

namespace {

/// The first word, if it is neither an option nor a command; else "".
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
    const std::string word = argc > 1 ? argv[1] : "-";
    const bool known = !app.get_subcommands([&](const CLI::App* command) { return command->check_name(word); }).empty();
    return word.empty() || word[0] == '-' || known ? "" : word;
}

}  // namespace

int main(int argc, char** argv) {
    using namespace tissue::cli;
    hold_standard_descriptors();
    // threads are used per spring set; threads of BLAS itself would also change the last bits of results
    openblas_set_num_threads(1);

    Invocation invocation;
    for (int i = 0; i < argc; ++i) {
        const std::string word = argv[i];
        const bool path = i == 0 || (!word.empty() && word[0] == '/');
        invocation.command += (i > 0 ? " " : "") + (path ? std::filesystem::path(word).filename().string() : word);
    }

    CLI::App app("Soft tissue for haptics: spring models learned from finite elements.", "tissuectl");
    app.formatter(std::make_shared<HelpTable>());
    app.set_version_flag("--version", std::string("tissuectl ") + tissue::version, "print the version");
    app.require_subcommand(1);
    add_new(app, invocation);
    add_plan(app, invocation);
    add_shape(app, invocation);
    add_surface(app, invocation);
    add_rim(app, invocation);
    add_collect(app, invocation);
    add_import(app, invocation);
    add_train(app, invocation);
    add_eval(app, invocation);
    add_ablate(app, invocation);
    add_adapt(app, invocation);
    add_serve(app, invocation);
    add_info(app, invocation);
    add_export(app, invocation);
    add_doctor(app, invocation);
    refuse_nan(app);
    try {
        if (generated(app, argc, argv)) return printed(app);
        if (const std::string unknown = unknown_command(app, argc, argv); !unknown.empty()) {
            std::cerr << "tissuectl: '" << unknown << "' is not a command; tissuectl --help lists them\n";
            return 2;
        }
        app.parse(argc, argv);
        if (!std::cout.flush()) throw tissue::FileError("standard output: cannot write: the disk is full, or it is closed");
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? printed(app) : 2;
    } catch (const IncompleteResult& e) {
        std::cerr << "tissuectl: " << tissue::one_line(e.what()) << '\n';
        return printed(app) == 0 ? 3 : 1;  // nothing is promised of output that was cut off
    } catch (const std::exception& e) {
        std::cerr << "tissuectl: " << tissue::one_line(e.what()) << '\n';
        return 1;
    }
    if (const int refused = tissue::refused_threads())
        std::cerr << "tissuectl: the system started " << refused << " threads fewer than requested (a limit on processes or "
                  << "memory); the work was done with fewer threads, and results are the same\n";
    return 0;
}
