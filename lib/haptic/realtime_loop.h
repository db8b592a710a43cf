#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "haptic/device.h"
#include "haptic/histogram.h"
#include "haptic/realtime_thread.h"
#include "haptic/simulation.h"
#include "haptic/tick_hook.h"

namespace tissue {

constexpr double longest_session_s = 1e9;       ///< thirty years: counts of ticks and nanoseconds fit 64 bits

struct LoopOptions {
    /// up to longest_session_s; 0: until a device has finished or `stop` is set
    double seconds = 10;
    const std::atomic<bool>* stop = nullptr;    ///< set by a signal handler or another thread
    /// false: ticks follow one another without waiting, there are no overruns, and `seconds` is time of the tissue; for
    /// scripted motions, whose force no person feels
    bool clock = true;
    /// request SCHED_FIFO and locked memory; without a clock no request is made, since such a loop never sleeps
    bool realtime = true;
    int priority = tick_priority;               ///< of SCHED_FIFO
    std::vector<TickHook*> hooks;               ///< called in this order; must outlive the loop
};

struct LoopReport {
    bool clock = true;
    long long ticks = 0;
    /// overruns: periods that ended before their tick was done. Ticks, overruns and ticks that hooks left out add up to
    /// all periods
    long long misses = 0;
    long long misses_program = 0;  ///< overruns in which the tick itself used a whole period of processor time
    Histogram tick_us;             ///< from device read to device write
    Histogram lateness_us;         ///< start of a tick after its scheduled time
    std::vector<std::string> notices;  ///< what the machine refused: realtime class, locked memory
};

/// Runs ticks on a fixed schedule until the time is up, a device has finished, or `stop` is set. A tick reads
/// positions, simulates, and writes forces. devices: one for each of the simulation's tools.
///
/// If a tick starts so late that periods have ended, each of them counts as an overrun, and the tick becomes that of
/// the period in which it starts. The schedule does not shift. A period whose tick a hook leaves out is no part of the
/// tissue's time: it is neither made up for nor counted as lost.
///
/// Before this returns or throws, forces are zero and devices are stopped. If `stop` is set at the beginning, no device
/// is started. The caller does set-up and report; nothing is printed here.
///
/// Throws what a device's start(), set-up or a hook threw, and MismatchError for `seconds` outside [0,
/// longest_session_s] or a number of devices that is not that of the tools.
LoopReport run_loop(Simulation& simulation, const std::vector<Device*>& devices, const LoopOptions& options);
LoopReport run_loop(Simulation& simulation, Device& device, const LoopOptions& options);

}  // namespace tissue
