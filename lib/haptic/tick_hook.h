#pragma once

#include "haptic/simulation.h"

namespace tissue {

/// Statistics of one tick from the loop, in addition to those of the simulation.
struct TickStatistics {
    double time_s = 0;                 ///< schedule time, without the periods of ticks that were left out
    double tick_us = 0, lateness_us = 0;  ///< as in LoopReport
    bool left_out = false;             ///< a hook left this tick out
    bool clock = true;                 ///< false: ticks do not wait for a clock (LoopOptions::clock)
    long long ticks = 0, misses = 0, misses_program = 0;  ///< totals of the loop so far, as in LoopReport
};

/// Called with every tick, in its thread: a recorder, a page. Neither function allocates, locks, prints or waits,
/// except that after() may wait where ticks have no clock. An exception ends the session and sets the force to zero.
class TickHook {
   public:
    virtual ~TickHook() = default;

    /// Before the devices are read. Returns false to leave this tick out: meshes and tools stay as they are, without
    /// force.
    virtual bool before(Simulation&) { return true; }

    /// After the forces have gone out.
    virtual void after(const Simulation& simulation, const TickStatistics& books) = 0;
};

}  // namespace tissue
