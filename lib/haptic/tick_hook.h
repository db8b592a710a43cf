#pragma once

#include "haptic/simulation.h"

namespace tissue {

/// What the loop knows of one tick, beside what the simulation says of it.
struct TickBooks {
    double time_s = 0;                 ///< on the schedule, without the periods of ticks that were left out
    double tick_us = 0, lateness_us = 0;
    bool left_out = false;             ///< a hook has asked for that
    bool clock = true;                 ///< false: ticks wait for no clock (LoopOptions::clock)
    long long ticks = 0, misses = 0, misses_program = 0;  ///< of the loop so far
};

/// Someone who comes along with every tick, in its thread: a recorder, a page. Neither function allocates, locks,
/// prints or waits, but after() may wait where ticks have no clock. One that throws ends the session, and the force with it.
class TickHook {
   public:
    virtual ~TickHook() = default;

    /// Before the device is read. False: this tick is left out; meshes and hand stay where they are, without force.
    virtual bool before(Simulation&) { return true; }

    /// After the force has gone out.
    virtual void after(const Simulation& simulation, const TickBooks& books) = 0;
};

}  // namespace tissue
