#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iostream>
#include <set>
#include <thread>

#include "command.h"
#include "eval/ablation.h"
#include "io/atomic_file.h"
#include "progress.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string study, cases, out, role = "validation";
    int threads = 0;
};

/// Checked before training: with a role that has no contacts the table would have no rows.
void refuse_role(const Options& o, const Cases& cases) {
    std::set<std::string> there;
    for (const LoadPath& path : cases.paths)
        if (path.role != "train" && path.role != "check" && path.role != "map" && !path.second) there.insert(path.role);
    if (there.count(o.role) == 0)
        throw MismatchError(fmt::format("{}: has no drawn contacts of role '{}'; its roles: {}", o.cases, o.role, there.empty() ? "none" : fmt::format("{}", fmt::join(there, ", "))));
}

void run(const Options& o) {
    const Study study = read_study(o.study);
    const Cases cases = read_cases(o.cases);
    refuse_role(o, cases);
    std::vector<VariantResult> results;
    {
        Progress progress("ablate");
        results = ablate(study, cases, o.threads,
                         [&](int done, int total, const std::string& name) { progress.step(done, total, name); });
    }
    write_file(o.out, to_json(results));
    std::cout << fmt::format("indentation errors on '{}', median / p95 / max (n of N)\n{:<42} {:>7} {:>8} {:>8} {:>28} {:>28}\n",
                             o.role, "variant", "terms", "FE paths", "training", "force", "displacement");
    for (const VariantResult& r : results) {
        const DrawnContacts* drawn = r.held_out.role(o.role);
        if (!drawn) continue;
        const auto cell = [](const Statistics& e) {
            return fmt::format("{} / {} / {} ({})", percent(e.median, 2), percent(e.p95, 2), percent(e.max, 2), n_of_N(e));
        };
        const ContactStatistics s = drawn->statistics(0);
        std::cout << fmt::format("{:<42} {:>7} {:>8} {:>6.1f} s {:>28} {:>28}\n", r.variant.name, r.variant.terms.size(),
                                 r.fe_paths, r.seconds, cell(s.force), cell(s.shape));
    }
}

}  // namespace

void add_ablate(CLI::App& app, const Invocation&) {
    auto o = std::make_shared<Options>();
    o->threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    CLI::App* command = app.add_subcommand("ablate", "Train the variants of a study's energy model and evaluate each on the drawn contacts.");
    command->add_option("--study", o->study, "study file")->required()->type_name("FILE");
    command->add_option("--cases", o->cases, "cases.h5 of tissuectl collect")->required()->type_name("FILE");
    command->add_option("--out", o->out, "ablation.json to write")->required()->type_name("FILE");
    command->add_option("--role", o->role, "role of the drawn contacts in the printed table")
        ->type_name("ROLE")
        ->capture_default_str();
    command->add_option("--threads", o->threads, "load paths evaluated at a time; changes no result")
        ->type_name("threads")
        ->capture_default_str()
        ->check(CLI::Range(1, 4096));
    command->callback([o, command] {
        echo_options(*command);
        run(*o);
    });
}

}  // namespace tissue::cli
