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
void read(const SessionOption&, const std::string& text, ToolChoices& to) { to = tool_choices(text); }
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
std::string shown(const ToolChoices& value) { return to_string(value); }
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
        {"sets", "NAME", any, everywhere, [](O& o) -> auto& { return o.sets; }, "spring sets of the session: those of an optimiser of the model, or optimum",
         "Default: those of the model's first optimiser. Refused for an energy model, which has no spring sets."},
        {"select-by", "NAME", one_of({"displacement", "force"}), everywhere, [](O& o) -> auto& { return o.select_by; }, "quantity by which the nearest spring set is selected",
         "Displacement of the contact, or the force on it as in the paper. Force is refused for an energy model."},
        {"innovation", "1", {0, 1, false, true}, everywhere, [](O& o) -> auto& { return o.innovation; }, "smoothing gain of spring sets, gamma of (19)",
         "Weight of a newly selected set in each dt; with 0.05 the change takes about 0.06 s. Refused for an energy model, which has no spring sets.", "0.05"},
        {"dynamics", "NAME", one_of(steps()), everywhere, [](O& o) -> auto& { return o.dynamics; }, "time integration of the meshes",
         "The value auto chooses by the stiffest mode and the time step; paper is (13)-(15) as printed, unstable at any useful time step."},
        {"coupling", "1", positive, everywhere, [](O& o) -> auto& { return o.coupling_ratio; }, "coupling stiffness over the contact's own, on a mesh of spring sets",
         "With 10 the tool's displacement is larger by a tenth. Refused if no mesh of the session has spring sets.", "10"},
        {"damping", "1", {0, inf, true}, everywhere, [](O& o) -> auto& { return o.damping_ratio; }, "damping ratio of the lowest mode; default of an energy model 0.17, of one that relaxes 0.01",
         "For spring sets 0.05 is the paper's \"very small values\". With 0.17 the oscillation of an energy model decays before a hand notices it. Maxwell branches add damping of their own.", "0.05"},
        {"tool", "TOOL", any, everywhere, [](O& o) -> auto& { return o.tool; }, "tool in space: disc, disc:0.005, ball:0.004; of two tools one for each, as disc,ball:0.004",
         "Default: the disc of the model. A model that was trained with discs of several radii accepts any disc between the smallest and the largest, and a ball whose contact at half depth of the ball is between those radii. The contact of a ball grows with its displacement; the device's position is the point of the ball that touches. Other tools are refused. Balls are refused for a model that relaxes; a session that learns accepts only the disc of the model. One tool is for every device of the session; a list separated by commas has one for each."},
        {"tools", "1", {1, most_tools, true, true}, tissuectl_serve | interfaces, [](O& o) -> auto& { return o.tools; }, "number of devices, each with its own tool",
         "Two tools need an energy model without the heuristic mesh. On the page of tissuectl serve two fingers move them, or one stays in the tissue while the other moves. tissue-haptic has --second-device. Option tool has the shape and size of both, or of each; map, friction, limits and properties of the device may be set for each. Tools nearer to each other than three radii share nodes of the lattice: this is not refused, and the error of the force is larger (RESULTS.md); below two radii it was not measured. Whether a device can render the tissue is checked for one tool alone: near the other tool the tissue is stiffer."},
        {"friction", "1", {0, inf, true, true}, everywhere | live, [](O& o) -> auto& { return o.friction.stick; }, "static friction coefficient between tool and tissue; inf: the tool never slips",
         "The paper's contact does not slip, as with inf."},
        {"friction-slip", "1", {0, inf, true}, everywhere | live, [](O& o) -> auto& { return o.friction.slip; }, "kinetic friction coefficient, at most the static one",
         "Default: the static one. Refused without friction. \"default\" resets it."},
        {"grasp-max", "N", {0, inf, false, true}, everywhere | live, [](O& o) -> auto& { return o.grasp_max_N; }, "force on the tissue above which a grasp is released; inf: never",
         "A tool grasps while its button is down (tissue_grasp in C): the tissue that it touches follows it in every direction, without slip, until the button is up. It is also released where force-max / force-scale is below a finite limit and has been reached. After a release the next press of the button begins a new grasp. Refused by a model that cannot grasp: spring sets, and in space a ball, or a contact that was not trained to be pulled (term contact.compression)."},
        {"heuristic", "yes|no", yes_no, everywhere, [](O& o) -> auto& { return o.heuristic_mesh; }, "a second mesh next to the learned one, with Van Gelder's heuristic",
         "Off by default in C and Python, whose programs have their own scene."},
        {"force-max", "N", positive, everywhere | limits, [](O& o) -> auto& { return o.safety.force_max_N; }, "largest force on the device",
         "3.3 N is the limit of a Touch at its nominal position. It limits the force on the tissue of an energy model too, divided by force-scale: where a larger force would be needed, the tool stays behind the hand. Set it high in a session without a device, whose host reads the tissue's force."},
        {"slew", "N/s", positive, everywhere | limits, [](O& o) -> auto& { return o.safety.slew_N_s; }, "largest rate at which the force rises",
         "5000 N/s is five newtons per tick of 0.001 s, more than the force of a Touch. The force falls without this limit: where the tissue's force rises faster than slew, a hand that returns quickly receives more energy than it put in, within the bound on energy."},
        {"speed-max", "m/s", positive, everywhere | limits, [](O& o) -> auto& { return o.safety.speed_max_m_s; }, "largest speed of the device; a faster position is refused, with zero force",
         "It is the motion between two positions over the time between them, dt at least. A device that measures more often may use in one motion what its motions before, within dt, left unused. Hands at work stay below about 1 m/s."},
        {"stale", "s", up_to_half_s, everywhere | limits, [](O& o) -> auto& { return o.safety.stale_s; }, "largest age of a position; an older one is refused, with zero force",
         "In C and Python the age of a position is an argument of the tick, 0 by default."},
        {"passivity", "yes|no", yes_no, everywhere | limits, [](O& o) -> auto& { return o.safety.passivity; }, "passivity observer and controller",
         "lib/haptic/safety.h states the bound on energy that they guarantee."},
        {"force-scale", "1", positive, everywhere | live, [](O& o) -> auto& { return o.map.force_scale; }, "force on the device over force on the tissue", ""},
        {"scale", "1", positive, tissue_haptic | interfaces | live, [](O& o) -> auto& { return o.map.scale; }, "displacement in the tissue over displacement of the device", ""},
        {"axes", "A,A[,A]", any, tissue_haptic | interfaces | live, [](O& o) -> auto& { return o.map.axes; }, "device axis of each axis of the tissue, as in x,-z in the plane and x,-z,y in space",
         "Default: x,y or x,y,z."},
        {"offset", "m", any, tissue_haptic | interfaces | live, [](O& o) -> auto& { return o.map.offset_m; }, "the device's origin in the tissue's space, two or three numbers",
         "Default: none. One number for each axis of the model."},
        {"rotation", "rad", {-100, 100, true, true}, tissue_haptic | interfaces | live, [](O& o) -> auto& { return o.map.rotation_rad; }, "rotation of the device, applied before axes: rotation vector, three numbers; its length is the angle",
         "0 0 1.5708 turns the device's x to its y. Default: none."},
        {"device-mass", "kg", {0, inf, true}, everywhere | live, [](O& o) -> auto& { return o.device.mass_kg; }, "apparent mass of the device at its tool, without a hand; 0: not known",
         "A tissue for which a device of this mass would be unstable in any hand is refused; the message states the largest possible force-scale. The check uses dt: a host that ticks more slowly sets dt to its own period. A Touch has 0.045 kg, and its force follows a position one servo period late; tissue-haptic uses both. Stability is not guaranteed for positions older than their stated age or, with an unknown device, older than half of dt. Without a mass nothing is checked and nothing guaranteed."},
        {"device-damping", "Ns/m", {0, inf, true}, everywhere | live, [](O& o) -> auto& { return o.device.damping_Ns_m; }, "viscous damping of the device itself; set device-mass first",
         "It allows a stiffer tissue. Data sheets seldom state it; 0 assumes none."},
        {"device-stiffness", "N/m", {0, inf, false, true}, everywhere | live, [](O& o) -> auto& { return o.device.stiffness_N_m; }, "largest stiffness that the device can render; inf: not known",
         "A tissue that is stiffer at rest is refused; the message states the largest possible force-scale. A Touch has 1020 N/m on its softest axis."},
        {"device-rate", "Hz", {0, inf, false, true}, everywhere | live, [](O& o) -> auto& { return o.device.rate_Hz; }, "rate at which the device measures positions and takes forces; inf: that of the ticks",
         "With device-mass a device that is slower than the ticks is checked with its own period. The contact's damper is designed for dt: with a dt much shorter than that period a device without damping of its own is refused, so set dt to the period. A Touch has 1000 Hz."},
        {"hold", "s", {2e-6, inf, true, true}, interfaces, [](O& o) -> auto& { return o.safety.hold_s; }, "how long the device keeps a force without a new one",
         "The host must ensure that the force is zero after this time: energy that a device injects later is not in the energy log. In a tick later than half of this time the force rises from zero again; by default a host at 50 Hz or more has no such tick. A shorter time gives a tighter bound on the energy after a stall. inf: the force stays until the next tick, and all of its energy is in the log; this suits hosts from 10 Hz on. The devices of the programs release the force within 0.01 s."},
        {"dt", "s", {1e-6, longest_dt_s, true, true}, interfaces, [](O& o) -> auto& { return o.dt_s; }, "time step of a tick",
         "At 1e-6 s the rounding of the loop's clock, which counts nanoseconds, is below a thousandth. At most half of hold; the longest is 0.025 s, 40 Hz. The measured time between a host's ticks is elapsed_s; dt is the time for which damping of the contact and the checks of a device are designed. Programs tick at 1 kHz."},
        {"energy-book", "yes|no", yes_no, tissue_haptic | interfaces, [](O& o) -> auto& { return o.energy_book; }, "energy log of a model that relaxes: stored and dissipated in its Maxwell branches",
         "A tick takes a little longer. Refused for a model that does not relax."},
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
        if (!(option.where & changeable)) throw MismatchError(fmt::format(option.where & limits ? "option '{}' may change only until the first tick" : "option '{}' cannot change after the session has begun", name));
        return option.set(options, value);
    }
    throw MismatchError(fmt::format("there is no option '{}'", name));
}

}  // namespace tissue
