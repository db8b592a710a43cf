#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "haptic/simulation.h"

namespace tissue {

/// What a session counts, by the names of tissue_count (tissue.h); of a tool what belongs to one.
struct SessionCount {
    const char* name;
    long long (*of)(const Simulation&, int tool);
};

inline constexpr std::array<SessionCount, 13> session_counts{{
    {"ticks", [](const Simulation& s, int) { return s.counters().ticks; }},
    {"folded", [](const Simulation& s, int) { return s.counters().folded; }},
    {"unstable", [](const Simulation& s, int) { return s.counters().unstable; }},
    {"not_yet_outside", [](const Simulation& s, int tool) { return s.unarmed(tool); }},
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

/// The energy log of a session [J], by the names of tissue_energy; of a tool what belongs to one.
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
