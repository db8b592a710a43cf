#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "haptic/device.h"
#include "haptic/histogram.h"
#include "haptic/simulation.h"
#include "haptic/tick_hook.h"

namespace tissue {

constexpr double longest_session_s = 1e9;       ///< thirty years: beyond it the count of ticks would not be one

struct LoopOptions {
    double seconds = 10;                        ///< up to longest_session_s; 0: until the device has finished or `stop` is set
    const std::atomic<bool>* stop = nullptr;    ///< set from a signal handler or another thread
    bool clock = true;                          ///< false: ticks follow one another without waiting, none is missed, and `seconds` are the tissue's; for scripted motions, which no hand feels
    bool realtime = true;                       ///< ask for SCHED_FIFO and locked memory; not without a clock, for such a loop never sleeps
    int priority = 80;                          ///< of SCHED_FIFO: above most of the kernel's threads, below its watchdogs
    std::vector<TickHook*> hooks;               ///< in this order; they outlive the loop
};

struct LoopReport {
    bool clock = true;
    long long ticks = 0;
    long long misses = 0;          ///< periods of the session that ended before their tick was done: with the ticks, all that were asked for
    long long misses_program = 0;  ///< those in which the tick itself used a whole period of processor time
    Histogram tick_us;             ///< device read to device write
    Histogram lateness_us;         ///< start of a tick after its place on the schedule
    std::vector<std::string> notices;  ///< what the machine did not allow
};

/// Ticks at an absolute rate until the time is up, or one of the devices has no more to say: positions in, simulation, forces out; a device for each of the simulation's tools. A tick that comes
/// so late that periods have ended is a miss for each of them, and takes the place of the period that it begins in; the
/// schedule stays where it was. The forces are zero and the devices stopped before this returns or throws what a device's
/// start(), set-up or a hook threw. A session that was asked to stop before it began does not start a device. A period whose tick is left out is none of the tissue's: it is neither made up for nor counted as lost. Throws MismatchError for a time that is none, and for
/// more or fewer devices than tools. Set-up and report are the caller's; nothing is printed here.
LoopReport run_loop(Simulation& simulation, const std::vector<Device*>& devices, const LoopOptions& options);
LoopReport run_loop(Simulation& simulation, Device& device, const LoopOptions& options);

}  // namespace tissue
