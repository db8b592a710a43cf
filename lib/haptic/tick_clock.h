#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

#include "flush_denormals.h"

namespace tissue {

/// Measures a host's ticks for Simulation::tick(): the time since the last tick began, where the host does not state
/// it, and the cost of ticks. A cost counts only where elapsed_s agrees with the clock between two starts, as for a
/// host that measures it right before the tick. A host with a time of its own, such as a replay or a simulated hand,
/// has ticks without a cost. Its session gives the same result on any machine. A time of nearly the same length may be
/// mistaken for the clock's: see weigh().
class TickClock {
   public:
    struct Start {
        double elapsed_s;  ///< since the last tick; 0: dt
        double cost_s;     ///< of the previous tick; 0: it does not count
    };

    /// Call at the start of a tick. elapsed_s: as the host states it; negative or not finite: unknown, and the clock's
    /// value is used. For the first tick there is none, and elapsed_s becomes 0 (dt).
    Start start(double elapsed_s) noexcept {
        const FlushDenormals mode;  // the caller's mode may have traps
        return start_at(elapsed_s, now_s());
    }
    void end() noexcept {
        const FlushDenormals mode;
        end_at(now_s());
    }

    /// The same with the time [s] of a clock that never goes back.
    Start start_at(double elapsed_s, double now_s) noexcept {
        const double passed_s = now_s - started_s_;
        const bool known = elapsed_s >= 0 && std::isfinite(elapsed_s);
        if (!known) elapsed_s = began_ ? std::max(passed_s, shortest_s) : 0;
        if (began_) weigh(elapsed_s, passed_s - elapsed_s);
        if (began_ && !known) evidence_ = most;
        started_s_ = now_s;
        elapsed_s_ = elapsed_s;
        began_ = true;
        return {elapsed_s, evidence_ >= enough ? cost_s_ : 0};
    }
    void end_at(double now_s) noexcept { cost_s_ = now_s - started_s_; }

   private:
    static constexpr int enough = 50, most = 2 * enough;  ///< of evidence, in ticks
    static constexpr double shortest_s = 1e-9;            ///< for two starts at one time; 0 would mean dt

    /// Updates the evidence that elapsed_s is measured by a clock. off_s: the clock's time minus elapsed_s.
    /// Evidence grows by 1 per tick whose elapsed_s is within 5 % of the clock's. It grows by 10 if elapsed_s has also
    /// changed by more than 10 % since the last tick, since a time that is not measured does not follow the length of
    /// ticks. It falls by 25 per tick outside 5 %, so that a host that has agreed for long may be interrupted twice. It
    /// falls to 0 when the weighted sum of differences exceeds 5 % of a tick. A time of another kind still passes if it
    /// differs by less than about 0.15 % per tick, or randomly in both directions.
    void weigh(double elapsed_s, double off_s) noexcept {
        const double near_s = 0.05 * elapsed_s;
        if (!(std::abs(off_s) <= near_s)) {
            evidence_ = std::max(evidence_ - enough / 2, 0);
            return;
        }
        drift_s_ = (1 - 1.0 / enough) * drift_s_ + off_s;
        if (std::abs(drift_s_) > near_s)
            evidence_ = 0, drift_s_ = 0;
        else
            evidence_ = std::min(evidence_ + (std::abs(elapsed_s - elapsed_s_) > 2 * near_s ? enough / 5 : 1), most);
    }

    static double now_s() noexcept { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

    double started_s_ = 0, elapsed_s_ = 0, cost_s_ = 0;
    double drift_s_ = 0;  ///< weighted sum of the clock's time minus elapsed_s, over the last ticks
    int evidence_ = 0;    ///< in ticks; costs count from `enough` on
    bool began_ = false;
};

}  // namespace tissue
