#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tissue {

/// Runs job(0) ... job(count - 1) on up to `threads` threads, the caller's among them. The first exception comes out
/// here, after the running jobs have ended. Jobs must not depend on each other's order.
template <class Job>
void parallel_for(int count, int threads, const Job& job) {
    std::atomic<int> next{0};
    std::exception_ptr failure;
    std::mutex guard;
    const auto work = [&] {
        for (int i = next++; i < count; i = next++) try {
                job(i);
            } catch (...) {
                const std::lock_guard<std::mutex> lock(guard);
                if (!failure) failure = std::current_exception();
                next = count;
            }
    };
    std::vector<std::thread> pool;
    for (int t = 1; t < std::min(threads, count); ++t) pool.emplace_back(work);
    work();
    for (std::thread& thread : pool) thread.join();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace tissue
