#include "haptic/session_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "error.h"
#include "haptic/dynamics_kinds.h"

namespace tissue {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
using O = HapticOptions;

[[noreturn]] void refuse(const SessionOption& option, const std::string& wanted, const std::string& given) {
    throw MismatchError(fmt::format("{} must {}, not {}", option.name, wanted, given));
}

double number(const SessionOption& option, const std::string& text, const char* wanted = "be a number") {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || at != end) refuse(option, wanted, "'" + text + "'");
    return value;
}

void read(const SessionOption& o, const std::string& text, double& to) { to = number(o, text); }
void read(const SessionOption& o, const std::string& text, std::optional<double>& to) {
    if (text == "default") to.reset();
    else to = number(o, text);
}
void read(const SessionOption& o, const std::string& text, int& to) {
    const double value = number(o, text);
    if (value != std::floor(value) || !(std::abs(value) < 1e9)) refuse(o, "be a whole number", "'" + text + "'");
    to = static_cast<int>(value);
}
void read(const SessionOption&, const std::string& text, bool& to) { to = text == "yes"; }
void read(const SessionOption&, const std::string& text, std::string& to) { to = text; }
void read(const SessionOption&, const std::string& text, SelectBy& to) { to = text == "force" ? SelectBy::force : SelectBy::displacement; }
void read(const SessionOption&, const std::string& text, ToolChoice& to) { to = tool_choice(text); }
void read(const SessionOption&, const std::string& text, decltype(DeviceMap::axes)& to) { to = parse_axes(text); }
void read(const SessionOption& o, const std::string& text, Point& to) {
    std::istringstream words(text);
    std::vector<double> values;
    for (std::string word; words >> word;) values.push_back(number(o, word, "be two or three numbers"));
    if (values.size() != 2 && values.size() != 3) refuse(o, "be two or three numbers", "'" + text + "'");
    to = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::vector<double> numbers_in(double value) { return {value}; }
std::vector<double> numbers_in(int value) { return {static_cast<double>(value)}; }
std::vector<double> numbers_in(const std::optional<double>& value) { return value ? numbers_in(*value) : std::vector<double>(); }
std::vector<double> numbers_in(const Point& p) { return {p.data(), p.data() + p.size()}; }
template <class Other> std::vector<double> numbers_in(const Other&) { return {}; }

std::string shown(bool value) { return value ? "yes" : "no"; }
std::string shown(const std::string& value) { return value; }
std::string shown(SelectBy value) { return value == SelectBy::force ? "force" : "displacement"; }
std::string shown(const ToolChoice& value) { return to_string(value); }
template <class Numbers> std::string shown(const Numbers& value) { return fmt::format("{}", fmt::join(numbers_in(value), " ")); }

Allowed one_of(std::vector<std::string> words) {
    Allowed allowed;
    allowed.words = std::move(words);
    return allowed;
}

std::vector<std::string> steps() {
    std::vector<std::string> names = {"auto"};
    names.insert(names.end(), dynamics_kinds().names().begin(), dynamics_kinds().names().end());
    return names;
}

}  // namespace

const std::vector<SessionOption>& session_options() {
    static const Allowed any{}, positive{0}, up_to_half_s{0, 0.5, false, true}, yes_no = one_of({"yes", "no"});
    // clang-format off
    static const std::vector<SessionOption> rows = {
        {"sets", "NAME", any, everywhere, [](O& o) -> auto& { return o.sets; }, "spring sets to play: an optimiser of the model, or optimum",
         "Default: the model's first. An energy model has no spring sets and refuses it."},
        {"select-by", "NAME", one_of({"displacement", "force"}), everywhere, [](O& o) -> auto& { return o.select_by; }, "what selects the nearest spring set",
         "Displacement of the contact, or the force on it as in the paper. An energy model refuses force."},
        {"innovation", "1", {0, 1, false, true}, everywhere, [](O& o) -> auto& { return o.innovation; }, "smoothing gain of spring sets, gamma of (19)",
         "The share of a newly selected set in each dt; at 0.05 it takes over within about 0.06 s. An energy model averages no sets and refuses it.", "0.05"},
        {"dynamics", "NAME", one_of(steps()), everywhere, [](O& o) -> auto& { return o.dynamics; }, "time integration of the meshes",
         "The value auto chooses by the stiffest mode and the time step; paper is (13)-(15) as printed, unstable at any useful step."},
        {"coupling", "1", positive, everywhere, [](O& o) -> auto& { return o.coupling_ratio; }, "coupling stiffness over the contact's own, on a mesh of springs",
         "At 10 the tool sinks in by a tenth more. Refused where no mesh of springs is played.", "10"},
        {"damping", "1", {0, inf, true}, everywhere, [](O& o) -> auto& { return o.damping_ratio; }, "damping ratio of the lowest mode; of an energy model 0.17, of one that relaxes 0.01",
         "0.05 of spring sets is the paper's \"very small values\". With 0.17 an energy model comes to rest before a hand notices. Maxwell branches damp by themselves.", "0.05"},
        {"tool", "TOOL", any, everywhere, [](O& o) -> auto& { return o.tool; }, "tool that presses tissue in space: disc, disc:0.005, ball:0.004",
         "By default the disc that the model has. A model that was trained under discs of several radii plays with any disc between the smallest and the largest, and with a ball whose contact, when half of the ball is in, is between those radii. The contact of a ball grows as it goes in; the device's position is the point of the ball that touches. Other tools are refused. A model that relaxes refuses balls; a session that learns refuses every tool but its own disc."},
        {"tools", "1", {1, most_tools, true, true}, tissuectl_serve | interfaces, [](O& o) -> auto& { return o.tools; }, "how many devices press the tissue at once, each with a tool of its own",
         "Two press an energy model without the heuristic mesh beside it; on the page of tissuectl serve two fingers lead them, or one stays in the tissue while the other presses. tissue-haptic has --second-device. Both tools have the shape and size of option tool; map, friction, limits and what is known of the device may be set for each. Tools nearer to each other than three radii hold nodes of the lattice in common: nothing is refused, and the error of the force is larger (RESULTS.md); nearer than two it was not measured. Whether a device can show the tissue is judged for one tool alone: near the other one the tissue is stiffer."},
        {"friction", "1", {0, inf, true, true}, everywhere | live, [](O& o) -> auto& { return o.friction.stick; }, "static friction coefficient between tool and tissue; inf: the tool never slips",
         "The paper's contact keeps its place, which is inf."},
        {"friction-slip", "1", {0, inf, true}, everywhere | live, [](O& o) -> auto& { return o.friction.slip; }, "kinetic friction coefficient, at most the static one",
         "Default: the static one. Refused without friction. \"default\" resets it."},
        {"heuristic", "yes|no", yes_no, everywhere, [](O& o) -> auto& { return o.heuristic_mesh; }, "a second mesh, Van Gelder's, beside the learned one",
         "Off by default in C and Python, whose programs have a scene of their own."},
        {"force-max", "N", positive, everywhere | limits, [](O& o) -> auto& { return o.safety.force_max_N; }, "largest force on the device",
         "3.3 N is the limit of a Touch at its nominal position. An energy model's tissue gets no more, in tissue's newtons: where more would be needed the tool stays behind the hand. A session without a device, whose host reads the tissue's force, sets it high."},
        {"slew", "N/s", positive, everywhere | limits, [](O& o) -> auto& { return o.safety.slew_N_s; }, "fastest rise of force",
         "5000 N/s is five newtons a tick of 0.001 s, more than a Touch has. Force falls at once: where the tissue's rises faster than slew lets it, a hand that comes back quickly gets more energy than it gave, within the bound."},
        {"speed-max", "m/s", positive, everywhere | limits, [](O& o) -> auto& { return o.safety.speed_max_m_s; }, "a faster device is a fault: the position is refused, the force is zero",
         "Judged over dt at least: a device that measures more often may use at once what it left unused within the last dt. Hands at work stay below about 1 m/s."},
        {"stale", "s", up_to_half_s, everywhere | limits, [](O& o) -> auto& { return o.safety.stale_s; }, "an older position is a fault",
         "In C and Python the age of a position is an argument of the tick, 0 by default."},
        {"passivity", "yes|no", yes_no, everywhere | limits, [](O& o) -> auto& { return o.safety.passivity; }, "passivity observer and controller",
         "lib/haptic/safety.h has the bound on energy that they keep."},
        {"force-scale", "1", positive, everywhere | live, [](O& o) -> auto& { return o.map.force_scale; }, "force on the device over force on the tissue", ""},
        {"scale", "1", positive, tissue_haptic | interfaces | live, [](O& o) -> auto& { return o.map.scale; }, "displacement in the tissue over displacement of the device", ""},
        {"axes", "A,A[,A]", any, tissue_haptic | interfaces | live, [](O& o) -> auto& { return o.map.axes; }, "device axes of the tissue's, as in x,-z in the plane and x,-z,y in space",
         "Default: the first ones."},
        {"offset", "m", any, tissue_haptic | interfaces | live, [](O& o) -> auto& { return o.map.offset_m; }, "the device's origin in the tissue's space, two or three numbers",
         "Default: none. One number for each axis of the model."},
        {"rotation", "rad", {-100, 100, true, true}, tissue_haptic | interfaces | live, [](O& o) -> auto& { return o.map.rotation_rad; }, "rotation of the device before axes: a turn by the length of this vector about its direction, three numbers",
         "0 0 1.5708 takes the device's x to its y. Default: none."},
        {"device-mass", "kg", {0, inf, true}, everywhere | live, [](O& o) -> auto& { return o.device.mass_kg; }, "apparent mass of the device at its tool, without a hand; 0: not known",
         "A tissue that no hand could hold still on a device of this mass is refused, with the largest force-scale that is possible; it is judged at dt, which a host that ticks more slowly states as its own. A Touch has 0.045 kg, and its force follows a position one servo period late; tissue-haptic knows both. Nothing is promised for positions that are older than they say, or, of a device that is not known, older than half of dt. Without a mass nothing is refused, and nothing promised."},
        {"device-damping", "Ns/m", {0, inf, true}, everywhere | live, [](O& o) -> auto& { return o.device.damping_Ns_m; }, "viscous damping of the device itself; device-mass is set first",
         "It makes a stiffer tissue possible. Data sheets seldom have it; 0 relies on none."},
        {"device-stiffness", "N/m", {0, inf, false, true}, everywhere | live, [](O& o) -> auto& { return o.device.stiffness_N_m; }, "largest stiffness that the device can show; inf: not known",
         "A tissue that is stiffer at rest is refused, with the largest force-scale that is possible. A Touch has 1020 N/m on its softest axis."},
        {"device-rate", "Hz", {0, inf, false, true}, everywhere | live, [](O& o) -> auto& { return o.device.rate_Hz; }, "rate at which the device measures positions and takes forces; inf: that of the ticks",
         "With device-mass a device that is slower than the ticks is judged by its own period, over which the force leads the hand by little: without damping of its own it is refused, and dt should be its period. A Touch has 1000 Hz."},
        {"hold", "s", {2e-6, inf, true, true}, interfaces, [](O& o) -> auto& { return o.safety.hold_s; }, "how long the device keeps a force without a new one",
         "A host must see to it that the force is gone by then: energy that a device gives later is in no log. In a tick that comes later than half of it the force rises from zero again, so that a host at 50 Hz or more loses none by default. A shorter one bounds the energy after a stall closer. inf: the force stays until the next tick, and all that it gives is in the log; so it serves hosts from 10 Hz on. The devices of the programs let go within 0.01 s."},
        {"dt", "s", {1e-6, longest_dt_s, true, true}, interfaces, [](O& o) -> auto& { return o.dt_s; }, "time step of a tick",
         "Of 1e-6 s the loop's clock, which counts nanoseconds, rounds less than a thousandth. At most half of hold; 0.025 s, 40 Hz, is the longest period that a host may state. The time that a host's ticks really take is elapsed_s; this is the one that damping of the contact and the checks on a device are for. Programs tick at 1 kHz."},
        {"energy-book", "yes|no", yes_no, tissue_haptic | interfaces, [](O& o) -> auto& { return o.energy_book; }, "energy log of a model that relaxes: stored and dissipated in its branches",
         "A step takes a little longer. Refused by a model that does not relax."},
    };
    // clang-format on
    return rows;
}

std::string SessionOption::values() const {
    if (!is_number()) return fmt::format("{}", fmt::join(allowed.words, ", "));
    return fmt::format("{}{:g}, {:g}{}", allowed.with_low ? '[' : '(', allowed.low, allowed.high, allowed.with_high ? ']' : ')');
}

std::string SessionOption::initial(Where place) const {
    HapticOptions options = place == interfaces ? interface_options() : HapticOptions();
    const std::string text = std::visit([&](auto of) { return shown(of(options)); }, field);
    return text.empty() ? unset : text;
}

void SessionOption::set(HapticOptions& options, const std::string& text) const {
    const auto& words = allowed.words;
    if (!words.empty() && std::find(words.begin(), words.end(), text) == words.end()) refuse(*this, "be one of " + values(), "'" + text + "'");
    std::visit([&](auto of) { read(*this, text, of(options)); }, field);
}

void SessionOption::check(HapticOptions options) const {
    for (const double value : std::visit([&](auto of) { return numbers_in(of(options)); }, field))
        if (!allowed.takes(value)) refuse(*this, fmt::format("lie in {}{}", values(), unit == std::string("1") ? "" : fmt::format(" {}", unit)), fmt::format("{}", value));
}

HapticOptions interface_options() {
    HapticOptions options;
    options.heuristic_mesh = false;
    options.safety.hold_s = 2 * longest_dt_s;
    return options;
}

void set_option(HapticOptions& options, const std::string& name, const std::string& value, unsigned changeable) {
    for (const SessionOption& option : session_options()) {
        if (name != option.name) continue;
        if (!(option.where & changeable)) throw MismatchError(fmt::format(option.where & limits ? "option '{}' may change until the first tick alone" : "option '{}' stays as it was when the session began", name));
        return option.set(options, value);
    }
    throw MismatchError(fmt::format("there is no option '{}'", name));
}

}  // namespace tissue
