#pragma once

#include <cstddef>
#include <memory>

#include "api/named_surfaces.h"
#include "haptic/simulation.h"
#include "haptic/tick_clock.h"

namespace tissue {

/// Session of the C and Python interfaces: the simulation of a model, the clock of its ticks, the named surfaces that
/// move with its tissue, and the selected tool.
class ApiSession {
   public:
    ApiSession(std::shared_ptr<const HapticModel> of, const NamedSurfaces& with) : model(std::move(of)), simulation(*model), surfaces(with) {}

    /// One tick of every tool. position_m [m], force_N [N]: three numbers per tool, one tool after the other; the
    /// arrays may be the same. age_s: one number per tool [s], or nullptr: just measured. elapsed_s: as in
    /// TickClock::start. Allocates nothing.
    void tick(const double* position_m, const double* age_s, double elapsed_s, double* force_N) noexcept;

    /// Selects the tool that calls act on. Throws MismatchError where the session has no such tool.
    void use_tool(int index);
    int tool() const { return tool_; }

    /// Simulation::restore. Resets the clock.
    void restore(const std::byte* from, std::size_t size);
    /// Simulation::check_take_over and take_over; takes over the clock and the selected tool of `from`. Allocates only
    /// where it throws.
    void take_over(const ApiSession& from);
    /// Resets the clock: call after ticks whose caller passed the elapsed time, so that their time is not measured.
    void forget_clock() noexcept { clock_ = {}; }

    const std::shared_ptr<const HapticModel> model;  ///< shared with copies of this session
    Simulation simulation;
    NamedSurfaces surfaces;

   private:
    TickClock clock_;
    int tool_ = 0;
};

}  // namespace tissue
