#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "haptic/simulation.h"

namespace tissue {

/// What a session counts, by the names of tissue_count (tissue.h).
struct SessionCount {
    const char* name;
    long long (*of)(const Simulation&);
};

inline constexpr std::array<SessionCount, 13> session_counts{{
    {"ticks", [](const Simulation& s) { return s.counters().ticks; }},
    {"folded", [](const Simulation& s) { return s.counters().folded; }},
    {"unstable", [](const Simulation& s) { return s.counters().unstable; }},
    {"not_yet_outside", [](const Simulation& s) { return s.counters().unarmed; }},
    {"bad_input", [](const Simulation& s) { return s.safety().counters().bad_input; }},
    {"jumps", [](const Simulation& s) { return s.safety().counters().jump; }},
    {"stale", [](const Simulation& s) { return s.safety().counters().stale; }},
    {"late", [](const Simulation& s) { return s.safety().counters().late; }},
    {"clamped", [](const Simulation& s) { return s.safety().counters().clamped; }},
    {"slewed", [](const Simulation& s) { return s.safety().counters().slewed; }},
    {"damped", [](const Simulation& s) { return s.safety().counters().damped; }},
    {"capped", [](const Simulation& s) { return s.safety().counters().capped; }},
    {"lost_ms", [](const Simulation& s) { return std::llround(std::min(1e3 * s.counters().lost_s, 1e15)); }},
}};

/// The energy log of a session [J], by the names of tissue_energy.
struct SessionEnergy {
    const char* name;
    double (*of)(const Simulation&);
};

inline constexpr std::array<SessionEnergy, 7> session_energies{{
    {"given", [](const Simulation& s) { return s.safety().counters().energy_given_J; }},
    {"observed", [](const Simulation& s) { return s.safety().observed_J(); }},
    {"bound", [](const Simulation& s) { return s.safety().lateness() * s.safety().bound_J(); }},
    {"kinetic", [](const Simulation& s) { return s.kinetic_J(); }},
    {"friction", [](const Simulation& s) { return s.friction().burnt_J(); }},
    {"stored", [](const Simulation& s) { return s.branches().stored_J; }},
    {"dissipated", [](const Simulation& s) { return s.branches().burnt_J; }},
}};

}  // namespace tissue
