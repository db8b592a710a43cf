#pragma once

#include <atomic>
#include <vector>

#include "haptic/latest.h"
#include "haptic/spsc_ring.h"
#include "haptic/tick_hook.h"

namespace tissue {

/// What one tick left behind of a tool.
struct ToolTick {
    TickRecord record;
    SafetyCounters safety;
    std::vector<Point> contact_displacement_m;  ///< of each mesh at the contact, of a law the tool's own; 0 without one
    Point proxy_m;                              ///< the record's; in contact with a law, on the surface as it is seen
};

/// A copy of what one tick left behind, for another thread: of the first tool, and of all.
struct TickState : ToolTick {
    ToolTick second;                                      ///< where the session has two tools
    TickBooks books;
    HapticCounters counters;
    double rested_s = 0;                                  ///< when every mesh was last put to rest
    std::vector<float> nodes_m;                           ///< place of every node as it is seen (Simulation::seen), D numbers each, mesh after mesh
};

/// Between the tick and one other thread: states and times out, pause and reset in. Neither side locks or waits, and
/// nothing is allocated after it is made.
class StateChannel final : public TickHook {
   public:
    /// every: ticks between two states. times: tick times that fit while the other thread is busy; more are left out.
    explicit StateChannel(const HapticModel& model, int every = 17, std::size_t times = 8192);

    bool before(Simulation& simulation) noexcept override;
    void after(const Simulation& simulation, const TickBooks& books) noexcept override;

    // the other thread's
    void pause(bool on) noexcept { paused_.store(on, std::memory_order_relaxed); }
    bool paused() const noexcept { return paused_.load(std::memory_order_relaxed); }
    void reset() noexcept { reset_.store(true, std::memory_order_relaxed); }  ///< every mesh to rest
    bool fetch() noexcept { return latest_.fetch(); }                         ///< true: state() is a newer one
    const TickState& state() const noexcept { return latest_.front(); }
    bool pop_time(double& tick_us) noexcept { return times_.pop(tick_us); }

   private:
    int every_, since_ = 0;
    std::atomic<bool> paused_{false}, reset_{false};
    Latest<TickState> latest_;
    std::vector<NodeColumns> seen_;  ///< scratch, of each mesh
    SpscRing<double> times_;
};

}  // namespace tissue
