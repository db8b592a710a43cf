#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "haptic/simulation.h"

namespace tissue::test {

/// What holds the tool: device and hand as one mass with a damper to the ground and a spring to where it was let go.
struct Hand {
    const char* name;
    double mass_kg, damping_Ns_m, stiffness_N_m;
};

constexpr Hand hands[] = {
    {"45 g alone", 0.045, 0.2, 0},  // a Touch that nobody holds
    {"100 g", 0.1, 1, 0},
    {"150 g", 0.15, 3, 300},
    {"200 g", 0.2, 6, 500},
};

/// When ticks come: period, and what is drawn about it.
struct Clock {
    const char* name;
    double jitter_s, late_share;  ///< a late tick comes one to three periods late
};

constexpr Clock clocks[] = {{"on time", 0, 0}, {"jitter 0.3 ms", 3e-4, 0}, {"2 % late", 0, 0.02}};

/// A hand that is let go at a contact with a constant force, and what becomes of it.
struct Release {
    Point contact_m, inward;   ///< where, and the way in; the force goes that way
    double force_N = 1;
    double seconds = 3.2;
    bool creeps = false;       ///< the tissue relaxes
    double inset_m = 5e-4;     ///< how deep the hand leads the tool before it lets go
};

struct Rest {
    double swing_m = 0;        ///< largest extent of the hand's way in a quarter of a second, after 2 s
    double swing_N = 0;        ///< likewise of the force on the hand
    double force_N = 0;        ///< that the hand pushes with at the end
    double controlled = 0;     ///< share of ticks in which the passivity controller worked
    Point touched_m, push_m, tissue_N;  ///< at the end: contact at rest, tool displacement there, and force of the tool on the tissue
    bool contact = false;      ///< at the end
    int faults = 0;
};

struct Moment {
    double time_s;
    Eigen::Vector3d position_m, force_N;
};

/// Diagonal of the box round a quantity; where the tissue creeps, round how far it is off a straight course.
template <class Of>
double extent(const std::vector<Moment>& way, bool creeps, const Of& of) {
    const Moment &first = way.front(), &last = way.back();
    const Eigen::Vector3d rate = creeps ? Eigen::Vector3d((of(last) - of(first)) / (last.time_s - first.time_s)) : Eigen::Vector3d(Eigen::Vector3d::Zero());
    Eigen::Vector3d low = of(first), high = low;
    for (const Moment& m : way) {
        const Eigen::Vector3d at = of(m) - rate * (m.time_s - first.time_s);
        low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
    return (high - low).norm();
}

/// Integrates the hand with twenty steps a tick, the force held between two ticks, as a device holds it.
inline Rest let_go(const HapticModel& model, const Hand& hand, const Clock& clock, const Release& release) {
    constexpr int steps = 20;
    const double dt = model.options.dt_s, window_s = 0.25, ramp_s = 0.2;
    Simulation simulation(model);
    std::mt19937_64 random(2008);
    const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
    const auto device = [&](const Point& p) { return model.options.map.to_device(p); };
    const Eigen::Vector3d push = (model.options.map.axes.transpose() * (release.force_N * release.inward)).eval();

    Rest rest;
    DeviceSample sample;
    Eigen::Vector3d force = Eigen::Vector3d::Zero(), v = force;
    // led to just inside of the surface
    const int lead = static_cast<int>(0.3 / dt);
    for (int k = 0; k <= lead; ++k) {
        const double s = static_cast<double>(k) / lead;
        sample.position_m = device(release.contact_m + (-0.003 + (0.003 + release.inset_m) * s) * release.inward);
        force = simulation.tick(sample);
    }
    Eigen::Vector3d x = sample.position_m;
    const Eigen::Vector3d anchor = x;
    const long long damped_before = simulation.safety().counters().damped;
    double time = 0, offset = 0;
    long long ticks = 0;
    std::vector<Moment> way;
    while (time < release.seconds) {
        double until = dt;
        if (clock.jitter_s > 0) {
            const double next = clock.jitter_s * (2 * uniform() - 1);
            until = dt + next - offset;
            offset = next;
        }
        if (clock.late_share > 0 && uniform() < clock.late_share) until += dt * (1 + std::floor(3 * uniform()));
        const double h = until / steps;
        for (int k = 0; k < steps; ++k) {
            const Eigen::Vector3d a = (std::min(1.0, (time + k * h) / ramp_s) * push + force - hand.stiffness_N_m * (x - anchor)) / hand.mass_kg;
            v = (v + h * a) / (1 + h * hand.damping_Ns_m / hand.mass_kg);
            x += h * v;
        }
        time += until;
        sample.position_m = x;
        force = simulation.tick(sample, until);
        ++ticks;
        rest.faults += simulation.record().fault;
        if (time > 2 + ramp_s) {
            way.push_back({time, x, force});
            if (time - way.front().time_s >= window_s) {
                rest.swing_m = std::max(rest.swing_m, extent(way, release.creeps, [](const Moment& m) { return m.position_m; }));
                rest.swing_N = std::max(rest.swing_N, extent(way, release.creeps, [](const Moment& m) { return m.force_N; }));
                way.clear();
            }
        }
    }
    rest.force_N = (push - hand.stiffness_N_m * (x - anchor)).norm();
    rest.controlled = static_cast<double>(simulation.safety().counters().damped - damped_before) / static_cast<double>(ticks);
    rest.contact = simulation.contact().pressing;
    if (simulation.record().mesh == 0) rest.touched_m = model.meshes[0]->springs.rest_place(simulation.record().facet, simulation.record().weight);
    rest.push_m = simulation.record().contact_displacement_m;
    rest.tissue_N = -simulation.record().coupling_N;
    return rest;
}

}  // namespace tissue::test
