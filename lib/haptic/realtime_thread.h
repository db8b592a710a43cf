#pragma once

#include <pthread.h>
#include <sys/prctl.h>
#include <time.h>

namespace tissue {

/// Priorities of SCHED_FIFO: above most of the kernel's threads, below its watchdogs. A servo thread goes first: it
/// needs little time, and the motors wait for it.
constexpr int tick_priority = 80, servo_priority = 81;

/// Requests SCHED_FIFO of this priority and exact wake-ups for the calling thread. Returns 0, or the system's error.
inline int request_realtime(int priority) noexcept {
    prctl(PR_SET_TIMERSLACK, 1UL);
    sched_param wanted{};
    wanted.sched_priority = priority;
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
}

/// Time of CLOCK_MONOTONIC [ns], or of another clock.
inline long long now_ns(clockid_t clock = CLOCK_MONOTONIC) noexcept {
    timespec t;
    clock_gettime(clock, &t);
    return t.tv_sec * 1'000'000'000LL + t.tv_nsec;
}

/// Sleeps until this time of CLOCK_MONOTONIC [ns]; returns at once where it has passed.
inline void sleep_until(long long time_ns) noexcept {
    const timespec t{time_ns / 1'000'000'000LL, time_ns % 1'000'000'000LL};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
}

}  // namespace tissue
