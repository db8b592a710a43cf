#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "cases/plan.h"
#include "command.h"
#include "error.h"
#include "io/atomic_file.h"
#include "mesh/fixed_region.h"
#include "study/bed.h"
#include "study/new_study.h"
#include "study/study.h"

namespace tissue::cli {
namespace {

struct Options {
    std::string name, unit = "m", folder = "fem/studies";
    NewStudy study;
    double size_m = 0;
};

void run(const Options& o) {
    namespace fs = std::filesystem;
    const auto plain = [](unsigned char c) { return c < 128 && (std::isalnum(c) || std::strchr("._-+", c)); };
    if (o.name.empty() || o.name[0] == '.' || o.name[0] == '-' || !std::all_of(o.name.begin(), o.name.end(), plain))
        throw MismatchError(fmt::format("'{}': a study's name may have letters, digits and . _ - + and must not begin with . or -", o.name));
    std::error_code error;
    if (!fs::is_directory(o.folder, error)) throw FileError(o.folder + ": there is no such folder; studies are in fem/studies of a clone");
    const std::string file = (fs::path(o.folder) / (o.name + ".toml")).string();
    if (fs::exists(fs::symlink_status(file, error))) throw FileError(file + ": exists; remove it, or choose another name");
    if (fs::exists(o.study.shape, error) && !fs::is_regular_file(o.study.shape, error))
        throw FileError(o.study.shape + ": is a folder, a pipe or a device; give a regular file: a shape is read more than once");
    NewStudy wanted = o.study;
    wanted.unit_m = units_m.at(o.unit);
    if (o.size_m > 0) wanted.size_m = o.size_m;
    const auto in_study = [&](const std::string& named) { return fs::proximate(fs::absolute(named), fs::absolute(o.folder)).string(); };
    wanted.shape_in_study = in_study(wanted.shape);
    for (const std::string& held : wanted.fixed) {
        const auto other = FixedRegion::within(held);
        wanted.fixed_in_study.push_back(other ? fmt::format("within {} of {}", other->distance_m, in_study(other->file)) : held);
    }
    if (fs::path(wanted.shape).extension() != ".geo") wanted.trust_geo = false;
    else if (!wanted.trust_geo)
        throw MismatchError(wanted.shape + ": is a program, which gmsh runs and which may run any command; give --trust-geo if you trust it");
    const WrittenStudy written = new_study(wanted);
    write_file(file, written.toml);
    try {
        make_plan(read_study(file));  // make does not support every name
    } catch (...) {
        fs::remove(file, error);  // a refused study is removed
        throw;
    }
    for (const std::string& line : written.choices) std::cout << line << '\n';
    std::cout << fmt::format("{} is written; {}make all STUDY={} runs it\n", file,
                             written.solid ? fmt::format("make contacts STUDY={} draws the fixed parts and the contacts, ", o.name) : "", o.name);
}

}  // namespace

void add_new(CLI::App& app, const Invocation&) {
    auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("new", "Write a study of your own tissue from the file of its shape.");
    command->add_option("name", o->name, "name of the study, as in fem/studies/NAME.toml; no file is overwritten")->required()->type_name("NAME");
    command->add_option("--shape", o->study.shape, "outline or surface: .geo, .msh, .stl, .obj, .ply, .off or .glb; a .geo is read here, and run by gmsh when it is meshed")
        ->required()
        ->type_name("FILE");
    command->add_flag("--trust-geo,--trust_geo", o->study.trust_geo, "trust the .geo, which is a program that gmsh runs");
    add_unit_option(*command, o->unit);
    command->add_option("--held", o->study.fixed, "fixed parts: its named curves, in space named surfaces or regions [m]: 'below z = 0.01', 'ball X Y Z radius R', 'box X Y Z to X Y Z', 'within D of FILE'; without it the names are listed")->type_name("NAME|REGION..");
    command->add_option("--bed", o->study.bed_Pa_m, "in space, stiffness per area of an elastic bed under the fixed parts (fat of 2000 Pa, 0.01 m thick: 200000); without it the fixed parts do not move")->type_name("Pa/m")->check(CLI::Range(bed_least_Pa_m, bed_most_Pa_m));
    command->add_option("--preset", o->study.preset, "material: brain, liver, muscle, or another of fem/materials")->type_name("NAME")->capture_default_str();
    command->add_option("--size", o->size_m, "length of the springs, in space edge of the lattice's cubes; default: an eighth of the tissue's mean size, in space a third of its shortest side if that is less")->type_name("m")->check(is_positive());
    command->add_option("--thickness", o->study.thickness_m, "thickness of the slice, in the plane")->type_name("m")->check(is_positive())->capture_default_str();
    command->add_option("--folder", o->folder, "folder of the studies")->type_name("FOLDER")->capture_default_str();
    command->callback([o] { run(*o); });
}

}  // namespace tissue::cli
