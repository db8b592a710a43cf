#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

#include "flush_denormals.h"

namespace tissue {

/// What the clock says of a host's ticks, for Simulation::tick(): how long ago the last one began, where the host does not say it; and what ticks cost. A cost counts where
/// elapsed_s is what the clock says between two starts, within a twentieth, in several ticks one after the other: a host takes it right before the tick. Who plays
/// another time, as replays and simulated hands do, has ticks that may cost what they will, and a session that does the same on any machine.
class TickClock {
   public:
    struct Start {
        double elapsed_s;  ///< since the last tick; 0: dt
        double cost_s;     ///< of the tick before; 0: it does not count
    };

    /// At the start of a tick. elapsed_s: what the host says; negative or not finite: it does not know, and the clock tells. Of the first tick there is nothing to tell: dt.
    Start start(double elapsed_s) noexcept {
        const FlushDenormals mode;  // a caller's own may trap
        return start_at(elapsed_s, now_s());
    }
    void end() noexcept {
        const FlushDenormals mode;
        end_at(now_s());
    }

    /// The same at a given time of a clock that never goes back.
    Start start_at(double elapsed_s, double now_s) noexcept {
        const double passed_s = now_s - started_s_;
        if (!(elapsed_s >= 0 && std::isfinite(elapsed_s))) elapsed_s = began_ ? std::max(passed_s, shortest_s) : 0;
        agreed_ = began_ && std::abs(passed_s - elapsed_s) <= 0.05 * elapsed_s ? std::min(agreed_ + 1, enough) : 0;
        started_s_ = now_s;
        began_ = true;
        return {elapsed_s, agreed_ == enough ? cost_s_ : 0};
    }
    void end_at(double now_s) noexcept { cost_s_ = now_s - started_s_; }

   private:
    static constexpr int enough = 5;             ///< ticks
    static constexpr double shortest_s = 1e-9;   ///< two starts at one time; 0 would be dt

    static double now_s() noexcept { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

    double started_s_ = 0, cost_s_ = 0;
    int agreed_ = 0;
    bool began_ = false;
};

}  // namespace tissue
