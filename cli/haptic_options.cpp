#include "haptic_options.h"

#include "error.h"
#include "haptic/dynamics_kinds.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace tissue::cli {

CLI::Validator quiet(CLI::Validator check) {
    check.description("");
    return check;
}

CLI::Option* add_number(CLI::App& app, const char* name, double& value, const char* unit, const char* meaning) {
    // CLI11's ranges let NaN through: it is neither less nor more
    static const CLI::Validator is_number([](std::string& given) { return CLI::detail::to_lower(given).find("nan") == std::string::npos ? std::string() : given + " is no number"; }, "");
    return app.add_option(name, value, meaning)->type_name(unit)->capture_default_str()->check(is_number);
}

void add_haptic_options(CLI::App& app, HapticChoices& c) {
    HapticOptions& h = c.haptic;
    const auto number = [&app](const char* name, double& value, const char* unit, const char* meaning) {
        return add_number(app, name, value, unit, meaning);
    };
    app.add_option("--sets", h.sets, "an optimiser of the model, or optimum")->type_name("NAME");
    app.add_option("--select-by", c.select_by, "the nearest spring set by displacement of the contact, or by force (the paper's)")
        ->type_name("NAME")->capture_default_str()->check(quiet(CLI::IsMember({"displacement", "force"})));
    app.add_option("--innovation", h.innovation, "gamma of (19), of sets: share of the new one a tick")->type_name("1")->default_str("0.05");
    std::vector<std::string> steps = {"auto"};
    steps.insert(steps.end(), dynamics_kinds().names().begin(), dynamics_kinds().names().end());
    app.add_option("--dynamics", h.dynamics, fmt::format("{}", fmt::join(steps, ", ")))
        ->type_name("NAME")->capture_default_str()->check(quiet(CLI::IsMember(steps)));
    app.add_option("--coupling", h.coupling_ratio, "k_C over the contact's own stiffness, on a mesh of springs")->type_name("1")->default_str("10");
    app.add_option("--damping", h.damping_ratio, "of critical, at the lowest mode; of a law 0.17, of one that relaxes 0.01")
        ->type_name("1")->default_str("0.05");
    app.add_option("--friction", h.friction.stick, "static mu between tool and tissue; without it the tool never slips")
        ->type_name("1");
    app.add_option("--friction-slip", h.friction.slip, "kinetic mu; the static one")->type_name("1");
    app.add_flag("--no-heuristic", c.no_heuristic, "only the learned mesh, not Van Gelder's beside it");
    number("--force-max", h.safety.force_max_N, "N", "no force above it goes out");
    number("--slew", h.safety.slew_N_s, "N/s", "fastest change of force");
    number("--speed-max", h.safety.speed_max_m_s, "m/s", "a faster master is a fault");
    number("--stale", h.safety.stale_s, "s", "an older position is a fault");
    app.add_flag("--no-passivity", c.no_passivity, "without passivity observer and controller");
    number("--force-scale", h.map.force_scale, "1", "newtons on the hand a newton of tissue");
    app.add_flag("--no-realtime", c.no_realtime, "do not ask for SCHED_FIFO and locked memory");
}

void settle(HapticChoices& c) {
    HapticOptions& h = c.haptic;
    h.select_by = c.select_by == "force" ? SelectBy::force : SelectBy::displacement;
    h.heuristic_mesh = !c.no_heuristic;
    h.safety.passivity = !c.no_passivity;
    try {
        check_options(h);
    } catch (const MismatchError& e) {
        throw CLI::ValidationError(e.what());
    }
}

}  // namespace tissue::cli
