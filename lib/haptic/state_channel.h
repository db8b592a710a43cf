#pragma once

#include <atomic>
#include <vector>

#include "haptic/latest.h"
#include "haptic/spsc_ring.h"
#include "haptic/tick_hook.h"

namespace tissue {

/// Result of one tick for a tool.
struct ToolTick {
    TickRecord record;
    SafetyCounters safety;
    std::vector<Point> contact_displacement_m;  ///< of each mesh, as Simulation::displacement_at_contact
    /// of the record; in contact with an energy model, on the displayed surface
    Point proxy_m;
};

/// A copy of one tick's result for another thread: of the first tool (the base class), and of the session.
struct TickState : ToolTick {
    ToolTick second;                                      ///< of the second tool, where there is one
    TickStatistics books;
    HapticCounters counters;
    double rested_s = 0;                                  ///< when every mesh was last put to rest
    /// displayed position of every node (Simulation::displayed), D numbers each, mesh after mesh
    std::vector<float> nodes_m;
};

/// Connects the tick and one other thread: states and tick times go out, pause and reset come in. Neither side locks or
/// waits, and nothing is allocated after construction.
class StateChannel final : public TickHook {
   public:
    /// every: ticks between two states. times: tick times that fit while the other thread is busy; others are dropped.
    explicit StateChannel(const HapticModel& model, int every = 17, std::size_t times = 8192);

    bool before(Simulation& simulation) noexcept override;
    void after(const Simulation& simulation, const TickStatistics& books) noexcept override;

    // for the other thread
    void pause(bool on) noexcept { paused_.store(on, std::memory_order_relaxed); }
    bool paused() const noexcept { return paused_.load(std::memory_order_relaxed); }
    void reset() noexcept { reset_.store(true, std::memory_order_relaxed); }  ///< puts every mesh to rest
    bool fetch() noexcept { return latest_.fetch(); }                         ///< true: state() is newer than before
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
