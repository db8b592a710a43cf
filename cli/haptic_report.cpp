#include "haptic_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "eval/statistics_json.h"
#include "io/one_line.h"
#include "version.h"

namespace tissue::cli {
namespace {

using Json = nlohmann::ordered_json;

Json percentiles(const Histogram& h) {
    return {{"p50", h.percentile(0.5)}, {"p99", h.percentile(0.99)}, {"p999", h.percentile(0.999)}, {"max", h.max()}};
}

std::string percentiles_text(const Histogram& h) {
    return fmt::format("{:.1f} / {:.1f} / {:.1f} / {:.1f} us", h.percentile(0.5), h.percentile(0.99), h.percentile(0.999),
                       h.max());
}

long long refused(const SafetyCounters& c) {
    return c.bad_input + c.jump + c.stale;
}

Json numbers(const Point& p) { return std::vector<double>(p.data(), p.data() + p.size()); }

std::string names(const std::vector<Device*>& devices) {
    std::string text = devices.front()->name();
    for (std::size_t t = 1; t < devices.size(); ++t) text += " and " + devices[t]->name();
    return text;
}

Json optional(const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
}

}  // namespace

std::string describe(const std::string& program, const Simulation& simulation, const std::vector<Device*>& devices) {
    const HapticModel& model = simulation.model();
    const HapticOptions& o = model.options;
    const std::string stiffness =
        model.is_energy_model() ? "an energy model" : fmt::format("spring sets {} (nearest, by {})", o.sets, o.select_by == SelectBy::force ? "force" : "displacement");
    std::string text = fmt::format("{}: study '{}', {}, device {}\n", program, model.study, stiffness, names(devices));
    if (model.is_solid())
        for (std::size_t k = 0; k < model.tools.size(); ++k)
            text += fmt::format("  tool{}: {} of {:g} mm radius\n", model.tools.size() > 1 ? fmt::format(" {}", k + 1) : "", to_string(model.tools[k].shape), 1e3 * model.tools[k].radius_m);
    for (const auto& mesh : model.meshes)
        text += fmt::format("  {:<10} {} step{}: omega dt = {:.3f} (symplectic up to {:g} a step), lowest mode {:.3g} Hz, damping {:.3g}/s\n",
                            mesh->name, mesh->dynamics, mesh->substeps > 1 ? fmt::format(", {} a tick", mesh->substeps) : "",
                            std::sqrt(mesh->largest_eigenvalue_1_s2) * o.dt_s, mesh->energy_model ? 1.4 : 1.8, mesh->lowest_frequency_Hz, mesh->damping_1_s);
    for (const auto& mesh : model.meshes)
        if (const double wanted_s = contact_damping_s(o.dt_s, mesh->substeps); mesh->contact_damping_s < wanted_s)
            text += fmt::format("  the {} mesh: its steps allow a contact damping of {:.2f} ms times the stiffness, not of {:.2f}\n", mesh->name, 1e3 * mesh->contact_damping_s, 1e3 * wanted_s);
    if (model.stiffness && model.stiffness->without_stiffness() > 0)
        text += fmt::format("  the {} mesh has zero-energy modes: its shape at rest is not determined\n", model.is_energy_model() ? "heuristic" : "learned");
    text += fmt::format("  coupling {}\n", model.stiffness ? fmt::format("up to {:.3g} N/m", *o.coupling_ratio * model.stiffness->largest()) : "none: the contact of the energy model");
    for (int t = 0; t < simulation.tool_count(); ++t) {
        const HapticOptions& own = simulation.options(t);
        text += fmt::format("  {}force scale {:g}, position scale {:g}, at most {:g} N, {:g} N/s, {:g} m/s\n", t == 0 ? "" : "second tool: ", own.map.force_scale, own.map.scale, own.safety.force_max_N, own.safety.slew_N_s,
                            own.safety.speed_max_m_s);
    }
    return text;
}

namespace {

std::string tool_text(const Device& device, const Simulation& simulation, int tool) {
    const SafetyCounters& s = simulation.safety(tool).counters();
    std::string text;
    text += fmt::format("  largest force    {:.4g} N, clamped {}, slewed {}, damped {}, capped {}\n", s.force_max_N, s.clamped, s.slewed, s.damped, s.capped);
    text += fmt::format("  energy injected  {:.4g} J\n", s.energy_given_J);
    text += fmt::format("  refused input    {} (invalid {}, jumps {}, stale {})\n", refused(s), s.bad_input, s.jump, s.stale);
    text += fmt::format("  no force         not yet outside {}, ticks too late {}\n", simulation.unarmed(tool), s.late);
    for (const auto& [name, value] : device.statistics()) text += fmt::format("  device {:<24} {:g}\n", name, value);
    if (const std::string fault = device.last_error(); !fault.empty()) text += fmt::format("  device error     {}\n", one_line(fault));
    return text;
}

void add_tool(Json& j, Json& details, const Device& device, const Simulation& simulation, int tool) {
    const SafetyCounters& s = simulation.safety(tool).counters();
    j["device"] = device.name();
    j["force_max_N"] = s.force_max_N;
    j["clamped"] = s.clamped;
    j["energy_given_J"] = s.energy_given_J;
    j["bad_input"] = refused(s);
    details["force_scale"] = simulation.options(tool).map.force_scale;
    details["slewed"] = s.slewed;
    details["damped"] = s.damped;
    details["capped"] = s.capped;
    details["not_finite"] = s.bad_input;
    details["jumps"] = s.jump;
    details["stale"] = s.stale;
    details["late"] = s.late;
    details["not_yet_outside"] = simulation.unarmed(tool);
    for (const auto& [name, value] : device.statistics()) details["device"][name] = value;
    if (const std::string fault = device.last_error(); !fault.empty()) details["device_error"] = one_line(fault);
}

}  // namespace

std::string statistics_text(const std::string& model_file, const std::vector<Device*>& devices, const Simulation& simulation, const LoopReport& report, long long dropped_samples) {
    const HapticCounters& h = simulation.counters();
    std::string text = fmt::format("{} on {}: {} ticks{}\n", model_file, names(devices), report.ticks, report.clock ? "" : ", without a clock");
    text += fmt::format("  overruns         {} ({} by this program)\n", report.misses, report.misses_program);
    text += fmt::format("  tick             {} (median / p99 / p99.9 / max)\n", percentiles_text(report.tick_us));
    text += fmt::format("  latency          {}\n", percentiles_text(report.lateness_us));
    text += fmt::format("  dropped samples  {}\n", dropped_samples);
    if (simulation.model().options.energy_book) {
        const BranchEnergies book = simulation.branches();
        text += fmt::format("  Maxwell branches stored {:.4g} J, dissipated {:.4g} J\n", book.stored_J, book.dissipated_J);
    }
    text += fmt::format("  tissue           outline folded {}, mesh diverged {}, time lost {:.3g} s\n", h.folded, h.unstable, h.lost_s);
    for (int t = 0; t < simulation.tool_count(); ++t) text += (t == 0 ? "" : "second tool\n") + tool_text(*devices[static_cast<std::size_t>(t)], simulation, t);
    return text;
}

std::string statistics_json(const std::string& model_file, const std::vector<Device*>& devices, const Simulation& simulation, const LoopReport& report, long long dropped_samples) {
    const HapticCounters& h = simulation.counters();
    const HapticModel& model = simulation.model();
    Json j = {{"model", model_file},
              {"device", nullptr},
              {"ticks", report.ticks},
              {"misses", report.misses},
              {"misses_program", report.misses_program},
              {"tick_us", percentiles(report.tick_us)},
              {"lateness_us", percentiles(report.lateness_us)},
              {"dropped_samples", dropped_samples}};
    Json details;
    for (const auto& mesh : model.meshes)
        details["dynamics"][mesh->name] = {{"step", mesh->dynamics},
                                           {"substeps", mesh->substeps},
                                           {"omega_dt", std::sqrt(mesh->largest_eigenvalue_1_s2) * model.options.dt_s}};
    if (model.options.energy_book) {
        const BranchEnergies book = simulation.branches();
        details["branches"] = {{"stored_J", book.stored_J}, {"dissipated_J", book.dissipated_J}};
    }
    details["lost_s"] = h.lost_s;
    details["clock"] = report.clock;
    details["folded"] = h.folded;
    details["unstable"] = h.unstable;
    details["notices"] = report.notices;
    add_tool(j, details, *devices.front(), simulation, 0);
    j["details"] = details;
    for (int t = 1; t < simulation.tool_count(); ++t) {
        Json second, more;
        add_tool(second, more, *devices[static_cast<std::size_t>(t)], simulation, t);
        second["details"] = more;
        j["second"] = second;
    }
    return j.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // a file's name may be any bytes
}

std::string realtime_json(const HapticModel& model, const std::vector<IndentationResult>& indentations,
                          const std::vector<SwitchJump>& jumps) {
    Json j = {{"study", model.study}, {"version", version}, {"sets", model.is_energy_model() ? Json(nullptr) : Json(model.options.sets)}, {"dt_s", model.options.dt_s}};
    for (const auto& mesh : model.meshes)
        j["dynamics"][mesh->name] = {{"step", mesh->dynamics},
                                     {"substeps", mesh->substeps},
                                     {"omega_dt", std::sqrt(mesh->largest_eigenvalue_1_s2) * model.options.dt_s},
                                     {"lowest_frequency_Hz", mesh->lowest_frequency_Hz},
                                     {"damping_1_s", mesh->damping_1_s}};
    constexpr double missing = std::numeric_limits<double>::infinity(), nothing = std::numeric_limits<double>::quiet_NaN();
    // an indentation without an answer has an infinite error, one without an FE reference NaN
    std::vector<double> against_static, against_fe, static_against_fe;
    Json list = Json::array();
    for (const IndentationResult& p : indentations) {
        against_static.push_back(p.reason.empty() ? p.static_error : missing);
        const double unanswered = p.fe_asked ? missing : nothing;
        against_fe.push_back(p.reason.empty() ? p.fe_error.value_or(unanswered) : unanswered);
        static_against_fe.push_back(p.reason.empty() ? p.static_fe_error.value_or(unanswered) : unanswered);
        Json entry = {{"name", p.name}, {"rested", p.rested}, {"seconds", p.seconds}};
        if (!model.is_energy_model()) entry["set"] = p.set;
        if (p.reason.empty()) {
            entry["static_error"] = p.static_error;
            entry["fe_error"] = optional(p.fe_error);
            entry["static_fe_error"] = optional(p.static_fe_error);
        } else {
            entry["static_error"] = nullptr;
            entry["reason"] = p.reason;
        }
        entry["off_contact_m"] = p.off_contact_m;
        entry["displacement_m"] = numbers(p.displacement_m);
        entry["force_N"] = numbers(p.force_N);
        entry["static_N"] = numbers(p.static_N);
        entry["energy_given_J"] = p.energy_given_J;
        entry["curve"] = {{"time_s", p.time_s}, {"depth_m", p.depth_m}, {"force_N", p.curve_N}};
        list.push_back(entry);
    }
    j["static_error"] = to_value(statistics_of(against_static));
    j["fe_error"] = to_value(statistics_of(against_fe));
    j["static_fe_error"] = to_value(statistics_of(static_against_fe));
    j["presses"] = list;
    Json switches = Json::array();
    for (const SwitchJump& s : jumps)
        switches.push_back({{"from", s.from},
                            {"to", s.to},
                            {"innovation", s.innovation},
                            {"energy_jump_J", s.energy_jump_J},
                            {"energy_bound_J", s.energy_bound_J},
                            {"force_jump_N", s.force_jump_N},
                            {"curve", {{"time_s", s.time_s}, {"force_N", s.force_N}, {"energy_J", s.energy_J}}}});
    j["switches"] = switches;
    return j.dump(1) + "\n";
}

}  // namespace tissue::cli
