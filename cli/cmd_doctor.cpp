#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/utsname.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "command.h"
#include "error.h"
#include "version.h"

namespace tissue::cli {
namespace {

/// A program or library, how to get its version, and its Debian package. tests/pipeline/test_doctor.sh compares this
/// table with scripts/install_deps.
struct Tool {
    const char* name;
    const char* package;
    const char* ask;  ///< shell command; its output contains the version; a nonzero status: not installed
    bool needed;
    const char* purpose;
};

/// Shell command that looks for FreeFEM's plugins where FreeFEM does.
constexpr const char* ask_plugins =
    "folder=${FF_LOADPATH:-$(dirname \"$(dpkg -L libfreefem++ | grep '/gmsh\\.so$' | grep -v /mpi/ | head -n 1)\")}; "
    "script=$(mktemp --suffix=.edp) && trap 'rm -f \"$script\"' EXIT && "
    "echo 'load \"gmsh\" load \"Element_P1dc1\" load \"Element_QF\" load \"MUMPS_seq\" cout << \"plugins\" << endl;' "
    ">\"$script\" && "
    "FF_LOADPATH=$folder FreeFem++-nw -nw -v 0 \"$script\" >/dev/null && echo \"in $folder\"";

const std::vector<Tool>& tools() {
    static const std::vector<Tool> table = {
        {"g++", "g++", "g++ -dumpfullversion", true, "compiles the programs"},
        {"make", "make", "make --version", true, "runs the stages"},
        {"pkg-config", "pkg-config", "pkg-config --version", true, "finds the libraries"},
        {"gmsh", "gmsh", "gmsh --version", true, "meshes the tissue"},
        {"FreeFem++", "freefem++",
         "script=$(mktemp --suffix=.edp) && trap 'rm -f \"$script\"' EXIT && echo \";\" >\"$script\" && "
         "said=$(FreeFem++-nw -nw -v 1 \"$script\") && echo \"$said\" | head -n 1",
         true, "solves the load cases"},
        {"FreeFem++ plugins", "libfreefem++", ask_plugins, true, "gmsh, Element_P1dc1, Element_QF, MUMPS_seq"},
        {"Eigen", "libeigen3-dev", "pkg-config --modversion eigen3", true, "matrices"},
        {"OpenBLAS", "libopenblas-dev", "pkg-config --modversion openblas", true, "matrices"},
        {"LAPACKE", "liblapacke-dev", "pkg-config --modversion lapacke", true, "matrices"},
        {"NLopt", "libnlopt-cxx-dev", "pkg-config --modversion nlopt", true, "nlopt:NAME optimisers"},
        {"HDF5", "libhdf5-dev", "pkg-config --modversion hdf5", true, "cases.h5, model.h5"},
        {"GSL", "libgsl-dev", "pkg-config --modversion gsl", true, "random numbers"},
        {"xxHash", "libxxhash-dev", "pkg-config --modversion libxxhash", true, "fingerprints of inputs"},
        {"libcsv", "libcsv-dev", "dpkg-query -W -f '${Version}' libcsv-dev", true, "measured data"},
        {"CHOLMOD", "libsuitesparse-dev", "dpkg-query -W -f '${Version}' libsuitesparse-dev", true, "equilibria in space"},
        {"CLI11", "libcli11-dev", "pkg-config --modversion CLI11", true, "command lines"},
        {"toml++", "libtomlplusplus-dev", "pkg-config --modversion tomlplusplus", true, "studies"},
        {"nlohmann-json", "nlohmann-json3-dev", "pkg-config --modversion nlohmann_json", true, "eval.json"},
        {"fmt", "libfmt-dev", "pkg-config --modversion fmt", true, "text"},
        {"Catch2", "catch2", "pkg-config --modversion catch2", true, "tests"},
        {"python3", "python3", "$PYTHON --version", true, "figures"},
        {"python3 venv", "python3-venv", "$PYTHON -c 'import venv, ensurepip; print(ensurepip.version())'", true,
         "peers of make bench"},
        {"numpy", "python3-numpy", "$PYTHON -c 'import numpy; print(numpy.__version__)'", true, "figures"},
        {"h5py", "python3-h5py", "$PYTHON -c 'import h5py; print(h5py.__version__)'", true, "figures"},
        {"matplotlib", "python3-matplotlib", "$PYTHON -c 'import matplotlib; print(matplotlib.__version__)'", true,
         "figures"},
        {"jinja2", "python3-jinja2", "$PYTHON -c 'import jinja2; print(jinja2.__version__)'", true, "report.html"},
        {"markdown-it", "python3-markdown-it", "$PYTHON -c 'import markdown_it; print(markdown_it.__version__)'", true,
         "report.html"},
        {"Boost", "libboost-dev",
         "echo '#include <boost/version.hpp>\nBOOST_LIB_VERSION' | g++ -E -P -x c++ - | tail -n 1 | tr _ .", true,
         "tissuectl serve"},
        {"CGAL", "libcgal-dev", "sed -n 's/^#define CGAL_VERSION \\([0-9.]*\\).*/\\1/p' /usr/include/CGAL/version.h | grep .", true, "surfaces"},
        {"three.js", "libjs-three", "sed -n \"s/^var REVISION = '\\(.*\\)';/0.\\1/p\" /usr/share/javascript/three/three.module.js | grep .", true,
         "the page, in space"},
        {"pybind11", "pybind11-dev", "pkg-config --modversion pybind11", true, "import tissue"},
        {"Python's headers", "python3-dev", "pkg-config --modversion python3", true, "import tissue"},
        {"VTK", "python3-vtk9",
         "$PYTHON -c 'from vtkmodules.vtkCommonCore import vtkVersion; print(vtkVersion.GetVTKVersion())'", false,
         "tests of exports"},
        {"Sphinx", "python3-sphinx", "$PYTHON -c 'import sphinx; print(sphinx.__version__)'", false, "make docs"},
        {"MyST", "python3-myst-parser", "$PYTHON -c 'import myst_parser; print(myst_parser.__version__)'", false, "make docs"},
        {"Furo", "furo", "$PYTHON -c 'import furo; print(furo.__version__)'", false, "make docs"},
        {"ccache", "ccache", "ccache --version", false, "faster recompilation"},
        {"clang", "clang", "clang++ --version", false, "make sanitize, make fuzz"},
        {"clang's sanitizers", "libclang-rt-14-dev",
         "ls \"$(clang++ -print-resource-dir)\"/lib/*/libclang_rt.fuzzer-*.a", false, "make sanitize, make fuzz"},
        {"Chromium", "chromium", "chromium --version", false, "tests of pages"},
        {"chromedriver", "chromium-driver", "chromedriver --version", false, "tests of pages"},
        {"Liberation fonts", "fonts-liberation", "dpkg-query -W fonts-liberation", false, "tests of pages"},
        {"selenium", "python3-selenium", "$PYTHON -c 'import selenium; print(selenium.__version__)'", false,
         "tests of pages"},
        {"Slurm", "slurm-wlm", "slurmd -V", false, "RUN='srun -n1'"},
        {"munge", "munge", "munged --version", false, "Slurm's keys"},
        {"C# compiler", "mono-mcs", "mcs --version", false, "tests of the client in C#"},
        {"Mono", "mono-runtime", "mono --version", false, "tests of the client in C#"},
        {"cyclictest", "rt-tests", "cyclictest --help", false, "wake-up latency of this machine"},
    };
    return table;
}

struct Answer {
    bool there = false;
    std::string version;
};

/// Runs a shell command for at most ten seconds. Standard error is read too, because some programs print their version
/// there.
Answer ask(const std::string& line) {
    const std::string command = "exec 2>&1 </dev/null; " + line;
    setenv("TISSUE_DOCTOR_ASKS", command.c_str(), 1);
    FILE* pipe = popen("timeout 10 sh -c \"$TISSUE_DOCTOR_ASKS\"", "r");
    if (!pipe) throw Error("doctor: cannot start a shell");
    std::string said;
    char buffer[512];
    for (std::size_t n; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) said.append(buffer, n);
    const int status = pclose(pipe);
    Answer answer;
    answer.there = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    std::smatch version;
    if (std::regex_search(said, version, std::regex("in (/[^\n]*)|[0-9]+(\\.[0-9]+)+")))
        answer.version = version[1].matched ? version[1].str() : version[0].str();
    answer.there = answer.there && !answer.version.empty();
    return answer;
}

/// A realtime feature, whether this machine allows it to our threads, and how to get it.
struct Allowance {
    const char* name;
    bool allowed;
    const char* remedy;
};

std::vector<Allowance> allowances() {
    bool scheduled = false;
    std::thread([&] {
        sched_param wanted{};
        wanted.sched_priority = 80;
        scheduled = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted) == 0;
    }).join();
    const bool locked = mlockall(MCL_CURRENT) == 0;
    if (locked) munlockall();
    return {{"SCHED_FIFO", scheduled, "root, or 'rtprio 95' for this user in /etc/security/limits.conf"},
            {"locked memory", locked, "root, or 'memlock unlimited' for this user in /etc/security/limits.conf"},
            {"realtime kernel", std::filesystem::exists("/sys/kernel/realtime"),
             "linux-image-rt-amd64; without it ticks may be milliseconds late"}};
}

void run(bool json) {
    setenv("PYTHON", "/usr/bin/python3", 0);
    nlohmann::ordered_json out = {
        {"version", version}, {"tools", nlohmann::json::array()}, {"machine", nlohmann::json::array()}};
    std::vector<std::string> missing, packages;
    std::string text;
    for (const Tool& tool : tools()) {
        const Answer answer = ask(tool.ask);
        out["tools"].push_back({{"name", tool.name},
                                {"package", tool.package},
                                {"needed", tool.needed},
                                {"found", answer.there},
                                {"version", answer.there ? nlohmann::json(answer.version) : nlohmann::json()},
                                {"purpose", tool.purpose}});
        text += fmt::format("{:<18} {:<24} {:<20} {}\n", tool.name,
                            answer.there  ? answer.version
                            : tool.needed ? "MISSING"
                                          : "not found (optional)",
                            tool.package, tool.purpose);
        if (answer.there || !tool.needed) continue;
        missing.push_back(tool.name);
        packages.push_back(tool.package);
    }
    utsname system{};
    uname(&system);
    text += fmt::format("\n{:<18} {} {}, {} cores\n", "machine", system.sysname, system.release,
                        std::thread::hardware_concurrency());
    for (const Allowance& a : allowances()) {
        out["machine"].push_back({{"name", a.name}, {"allowed", a.allowed}, {"remedy", a.remedy}});
        text += fmt::format("{:<18} {}\n", a.name, a.allowed ? "yes" : std::string("no; to allow it: ") + a.remedy);
    }
    out["missing"] = packages;
    std::cout << (json ? out.dump(2) + "\n"
                       : fmt::format("{:<18} {:<24} {:<20} {}\n", "tool", "version", "Debian package", "for") + text)
              << std::flush;
    if (!missing.empty())
        throw Error(fmt::format("missing: {}; run make deps, or as root: apt-get install {}", fmt::join(missing, ", "),
                                fmt::join(packages, " ")));
}

}  // namespace

void add_doctor(CLI::App& app, const Invocation&) {
    auto json = std::make_shared<bool>(false);
    CLI::App* command = app.add_subcommand(
        "doctor", "Print the version of every tool found, and what is missing and how to install it; exit 1 if a required tool is missing.");
    command->add_flag("--json", *json, "print JSON");
    command->callback([json] { run(*json); });
}

}  // namespace tissue::cli
