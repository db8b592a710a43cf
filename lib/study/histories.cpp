#include "study/histories.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "study/read_parts.h"
#include "study/solid_study.h"

namespace tissue {
namespace {

constexpr double least_rise_s = 0.005, longest_s = 600;  // no hand moves faster; a longer FE solve takes too much time
constexpr double steepest_deg = 75, steepest_tilt_deg = 90;

void read_range(TomlReader& in, const char* key, const Range& allowed, double (&out)[2]) {
    const std::vector<double> range = in.numbers(key, 2, allowed);
    if (range[0] > range[1]) in.refuse(key, "must be [smallest, largest]");
    std::copy(range.begin(), range.end(), out);
}

/// Reads where and how deep the trajectories of a group are drawn.
void read_contacts(TomlReader& in, const Study& study, Study::Histories& h) {
    const bool solid = study.geometry.is_solid();
    if (!solid && !study.loads.sweep) in.refuse("kind", "'" + h.kind + "' needs a study with loads.sweep, which states where contacts may be drawn");
    read_seed_and_count(in, h);
    for (const Study::Draws& other : study.draws)
        if (other.seed == h.seed) in.refuse("seed", "is also that of draws." + other.role + ": the contacts would be the same");
    for (const Study::Histories& other : study.histories)
        if (other.file.empty() && other.seed == h.seed) in.refuse("seed", "is also that of '" + other.name + "': the contacts would be the same");
    read_depth(in, study, h);
    if (solid)
        read_solid_place(in, study, h);
    else
        h.max_angle_deg = in.number("max_angle_deg", {0, steepest_deg});
}

void read_times(TomlReader& in, const Study& study, Study::Histories& h) {
    const bool solid = study.geometry.is_solid();
    if (h.kind == "sine")
        read_range(in, "frequency_Hz", {0.01, 50}, h.frequency_Hz);
    else
        read_range(in, "rise_s", {least_rise_s, longest_s}, h.rise_s);
    if (h.kind == "sine" || h.kind == "poke")
        h.duration_s = in.number("duration_s", {least_rise_s, longest_s});
    else
        h.hold_s = in.number("hold_s", {0, longest_s});
    if (h.kind == "poke") {
        h.wander_deg = in.number("wander_deg", not_negative);
        const double off_deg = solid ? h.tilt_deg[1] : h.max_angle_deg, most_deg = solid ? steepest_tilt_deg : steepest_deg;
        if (off_deg + h.wander_deg > most_deg)
            in.refuse("wander_deg", fmt::format("with {} = {:g} it must be at most {:g}, so that directions stay within {:g} degrees of the normal",
                                                solid ? "tilt_deg" : "max_angle_deg", off_deg, most_deg - off_deg, most_deg));
    }
    if (h.kind == "again" && solid && in.has("apart_m")) in.refuse("apart_m", "is possible only in the plane; in space the second contact is the first one");
    if (h.kind == "again" && !solid) h.apart_m = in.optional_number("apart_m", not_negative).value_or(0);
}

void read_file(TomlReader& in, const Study& study, Study::Histories& h) {
    const std::string name = in.text("file");
    h.file = (std::filesystem::path(in.file_of("file")).parent_path() / name).lexically_normal().string();
    std::error_code error;
    if (!std::filesystem::is_regular_file(h.file, error)) in.refuse("file", "there is no file " + h.file);
    const Study::Geometry& g = study.geometry;
    const std::vector<double> at = in.numbers("contact_m", g.is_solid() ? 3 : 2);
    h.contact_m = Eigen::Map<const Eigen::VectorXd>(at.data(), static_cast<Eigen::Index>(at.size()));
    h.count = 1;
    if (!g.is_block()) return;
    constexpr double tiny_m = 1e-9;
    const auto within = [](double x, double low, double high) { return x >= low - tiny_m && x <= high + tiny_m; };
    const double c = study.indenter.clearance_m();
    if (g.is_solid()) {
        if (std::abs(at[2] - g.height_m) > tiny_m || !within(at[0], c, g.width_m - c) || !within(at[1], c, g.length_m - c))
            in.refuse("contact_m", fmt::format("({:g}, {:g}, {:g}) m is not on the top of the {:g} x {:g} x {:g} m block, {:g} mm from every wall", at[0],
                                               at[1], at[2], g.width_m, g.length_m, g.height_m, 1e3 * c));
        return;
    }
    const bool on_side = (std::abs(at[0]) <= tiny_m || std::abs(at[0] - g.width_m) <= tiny_m) && within(at[1], c, g.height_m),
               on_top = std::abs(at[1] - g.height_m) <= tiny_m && within(at[0], 0, g.width_m);
    if (!on_side && !on_top)
        in.refuse("contact_m", fmt::format("({:g}, {:g}) m is not on the free surface of the {:g} x {:g} m block, {:g} mm from the fixed edge", at[0], at[1],
                                           g.width_m, g.height_m, 1e3 * c));
}

}  // namespace

void read_histories(TomlReader& in, Study& study) {
    for (TomlReader& group : in.tables("histories")) {
        Study::Histories h{};
        h.name = group.text("name");
        if (!is_plain_name(h.name)) group.refuse("name", "must have only lower-case letters, digits and '-'");
        for (const Study::Histories& other : study.histories)
            if (other.name == h.name) group.refuse("name", "'" + h.name + "' is present twice");
        h.kind = group.choice("kind", {"ramp", "release", "sine", "poke", "again", "file"});
        h.role = group.has("role") ? group.choice("role", {"held_out", "validation", "train"}) : "held_out";
        if (h.kind == "file") {
            read_file(group, study, h);
        } else {
            read_contacts(group, study, h);
            read_times(group, study, h);
        }
        group.refuse_the_rest();
        study.histories.push_back(h);
    }
}

}  // namespace tissue
