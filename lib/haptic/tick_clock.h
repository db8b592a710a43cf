#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

#include "flush_denormals.h"

namespace tissue {

/// What the clock says of a host's ticks, for Simulation::tick(): how long ago the last one began, where the host does not say it; and what ticks cost. A cost counts where
/// elapsed_s is what the clock says between two starts: a host takes it right before the tick. Who plays another time, as replays and simulated hands do, has ticks that may cost what they will,
/// and a session that does the same on any machine. Another time of nearly the same length may be taken for the clock's: see weigh().
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
    static constexpr int enough = 50, most = 2 * enough;  ///< ticks
    static constexpr double shortest_s = 1e-9;            ///< two starts at one time; 0 would be dt

    /// Evidence grows by 1 a tick whose elapsed_s is within 5 % of the clock's, by 10 if elapsed_s has also changed by more than 10 % since the last tick: who plays another time does not know how
    /// long a tick took. It falls by 25 a tick outside 5 %, so that a host that has agreed for long may be interrupted twice, and to 0 when the weighted sum of differences is above 5 % of a tick.
    /// Another time that differs by less than some 0.15 % a tick, or by chance as much up as down, agrees all the same.
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
    double drift_s_ = 0;  ///< of the clock from elapsed_s, over the last ticks
    int evidence_ = 0;    ///< in ticks
    bool began_ = false;
};

}  // namespace tissue
