// Hands with mass, let go on a tissue: hand_probe [--times X] [--stated] [--all] MODEL
// Four hands and devices (tests/haptic/hand.h), force scales 0.5, 1, 2 and 3, four places, 0.1 N, 1 N and as much as the deepest load case takes (3 N at most), on time,
// with jitter and late. One line for each that does not come to rest: within 0.1 mm and 5 % of force after 2 s, the passivity controller in less than 1 % of
// ticks, the force within 2 % of the model's own equilibrium there (not of one that relaxes). Then hands that tap at 0.3 m/s, let go in contact and drag as far as the
// deepest load case pushes (20 mm at most), with friction 0.3 and without slip:
// one line for each that gets energy out of the tissue, trembles by 0.05 mm or has the passivity controller at work. The last lines say how many of how many.
//   --times X       a tissue X times as stiff
//   --stated        the mass of each hand is stated (device-mass), and what the program refuses then is left out
//   --all           a line for each
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <iostream>
#include <optional>

#include "../tests/haptic/hand.h"
#include "error.h"
#include "mesh/free_surface.h"
#include "springs/equilibrium.h"
#include "springs/law_press.h"
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

/// What as much as the deepest load case takes at a place [N], of the model itself where it has an energy.
double deepest_force_N(const TissueModel& tissue, std::optional<LawPress>& answer, const FreeSurface::Place& place) {
    if (!answer) return tissue.contact_force_N.size() > 0 ? tissue.contact_force_N.rowwise().norm().maxCoeff() / 2 : 0;
    const Equilibrium deepest = answer->at(place.point_m, tissue.magnitude_m.maxCoeff() * place.inward);
    return deepest ? deepest.contact_force.norm() : 0;
}

/// In shares of the tissue's box, from its lowest corner (D).
Point place_in(const SpringMesh& mesh, double x, double y, double up) {
    const Point low = mesh.own_nodes().colwise().minCoeff().transpose(), high = mesh.own_nodes().colwise().maxCoeff().transpose();
    Point share(low.size());
    share[0] = x;
    if (share.size() == 3) share[1] = y;
    share[share.size() - 1] = up;
    return low + share.cwiseProduct(high - low);
}

/// How many of how many hands are not as they should be in motion.
struct Moved {
    int wrong = 0, tried = 0, refused = 0;
};

bool refused(const Probe& o, const HapticModel& model, const Hand& hand) {
    DeviceImpedance device;
    device.mass_kg = hand.mass_kg;
    const HapticMesh& mesh = *model.meshes[0];
    return o.stated && mesh.contact_N_m * model.options.map.force_scale > stable_stiffness_N_m(device, model.options.dt_s, mesh.lead);
}

void in_motion(const Probe& o, const TissueModel& tissue, std::optional<LawPress>& answer, const FreeSurface& surface, double force_scale, Moved& moved) {
    for (const double friction : {std::numeric_limits<double>::infinity(), 0.3}) {
        HapticOptions options;
        options.heuristic_mesh = false;
        options.map.force_scale = force_scale;
        options.friction.stick = friction;
        const HapticModel model(tissue, options);
        for (const auto& at : places) {
            if (at.name == std::string("corner")) continue;  // who drags there falls off
            const FreeSurface::Place place = surface.nearest(place_in(tissue.mesh, at.x, at.y, at.up));
            const double full_N = force_scale * deepest_force_N(tissue, answer, place);
            if (!(full_N > 0)) continue;
            for (const Hand& hand : hands)
                for (const test::Clock& clock : clocks)
                    for (const auto& [deed, name] : {std::pair(Deed::taps, "taps"), std::pair(Deed::lets_go, "lets go"), std::pair(Deed::drags, "drags")}) {
                        if (refused(o, model, hand)) {
                            ++moved.refused;
                            continue;
                        }
                        Release release;
                        release.contact_m = place.point_m;
                        release.inward = place.inward;
                        release.force_N = std::min(1.0, full_N);
                        release.drag_m = std::min(0.02, tissue.magnitude_m.maxCoeff());
                        const Ride ride = does(deed, model, hand, clock, release);
                        const bool right = ride.passive() && ride.controlled < 0.01 && ride.faults == 0 && (deed != Deed::drags || (ride.tremor_m < 5e-5 && !ride.lost));
                        ++moved.tried;
                        moved.wrong += !right;
                        if (right && !o.all) continue;
                        std::cout << fmt::format("force scale {:3.1f}  {:6} {:10} {:13} {:7} friction {:3g}: given at most {:8.2f} uJ of {:8.1f}, tremor {:7.4f} mm, controller {:5.1f} %, faults {}{}{}\n", force_scale, at.name,
                                                 hand.name, clock.name, name, friction, 1e6 * ride.most_given_J, 1e6 * ride.put_in_J, 1e3 * ride.tremor_m, 100 * ride.controlled, ride.faults, ride.lost ? ", off the tissue" : "", right ? ", right" : "");
                    }
        }
    }
}

void run(const Probe& o) {
    TissueModel tissue = read_model(o.model);
    if (tissue.energy_law && o.times != 1) {
        tissue.energy_law->constants *= o.times;
        Eigen::VectorXd& scale = tissue.energy_law->contact_log_scale;
        if (scale.size() == 0) scale = Eigen::VectorXd::Zero(tissue.mesh.node_count());
        scale.array() += std::log(o.times);
    }
    std::optional<LawPress> answer;
    const bool relaxes = tissue.energy_law && !tissue.energy_law->relaxation.empty();
    if (tissue.energy_law) answer.emplace(tissue.mesh, relaxes ? long_term(*tissue.energy_law) : *tissue.energy_law);
    const FreeSurface surface(tissue.mesh);
    const double depth_m = tissue.magnitude_m.maxCoeff();
    int moving = 0, slower = 0, tried = 0, left_out = 0;
    Moved moved;
    for (const double force_scale : {0.5, 1.0, 2.0, 3.0}) {
        HapticOptions options;
        options.heuristic_mesh = false;
        options.map.force_scale = force_scale;
        const HapticModel model(tissue, options);
        for (const auto& at : places) {
            const FreeSurface::Place place = surface.nearest(place_in(tissue.mesh, at.x, at.y, at.up));
            const double full_N = force_scale * deepest_force_N(tissue, answer, place);
            if (!(full_N > 0)) continue;
            for (const Hand& hand : hands)
                for (const test::Clock& clock : clocks)
                    for (const double force_N : {0.1, 1.0, full_N}) {
                        const double felt = model.meshes[0]->contact_N_m * force_scale * options.dt_s * options.dt_s / hand.mass_kg;
                        if (refused(o, model, hand)) {
                            ++left_out;
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
                        ++tried;
                        moving += !rests;
                        // swings alone are left, within 5 % of what the hand's own damping leaves: one spring stands for all directions
                        slower += !rests && !(rest.swing_m < 1.05 * rest.damped_m && rest.controlled < 0.01 && rest.faults == 0 && std::abs(off) < 0.02);
                        if (rests && !o.all) continue;
                        std::cout << fmt::format("force scale {:3.1f}  {:6} {:10} {:13} K dt^2 / m {:5.3f} {:6.3f} N: swing {:7.4f} mm {:6.3f} N (own damping leaves {:.4f} mm), controller {:5.1f} %, off equilibrium {:+6.1f} %, faults {}{}{}\n", force_scale, at.name,
                                                 hand.name, clock.name, felt, rest.force_N, 1e3 * rest.swing_m, rest.swing_N, 1e3 * rest.damped_m, 100 * rest.controlled, 100 * off, rest.faults, rest.contact ? "" : ", no contact", rests ? ", rests" : "");
                    }
        }
        in_motion(o, tissue, answer, surface, force_scale, moved);
        if (force_scale < 3) continue;
        std::cout << fmt::format("{} times {:g}, {:.0f} N/m at once, {} steps a tick, lead {:.2f}: {} of {} do not come to rest, {} of these other than by the hand's own damping, {} left out\n", o.model, o.times, model.meshes[0]->contact_N_m, model.meshes[0]->substeps,
                                 model.meshes[0]->lead, moving, tried, slower, left_out);
        std::cout << fmt::format("in motion: {} of {} get energy, tremble, leave the tissue that they drag over or need the controller, {} left out\n", moved.wrong, moved.tried, moved.refused);
    }
}

}  // namespace

int main(int argc, char** argv) {
    Probe o;
    CLI::App app("Hands with mass, let go on a tissue.", "hand_probe");
    app.add_option("model", o.model, "model.h5")->required();
    app.add_option("--times", o.times, "a tissue so many times as stiff");
    app.add_flag("--stated", o.stated, "leave out what device-mass refuses");
    app.add_flag("--all", o.all, "a line for each");
    CLI11_PARSE(app, argc, argv);
    try {
        run(o);
    } catch (const std::exception& e) {
        std::cerr << "hand_probe: " << e.what() << '\n';
        return 1;
    }
}
