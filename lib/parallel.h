#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace tissue {

/// The largest number of threads that the system has refused to one parallel_for of this program so far. A program
/// reports it in one line at its end.
inline std::atomic<int>& refused_threads() {
    static std::atomic<int> most{0};
    return most;
}

/// Runs job(0) ... job(count - 1) on up to `threads` threads, the caller's included. Jobs must not depend on each
/// other's order. make_thread(work): starts a thread that runs work(), or throws; tests pass their own.
///
/// Returns the number of threads used. The system may refuse to start a thread (a limit on processes or memory). Then
/// the threads that were started do all jobs, and refused_threads() keeps the number of refused ones.
///
/// Rethrows the first exception of a job, after the running jobs have ended.
template <class Job, class MakeThread>
int parallel_for(int count, int threads, const Job& job, const MakeThread& make_thread) {
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
    const int wanted = std::max(1, std::min(threads, count));
    std::vector<std::thread> pool;
    pool.reserve(static_cast<std::size_t>(wanted));  // no exception may occur between a thread's start and its join
    while (static_cast<int>(pool.size()) + 1 < wanted) try {
            pool.push_back(make_thread(work));
        } catch (const std::exception&) {  // std::system_error, std::bad_alloc: the threads started so far do all jobs
            const int refused = wanted - 1 - static_cast<int>(pool.size());
            for (int most = refused_threads(); refused > most && !refused_threads().compare_exchange_weak(most, refused);) {}
            break;
        }
    work();
    for (std::thread& thread : pool) thread.join();
    if (failure) std::rethrow_exception(failure);
    return static_cast<int>(pool.size()) + 1;
}

template <class Job>
int parallel_for(int count, int threads, const Job& job) {
    return parallel_for(count, threads, job, [](const auto& work) { return std::thread(work); });
}

}  // namespace tissue
