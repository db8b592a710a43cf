#include "api/api_session.h"

#include "error.h"

namespace tissue {

void ApiSession::tick(const double* position_m, const double* age_s, double elapsed_s, double* force_N) noexcept {
    DeviceSample samples[most_tools];
    Eigen::Vector3d forces_N[most_tools];
    for (int k = 0; k < simulation.tool_count(); ++k) {
        samples[k].position_m = Eigen::Map<const Eigen::Vector3d>(position_m + 3 * k);
        if (age_s) samples[k].age_s = age_s[k];
    }
    const TickClock::Start start = clock_.start(elapsed_s);
    simulation.tick(samples, forces_N, start.elapsed_s, start.cost_s);
    clock_.end();
    for (int k = 0; k < simulation.tool_count(); ++k) Eigen::Map<Eigen::Vector3d>(force_N + 3 * k) = forces_N[k];
}

void ApiSession::use_tool(int index) {
    if (index < 0 || index >= simulation.tool_count()) throw MismatchError("the session has no such tool");
    tool_ = index;
}

void ApiSession::restore(const std::byte* from, std::size_t size) {
    simulation.restore(from, size);
    forget_clock();
}

void ApiSession::take_over(const ApiSession& from) {
    simulation.check_take_over(from.simulation);
    simulation.take_over(from.simulation);
    clock_ = from.clock_;
    tool_ = from.tool_;
}

}  // namespace tissue
