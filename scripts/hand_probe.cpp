// Hands with mass, let go on a tissue: hand_probe [--times X] [--stated] [--all] MODEL
// Four hands and devices (tests/haptic/hand.h), force scales 0.5, 1, 2 and 3, four places, 0.1 N, 1 N and as much as the deepest load case takes (3 N at most), on time,
// with jitter and late. One line for each that does not come to rest: within 0.1 mm and 5 % of force after 2 s, the passivity controller in less than 1 % of
// ticks, the force within 2 % of the model's own equilibrium there (not of one that relaxes). The last line says how many of how many.
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

/// In shares of the tissue's box, from its lowest corner (D).
Point place_in(const SpringMesh& mesh, double x, double y, double up) {
    const Point low = mesh.nodes.colwise().minCoeff().transpose(), high = mesh.nodes.colwise().maxCoeff().transpose();
    Point share(low.size());
    share[0] = x;
    if (share.size() == 3) share[1] = y;
    share[share.size() - 1] = up;
    return low + share.cwiseProduct(high - low);
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
    const struct {
        const char* name;
        double x, y, up;
    } places[] = {{"top", 0.5, 0.5, 1}, {"beside", 0.27, 0.62, 1}, {"side", 0, 0.45, 0.6}, {"corner", 0.98, 0.98, 1}};

    int moving = 0, tried = 0, refused = 0;
    for (const double force_scale : {0.5, 1.0, 2.0, 3.0}) {
        HapticOptions options;
        options.heuristic_mesh = false;
        options.map.force_scale = force_scale;
        const HapticModel model(tissue, options);
        for (const auto& at : places) {
            const FreeSurface::Place place = surface.nearest(place_in(tissue.mesh, at.x, at.y, at.up));
            double full_N = tissue.contact_force_N.size() > 0 ? force_scale * tissue.contact_force_N.rowwise().norm().maxCoeff() / 2 : 0;
            if (answer) {
                const Equilibrium deepest = answer->at(place.point_m, depth_m * place.inward);
                full_N = deepest ? force_scale * deepest.contact_force.norm() : 0;
            }
            if (!(full_N > 0)) continue;
            for (const Hand& hand : hands)
                for (const test::Clock& clock : clocks)
                    for (const double force_N : {0.1, 1.0, full_N}) {
                        const HapticMesh& mesh = *model.meshes[0];
                        const double felt = mesh.contact_N_m * force_scale * options.dt_s * options.dt_s / hand.mass_kg;
                        DeviceImpedance device;
                        device.mass_kg = hand.mass_kg;
                        if (o.stated && mesh.contact_N_m * force_scale > stable_stiffness_N_m(device, options.dt_s, mesh.lead)) {
                            ++refused;
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
                        if (rests && !o.all) continue;
                        std::cout << fmt::format("force scale {:3.1f}  {:6} {:10} {:13} K dt^2 / m {:5.3f} {:6.3f} N: swing {:7.4f} mm {:6.3f} N, controller {:5.1f} %, off equilibrium {:+6.1f} %, faults {}{}{}\n", force_scale, at.name,
                                                 hand.name, clock.name, felt, rest.force_N, 1e3 * rest.swing_m, rest.swing_N, 100 * rest.controlled, 100 * off, rest.faults, rest.contact ? "" : ", no contact", rests ? ", rests" : "");
                    }
        }
        if (force_scale == 3)
            std::cout << fmt::format("{} times {:g}, {:.0f} N/m at once, {} steps a tick: {} of {} do not come to rest, {} left out\n", o.model, o.times, model.meshes[0]->contact_N_m, model.meshes[0]->substeps, moving, tried, refused);
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
