#include "haptic/realtime_loop.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

#include "error.h"
#include "haptic/realtime_thread.h"
#include "haptic/running_device.h"

namespace tissue {
namespace {

/// Requests SCHED_FIFO for the calling thread and locked memory, for the lifetime of this object.
class RealtimeThread {
   public:
    RealtimeThread(int priority, std::vector<std::string>& notices) {
        pthread_getschedparam(pthread_self(), &policy_, &before_);
        std::string refused;
        const int error = request_realtime(priority);
        scheduled_ = error == 0;
        if (error != 0) refused = fmt::format("no SCHED_FIFO ({})", std::strerror(error));
        locked_ = mlockall(MCL_CURRENT) == 0;
        if (!locked_) refused += fmt::format("{}no locked memory ({})", refused.empty() ? "" : ", ", std::strerror(errno));
        if (!refused.empty())
            notices.push_back("this machine does not allow realtime scheduling completely: " + refused + "; ticks may be late");
    }
    ~RealtimeThread() {
        if (scheduled_) pthread_setschedparam(pthread_self(), policy_, &before_);
        if (locked_) munlockall();
    }
    RealtimeThread(const RealtimeThread&) = delete;
    RealtimeThread& operator=(const RealtimeThread&) = delete;

   private:
    int policy_ = 0;
    sched_param before_{};
    bool scheduled_ = false, locked_ = false;
};

/// Writes to the part of the stack that ticks will use, so that its pages are mapped before the first tick.
void touch_stack() noexcept {
    volatile char page[64 * 1024];
    for (std::size_t k = 0; k < sizeof page; k += 1024) page[k] = 0;
}

/// given: `count` devices, one per tool.
void run(Simulation& simulation, Device* const* given, std::size_t count, const LoopOptions& options, LoopReport& report) {
    if (!(options.seconds >= 0 && options.seconds <= longest_session_s)) throw MismatchError(fmt::format("a session must last 0 to {:g} s, not {:g} s", longest_session_s, options.seconds));
    const int tools = simulation.tool_count();
    if (count != static_cast<std::size_t>(tools)) throw MismatchError(fmt::format("a session of {} tools needs as many devices, not {}", tools, count));
    if (options.stop && options.stop->load(std::memory_order_relaxed)) return;
    std::optional<RunningDevice> running[most_tools];
    struct NoForce {  // sets the force of every started device to zero, before the first of them is stopped
        Device* const* devices;
        int started = 0;
        ~NoForce() {
            for (int k = 0; k < started; ++k) devices[k]->write(Eigen::Vector3d::Zero());
        }
    } no_force{given};
    for (; no_force.started < tools; ++no_force.started) running[no_force.started].emplace(*given[no_force.started]);
    DeviceSample samples[most_tools];
    Eigen::Vector3d force_N[most_tools];
    std::unique_ptr<RealtimeThread> realtime;
    report.clock = options.clock;
    if (options.realtime && options.clock) realtime = std::make_unique<RealtimeThread>(options.priority, report.notices);
    touch_stack();
    const double dt_s = simulation.model().options.dt_s;
    const auto dt_ns = static_cast<long long>(std::llround(dt_s * 1e9));
    const long long start = now_ns() + dt_ns;
    const long long last_slot =
        options.seconds > 0 ? static_cast<long long>(std::ceil(options.seconds / dt_s - 1e-6)) : -1;
    long long before = -1, left_out = 0;  // slot of the last tick, done or left out; number of slots left out
    double cost_s = 0;  // duration of the previous tick
    for (long long slot = 0; last_slot < 0 || slot < last_slot; ++slot) {
        if (options.stop && options.stop->load(std::memory_order_relaxed)) break;
        const long long due = options.clock ? start + slot * dt_ns : now_ns();
        if (options.clock) sleep_until(due);

        bool wanted = true;
        for (TickHook* hook : options.hooks) wanted = hook->before(simulation) && wanted;

        // after a late wake-up this becomes the tick of the current period; since_s is the time since the last one
        const long long began = now_ns(), cpu_began = now_ns(CLOCK_THREAD_CPUTIME_ID);
        const auto missed = [&](long long late_ns, long long next) {
            const long long periods = options.clock ? late_ns / dt_ns : 0;
            return last_slot < 0 ? periods : std::min(periods, last_slot - next);
        };
        const long long late = missed(began - due, slot);
        slot += late;
        report.misses += late;
        if (last_slot >= 0 && slot >= last_slot) break;

        // the tick
        TickStatistics books;
        const double time_s = static_cast<double>(slot) * dt_s, since_s = static_cast<double>(slot - before) * dt_s;
        if (!wanted) left_out += slot - before;
        before = slot;
        books.time_s = static_cast<double>(slot - left_out) * dt_s;
        books.left_out = !wanted;
        books.clock = options.clock;
        if (wanted) {
            for (int k = 0; k < tools; ++k) samples[k] = given[k]->read(time_s);
            const long long ticked = now_ns();
            simulation.tick(samples, force_N, since_s, cost_s);
            if (options.clock) cost_s = 1e-9 * static_cast<double>(now_ns() - ticked);
        } else {
            for (int k = 0; k < tools; ++k) samples[k] = given[k]->skip_tick(time_s);
            simulation.skip_tick(samples, force_N, since_s);
        }
        for (int k = 0; k < tools; ++k) given[k]->write(force_N[k]);
        const long long ended = now_ns();

        // session statistics
        books.tick_us = 1e-3 * static_cast<double>(ended - began);
        books.lateness_us = options.clock ? 1e-3 * static_cast<double>(began - due) : 0;
        if (wanted) {
            ++report.ticks;
            report.tick_us.add(books.tick_us);
            report.lateness_us.add(books.lateness_us);
        }
        const long long over = missed(ended - due - late * dt_ns, slot + 1);
        if (over > 0) {
            report.misses += over;
            report.misses_program += std::min(over, (now_ns(CLOCK_THREAD_CPUTIME_ID) - cpu_began) / dt_ns);
            slot += over;
        }
        books.ticks = report.ticks;
        books.misses = report.misses;
        books.misses_program = report.misses_program;
        for (TickHook* hook : options.hooks) hook->after(simulation, books);
        if (std::any_of(given, given + tools, [](const Device* device) { return device->finished(); })) break;
    }
}

LoopReport reported(Simulation& simulation, Device* const* devices, std::size_t count, const LoopOptions& options) {
    LoopReport report;
    try {
        run(simulation, devices, count, options, report);
    } catch (...) {
        throw;  // without any handler the stack might not be unwound, nor the device stopped
    }
    return report;
}

}  // namespace

LoopReport run_loop(Simulation& simulation, const std::vector<Device*>& devices, const LoopOptions& options) {
    return reported(simulation, devices.data(), devices.size(), options);
}

LoopReport run_loop(Simulation& simulation, Device& device, const LoopOptions& options) {
    Device* const one = &device;
    return reported(simulation, &one, 1, options);
}

}  // namespace tissue
