#include "study/read_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace tissue {
namespace {

/// Whether a text file contains `name` between backquotes.
bool names_file(const std::string& readme, const std::string& name) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(readme, error)) return false;  // reading a pipe, for instance, would block
    std::ifstream in(readme);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    return text.find("`" + name + "`") != std::string::npos;
}

}  // namespace

std::string file_beside(const TomlReader& in, const std::string& key, const std::string& name) {
    const std::string file = in.beside(key, name);
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error)) return file;
    const std::filesystem::path path(file);
    const std::string readme = (path.parent_path() / "README.md").string();
    in.refuse(key, "there is no file " + file + (names_file(readme, path.filename().string()) ? "; " + readme + " states where to get it" : ""));
}

bool is_multiple(double value, double step) {
    return std::abs(value / step - std::round(value / step)) < 1e-9 * value / step;
}

bool is_plain_name(const std::string& name) {
    return !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
}

Study::MaterialParameters read_material_parameters(TomlReader& in, const std::string& law, std::size_t terms) {
    Study::MaterialParameters p;
    if (law == "ogden") {
        p.mu_Pa = in.numbers("mu_Pa");
        p.alpha = in.numbers("alpha", {-50, 50});
        if (p.mu_Pa.size() != p.alpha.size()) in.refuse("alpha", "must have as many entries as mu_Pa");
        if (terms != 0 && p.alpha.size() != terms) in.refuse("alpha", "must have as many entries as the base material's");
        for (double a : p.alpha)
            if (!(std::abs(a) >= 1e-3)) in.refuse("alpha", "no entry may be 0");
        if (!(p.youngs_modulus_Pa() > 0)) in.refuse("mu_Pa", "the sum of mu_Pa times alpha must be > 0");
        return p;
    }
    p.C1_Pa = in.number("C1_Pa", not_negative);
    p.C2_Pa = law == "neo-Hookean" ? in.optional_number("C2_Pa", not_negative).value_or(0) : in.number("C2_Pa", not_negative);
    if (law == "neo-Hookean" && p.C2_Pa != 0) in.refuse("C2_Pa", "must be 0 for the neo-Hookean law");
    if (!(p.C1_Pa + p.C2_Pa > 0)) in.refuse("C1_Pa", "C1_Pa + C2_Pa must be > 0");
    return p;
}

Study::Loads read_magnitudes(TomlReader& in, const Study::Geometry& geometry) {
    Study::Loads loads;
    loads.magnitudes_m = in.numbers("magnitudes_m", positive);
    loads.record_step_m = in.number("record_step_m", positive);
    for (std::size_t i = 0; i < loads.magnitudes_m.size(); ++i) {
        if (i > 0 && !(loads.magnitudes_m[i] > loads.magnitudes_m[i - 1]))
            in.refuse("magnitudes_m", "must be ascending");
        if (!is_multiple(loads.magnitudes_m[i], loads.record_step_m))
            in.refuse("magnitudes_m", "every entry must be a multiple of record_step_m");
    }
    const double longest_m = std::max({geometry.width_m, geometry.length_m, geometry.height_m});
    if (geometry.is_block() && loads.depth_m() > longest_m)
        in.refuse("magnitudes_m", fmt::format("goes to {:g} mm, beyond the block's length of {:g} mm", 1e3 * loads.depth_m(), 1e3 * longest_m));
    constexpr double most_records = 10'000;  // each costs an FE solve and rows of a file
    if (const double records = loads.depth_m() / loads.record_step_m; records > most_records)
        in.refuse("record_step_m", fmt::format("makes {:.6g} records; at most {:.0f} are allowed", records, most_records));
    return loads;
}

void read_seed_and_count(TomlReader& draw, Study::Draws& d) {
    d.seed = static_cast<unsigned long>(draw.integer("seed", 0, std::numeric_limits<int>::max()));
    d.count = static_cast<int>(draw.integer("count", 1, 100'000));
}

void read_depth(TomlReader& draw, const Study& study, Study::Draws& d) {
    const std::vector<double> depth = draw.numbers("depth_m", 2, positive);
    if (depth[0] > depth[1] || depth[1] > study.loads.depth_m())
        draw.refuse("depth_m", "must be [smallest, largest], the largest at most that of loads.magnitudes_m");
    std::copy(depth.begin(), depth.end(), d.depth_m);
}

void add_draws(const TomlReader& draw, const Study::Draws& d, Study& study) {
    for (const Study::Draws& other : study.draws)
        if (other.seed == d.seed) draw.refuse("seed", "is also that of '" + other.role + "': the draws would overlap");
    draw.refuse_the_rest();
    study.draws.push_back(d);
}

Study::Solver read_solver(TomlReader solver) {
    const Study::Solver s{solver.number("tolerance", {1e-13, 1e-3}), static_cast<int>(solver.integer("max_newton", 2, 100))};
    solver.refuse_the_rest();
    return s;
}

}  // namespace tissue
