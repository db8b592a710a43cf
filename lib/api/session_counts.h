#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "haptic/simulation.h"

namespace tissue {

/// A count of a session, under its name in tissue_count (tissue.h). `of`: its value, for one tool where it is counted
/// per tool.
struct SessionCount {
    const char* name;
    long long (*of)(const Simulation&, int tool);
};

inline constexpr std::array<SessionCount, 14> session_counts{{
    {"ticks", [](const Simulation& s, int) { return s.counters().ticks; }},
    {"folded", [](const Simulation& s, int) { return s.counters().folded; }},
    {"unstable", [](const Simulation& s, int) { return s.counters().unstable; }},
    {"not_yet_outside", [](const Simulation& s, int tool) { return s.unarmed(tool); }},
    {"let_go", [](const Simulation& s, int tool) { return s.let_go(tool); }},
    {"bad_input", [](const Simulation& s, int tool) { return s.safety(tool).counters().bad_input; }},
    {"jumps", [](const Simulation& s, int tool) { return s.safety(tool).counters().jump; }},
    {"stale", [](const Simulation& s, int tool) { return s.safety(tool).counters().stale; }},
    {"late", [](const Simulation& s, int tool) { return s.safety(tool).counters().late; }},
    {"clamped", [](const Simulation& s, int tool) { return s.safety(tool).counters().clamped; }},
    {"slewed", [](const Simulation& s, int tool) { return s.safety(tool).counters().slewed; }},
    {"damped", [](const Simulation& s, int tool) { return s.safety(tool).counters().damped; }},
    {"capped", [](const Simulation& s, int tool) { return s.safety(tool).counters().capped; }},
    {"lost_ms", [](const Simulation& s, int) { return std::llround(std::min(1e3 * s.counters().lost_s, 1e15)); }},
}};

/// An entry of a session's energy log [J], under its name in tissue_energy. `of`: its value, for one tool where it is
/// kept per tool.
struct SessionEnergy {
    const char* name;
    double (*of)(const Simulation&, int tool);
};

inline constexpr std::array<SessionEnergy, 7> session_energies{{
    {"given", [](const Simulation& s, int tool) { return s.safety(tool).counters().energy_given_J; }},
    {"observed", [](const Simulation& s, int tool) { return s.safety(tool).observed_J(); }},
    {"bound", [](const Simulation& s, int tool) { return s.safety(tool).lateness() * s.safety(tool).bound_J(); }},
    {"kinetic", [](const Simulation& s, int) { return s.kinetic_J(); }},
    {"friction", [](const Simulation& s, int tool) { return s.friction(tool).dissipated_J(); }},
    {"stored", [](const Simulation& s, int) { return s.branches().stored_J; }},
    {"dissipated", [](const Simulation& s, int) { return s.branches().dissipated_J; }},
}};

}  // namespace tissue
