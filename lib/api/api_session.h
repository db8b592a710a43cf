#pragma once

#include <cstddef>
#include <memory>

#include "api/named_surfaces.h"
#include "haptic/simulation.h"
#include "haptic/tick_clock.h"

namespace tissue {

/// A session as C and Python have it: the simulation of a model, the clock of its ticks, the surfaces that move with its tissue, and the tool that calls act on.
class ApiSession {
   public:
    ApiSession(std::shared_ptr<const HapticModel> of, const NamedSurfaces& with) : model(std::move(of)), simulation(*model), surfaces(with) {}

    /// One tick of every tool: positions [m] and forces [N] are three numbers a tool, one tool after the other, in one array or two; age_s: a number a tool, or nullptr, just measured.
    /// elapsed_s: as of TickClock::start. Allocates nothing.
    void tick(const double* position_m, const double* age_s, double elapsed_s, double* force_N) noexcept;

    /// Throws MismatchError where the session has no such tool.
    void use_tool(int index);
    int tool() const { return tool_; }

    /// Simulation::restore. The clock knows nothing of what was before.
    void restore(const std::byte* from, std::size_t size);
    /// Simulation::check_take_over and take_over; clock and chosen tool go on. Allocates where it throws alone.
    void take_over(const ApiSession& from);
    /// After ticks that said themselves how long they took.
    void forget_clock() noexcept { clock_ = {}; }

    const std::shared_ptr<const HapticModel> model;  ///< of this session and its copies
    Simulation simulation;
    NamedSurfaces surfaces;

   private:
    TickClock clock_;
    int tool_ = 0;
};

}  // namespace tissue
