#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

#include "flush_denormals.h"

namespace tissue {

/// What the ticks of a host cost by the clock, for Simulation::tick(). It counts where elapsed_s is what the clock says between two starts, within a twentieth, in
/// several ticks one after the other: a host takes it right before the tick. Who leaves it out, or plays
/// another time, as replays and simulated hands do, has ticks that may cost what they will, and a session that does the same on any machine.
class TickClock {
   public:
    /// At the start of a tick: what the one before cost [s]; 0 where it does not count.
    double start(double elapsed_s) noexcept {
        const FlushDenormals mode;  // a caller's own may trap
        const double before_s = started_s_;
        started_s_ = now_s();
        agreed_ = std::isfinite(elapsed_s) && std::abs(started_s_ - before_s - elapsed_s) <= 0.05 * elapsed_s ? std::min(agreed_ + 1, enough) : 0;
        return agreed_ == enough ? cost_s_ : 0;
    }
    void end() noexcept {
        const FlushDenormals mode;
        cost_s_ = now_s() - started_s_;
    }

   private:
    static constexpr int enough = 5;  ///< ticks

    static double now_s() noexcept { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

    double started_s_ = 0, cost_s_ = 0;
    int agreed_ = 0;
};

}  // namespace tissue
