#include "api/session_options.h"

#include <fmt/format.h>

#include <charconv>
#include <sstream>

#include "error.h"

namespace tissue {
namespace {

double number(const std::string& name, const std::string& value) {
    double number = 0;
    const char* end = value.data() + value.size();
    const auto [at, error] = std::from_chars(value.data(), end, number);
    if (error != std::errc() || at != end) throw MismatchError(fmt::format("option '{}': '{}' is not a number", name, value));
    return number;
}

bool yes(const std::string& name, const std::string& value) {
    if (value == "yes") return true;
    if (value == "no") return false;
    throw MismatchError(fmt::format("option '{}': '{}' is neither yes nor no", name, value));
}

struct Option {
    const char* name;
    void (*set)(HapticOptions&, const std::string& name, const std::string& value);
};

// clang-format off
const Option options[] = {
    {"sets", [](HapticOptions& o, const std::string&, const std::string& v) { o.sets = v; }},
    {"select-by", [](HapticOptions& o, const std::string& n, const std::string& v) {
        if (v != "displacement" && v != "force") throw MismatchError(fmt::format("option '{}': '{}' is neither displacement nor force", n, v));
        o.select_by = v == "force" ? SelectBy::force : SelectBy::displacement; }},
    {"innovation", [](HapticOptions& o, const std::string& n, const std::string& v) { o.innovation = number(n, v); }},
    {"dynamics", [](HapticOptions& o, const std::string&, const std::string& v) { o.dynamics = v; }},
    {"coupling", [](HapticOptions& o, const std::string& n, const std::string& v) { o.coupling_ratio = number(n, v); }},
    {"damping", [](HapticOptions& o, const std::string& n, const std::string& v) { o.damping_ratio = number(n, v); }},
    {"friction", [](HapticOptions& o, const std::string& n, const std::string& v) { o.friction.stick = number(n, v); }},
    {"friction-slip", [](HapticOptions& o, const std::string& n, const std::string& v) { o.friction.slip = number(n, v); }},
    {"force-max", [](HapticOptions& o, const std::string& n, const std::string& v) { o.safety.force_max_N = number(n, v); }},
    {"slew", [](HapticOptions& o, const std::string& n, const std::string& v) { o.safety.slew_N_s = number(n, v); }},
    {"speed-max", [](HapticOptions& o, const std::string& n, const std::string& v) { o.safety.speed_max_m_s = number(n, v); }},
    {"force-scale", [](HapticOptions& o, const std::string& n, const std::string& v) { o.map.force_scale = number(n, v); }},
    {"scale", [](HapticOptions& o, const std::string& n, const std::string& v) { o.map.scale = number(n, v); }},
    {"axes", [](HapticOptions& o, const std::string&, const std::string& v) { o.map.axes = parse_axes(v); }},
    {"offset", [](HapticOptions& o, const std::string& n, const std::string& v) {
        std::istringstream words(v);
        std::vector<double> offset;
        for (std::string word; words >> word;) offset.push_back(number(n, word));
        if (offset.size() != 2 && offset.size() != 3) throw MismatchError(fmt::format("option '{}': '{}' is not two or three numbers", n, v));
        o.map.offset_m = Eigen::Map<const Eigen::VectorXd>(offset.data(), static_cast<Eigen::Index>(offset.size())); }},
    {"dt", [](HapticOptions& o, const std::string& n, const std::string& v) { o.dt_s = number(n, v); }},
    {"passivity", [](HapticOptions& o, const std::string& n, const std::string& v) { o.safety.passivity = yes(n, v); }},
    {"heuristic", [](HapticOptions& o, const std::string& n, const std::string& v) { o.heuristic_mesh = yes(n, v); }},
};
// clang-format on

}  // namespace

std::vector<std::string> session_option_names() {
    std::vector<std::string> names;
    for (const Option& option : options) names.emplace_back(option.name);
    return names;
}

void set_option(HapticOptions& haptic, const std::string& name, const std::string& value) {
    for (const Option& option : options)
        if (name == option.name) return option.set(haptic, name, value);
    if (name == "stale") throw MismatchError("there is no option 'stale': a position of this interface has no age; say elapsed_s");
    if (name == "energy-book") throw MismatchError("there is no option 'energy-book': nothing of this interface reads it; tissue-haptic --energy-book does");
    throw MismatchError(fmt::format("there is no option '{}'", name));
}

}  // namespace tissue
