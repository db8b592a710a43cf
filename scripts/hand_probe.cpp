// Simulated hands with mass, released on a tissue: hand_probe [--times X] [--stated] [--all] MODEL
// First part: four hands and devices (tests/haptic/hand.h), force scales 0.5, 1, 2 and 3, four places, forces of 0.1 N,
// 1 N and that of the deepest load case (3 N at most), on-time ticks, jitter and late ticks. Prints a line for each
// hand that does not come to rest. At rest means: after 2 s the position varies by less than 0.1 mm and the force by
// less than 5 %, the passivity controller acts in less than 1 % of ticks, and the force is within 2 % of the model's
// equilibrium there (not tested for tissue that relaxes).
// Second part: hands that tap at 0.3 m/s, let go in contact, and drag as far as the deepest load case (20 mm at most),
// with friction 0.3 and without slip. Prints a line for each hand that gains energy from the tissue, has the passivity
// controller in 1 % of ticks or more, or has a fault; and for each dragging hand that trembles by 0.05 mm or leaves the
// tissue. The last lines are counts.
//   --times X       a tissue X times as stiff
//   --stated        the mass of each hand is stated (device-mass); what the program then refuses is left out
//   --all           a line for every hand
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <future>
#include <iostream>
#include <optional>
#include <vector>

#include "../tests/haptic/hand.h"
#include "error.h"
#include "mesh/free_surface.h"
#include "springs/equilibrium.h"
#include "springs/indentation_solver.h"
#include "springs/tissue_model.h"

namespace {

using namespace tissue;
using namespace tissue::test;

struct Probe {
    std::string model;
    double times = 1;
    bool stated = false, all = false;
};

constexpr struct {
    const char* name;
    double x, y, up;
} places[] = {{"top", 0.5, 0.5, 1}, {"beside", 0.27, 0.62, 1}, {"side", 0, 0.45, 0.6}, {"corner", 0.98, 0.98, 1}};

/// Contact force [N] at a place at the displacement of the deepest load case: the model's own if it is an energy model,
/// otherwise half the largest contact force of the load cases.
double deepest_force_N(const TissueModel& tissue, std::optional<IndentationSolver>& answer, const FreeSurface::Place& place) {
    if (!answer) return tissue.contact_force_N.size() > 0 ? tissue.contact_force_N.rowwise().norm().maxCoeff() / 2 : 0;
    const Equilibrium deepest = answer->at(place.point_m, tissue.magnitude_m.maxCoeff() * place.inward);
    return deepest ? deepest.contact_force.norm() : 0;
}

/// A point in fractions of the tissue's bounding box, from its lowest corner (D).
Point place_in(const SpringMesh& mesh, double x, double y, double up) {
    const Point low = mesh.own_nodes().colwise().minCoeff().transpose(), high = mesh.own_nodes().colwise().maxCoeff().transpose();
    Point share(low.size());
    share[0] = x;
    if (share.size() == 3) share[1] = y;
    share[share.size() - 1] = up;
    return low + share.cwiseProduct(high - low);
}

/// Counts of hands in motion: those that fail, all that were run, those refused.
struct Moved {
    int wrong = 0, tried = 0, refused = 0;
};

struct Found {
    std::string lines, model;
    int moving = 0, slower = 0, tried = 0, left_out = 0;
    Moved moved;
};

bool refused(const Probe& o, const HapticModel& model, const Hand& hand) {
    DeviceImpedance device;
    device.mass_kg = hand.mass_kg;
    const HapticMesh& mesh = *model.meshes[0];
    return o.stated && mesh.contact_N_m * model.options.map.force_scale > stable_stiffness_N_m(device, model.options.dt_s, mesh.lead);
}

void in_motion(const Probe& o, const TissueModel& tissue, std::optional<IndentationSolver>& answer, const FreeSurface& surface, double force_scale, Found& found) {
    for (const double friction : {std::numeric_limits<double>::infinity(), 0.3}) {
        HapticOptions options;
        options.heuristic_mesh = false;
        options.map.force_scale = force_scale;
        options.friction.stick = friction;
        const HapticModel model(tissue, options);
        for (const auto& at : places) {
            if (at.name == std::string("corner")) continue;  // a dragged tool would leave the surface there
            const FreeSurface::Place place = surface.nearest(place_in(tissue.mesh, at.x, at.y, at.up));
            const double full_N = force_scale * deepest_force_N(tissue, answer, place);
            if (!(full_N > 0)) continue;
            for (const Hand& hand : hands)
                for (const test::Clock& clock : clocks)
                    for (const auto& [deed, name] : {std::pair(Deed::taps, "taps"), std::pair(Deed::lets_go, "lets go"), std::pair(Deed::drags, "drags")}) {
                        if (refused(o, model, hand)) {
                            ++found.moved.refused;
                            continue;
                        }
                        Release release;
                        release.contact_m = place.point_m;
                        release.inward = place.inward;
                        release.force_N = std::min(1.0, full_N);
                        release.drag_m = std::min(0.02, tissue.magnitude_m.maxCoeff());
                        const Ride ride = does(deed, model, hand, clock, release);
                        const bool right = ride.passive() && ride.controlled < 0.01 && ride.faults == 0 && (deed != Deed::drags || (ride.tremor_m < 5e-5 && !ride.lost));
                        ++found.moved.tried;
                        found.moved.wrong += !right;
                        if (right && !o.all) continue;
                        found.lines += fmt::format("force scale {:3.1f}  {:6} {:10} {:13} {:7} friction {:3g}: given at most {:8.2f} uJ of {:8.1f}, tremor {:7.4f} mm, controller {:5.1f} %, faults {}{}{}\n", force_scale, at.name,
                                                 hand.name, clock.name, name, friction, 1e6 * ride.most_given_J, 1e6 * ride.put_in_J, 1e3 * ride.tremor_m, 100 * ride.controlled, ride.faults, ride.lost ? ", off the tissue" : "", right ? ", right" : "");
                    }
        }
    }
}

/// What is found at one force scale.
Found at_scale(const Probe& o, const TissueModel& tissue, double force_scale) {
    std::optional<IndentationSolver> answer;
    const bool relaxes = tissue.energy_model && !tissue.energy_model->relaxation.empty();
    if (tissue.energy_model) answer.emplace(tissue.mesh, relaxes ? long_term(*tissue.energy_model) : *tissue.energy_model);
    const FreeSurface surface(tissue.mesh);
    const double depth_m = tissue.magnitude_m.maxCoeff();
    HapticOptions options;
    options.heuristic_mesh = false;
    options.map.force_scale = force_scale;
    const HapticModel model(tissue, options);
    Found found;
    for (const auto& at : places) {
        const FreeSurface::Place place = surface.nearest(place_in(tissue.mesh, at.x, at.y, at.up));
        const double full_N = force_scale * deepest_force_N(tissue, answer, place);
        if (!(full_N > 0)) continue;
        for (const Hand& hand : hands)
            for (const test::Clock& clock : clocks)
                for (const double force_N : {0.1, 1.0, full_N}) {
                    const double felt = model.meshes[0]->contact_N_m * force_scale * options.dt_s * options.dt_s / hand.mass_kg;
                    if (refused(o, model, hand)) {
                        ++found.left_out;
                        continue;
                    }
                    Release release;
                    release.contact_m = place.point_m;
                    release.inward = place.inward;
                    release.creeps = relaxes;
                    release.force_N = std::min({force_N, 3.0, full_N});
                    release.force_N += hand.stiffness_N_m * depth_m * release.force_N / full_N;
                    const Rest rest = let_go(model, hand, clock, release);
                    double off = 0;
                    if (answer && !relaxes) {
                        const std::optional<Equilibrium> exact = rest.contact ? std::make_optional(answer->at(rest.touched_m, rest.push_m)) : std::nullopt;
                        off = exact && *exact ? exact->contact_force.norm() * force_scale / rest.force_N - 1 : std::numeric_limits<double>::infinity();
                    }
                    const bool rests = rest.swing_m < 1e-4 && rest.swing_N < 0.05 * rest.force_N + 1e-3 && rest.controlled < 0.01 && rest.faults == 0 && std::abs(off) < 0.02;
                    ++found.tried;
                    found.moving += !rests;
                    // not counted: hands of which only the oscillation is too large, within 5 % of what their own damping leaves
                    found.slower += !rests && !(rest.swing_m < 1.05 * rest.damped_m && rest.controlled < 0.01 && rest.faults == 0 && std::abs(off) < 0.02);
                    if (rests && !o.all) continue;
                    found.lines += fmt::format("force scale {:3.1f}  {:6} {:10} {:13} K dt^2 / m {:5.3f} {:6.3f} N: swing {:7.4f} mm {:6.3f} N (own damping leaves {:.4f} mm), controller {:5.1f} %, off equilibrium {:+6.1f} %, faults {}{}{}\n", force_scale, at.name,
                                             hand.name, clock.name, felt, rest.force_N, 1e3 * rest.swing_m, rest.swing_N, 1e3 * rest.damped_m, 100 * rest.controlled, 100 * off, rest.faults, rest.contact ? "" : ", no contact", rests ? ", rests" : "");
                }
    }
    in_motion(o, tissue, answer, surface, force_scale, found);
    found.model = fmt::format("{:.0f} N/m instantaneously, {} steps per tick, lead {:.2f}", model.meshes[0]->contact_N_m, model.meshes[0]->substeps, model.meshes[0]->lead);
    return found;
}

void run(const Probe& o) {
    TissueModel tissue = read_model(o.model);
    if (tissue.energy_model && o.times != 1) {
        tissue.energy_model->constants *= o.times;
        Eigen::VectorXd& scale = tissue.energy_model->contact_log_scale;
        if (scale.size() == 0) scale = Eigen::VectorXd::Zero(tissue.mesh.node_count());
        scale.array() += std::log(o.times);
    }
    std::vector<std::future<Found>> at_scales;
    for (const double force_scale : {0.5, 1.0, 2.0, 3.0}) at_scales.push_back(std::async(std::launch::async, at_scale, o, std::cref(tissue), force_scale));
    Found sum;
    for (std::future<Found>& at : at_scales) {
        const Found found = at.get();
        std::cout << found.lines << std::flush;
        sum.moving += found.moving;
        sum.slower += found.slower;
        sum.tried += found.tried;
        sum.left_out += found.left_out;
        sum.moved.wrong += found.moved.wrong;
        sum.moved.tried += found.moved.tried;
        sum.moved.refused += found.moved.refused;
        sum.model = found.model;
    }
    std::cout << fmt::format("{} times {:g}, {}: {} of {} do not come to rest, {} of these other than by the hand's own damping, {} left out\n", o.model, o.times, sum.model, sum.moving, sum.tried, sum.slower, sum.left_out);
    std::cout << fmt::format("in motion: {} of {} gain energy, oscillate, lose contact while dragging, or need the controller, {} left out\n", sum.moved.wrong, sum.moved.tried, sum.moved.refused);
}

}  // namespace

int main(int argc, char** argv) {
    Probe o;
    CLI::App app("Release hands with mass on a tissue, and check that they come to rest.", "hand_probe");
    app.add_option("model", o.model, "model.h5")->required();
    app.add_option("--times", o.times, "factor of the tissue's stiffness");
    app.add_flag("--stated", o.stated, "leave out cases that device-mass refuses");
    app.add_flag("--all", o.all, "one line per case");
    CLI11_PARSE(app, argc, argv);
    try {
        run(o);
    } catch (const std::exception& e) {
        std::cerr << "hand_probe: " << e.what() << '\n';
        return 1;
    }
}
