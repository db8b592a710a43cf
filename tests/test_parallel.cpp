#include "parallel.h"

#include <catch2/catch.hpp>
#include <cerrno>
#include <functional>
#include <stdexcept>
#include <system_error>

using namespace tissue;

namespace {

/// Starts at most `left` threads, like a system with a limit on processes.
struct Limited {
    int left;
    std::thread operator()(const std::function<void()>& work) {
        if (left-- <= 0) throw std::system_error(EAGAIN, std::generic_category());
        return std::thread(work);
    }
};

}  // namespace

TEST_CASE("every job runs once for any number of threads that the system starts") {
    for (const int made : {100, 3, 1, 0}) {
        std::vector<std::atomic<int>> runs(1000);
        Limited maker{made};
        const int used = parallel_for(1000, 8, [&](int i) { ++runs[static_cast<std::size_t>(i)]; },
                                      [&](const auto& work) { return maker(work); });
        for (const std::atomic<int>& r : runs) CHECK(r == 1);
        CHECK(used == std::min(8, made + 1));
        CHECK(refused_threads() >= 8 - used);  // the calling thread is one of the eight
    }
}

TEST_CASE("an exception of a job is rethrown even if the system starts fewer threads than requested") {
    for (const int made : {0, 2}) {
        Limited maker{made};
        CHECK_THROWS_AS(parallel_for(100, 8, [](int i) { if (i == 40) throw std::out_of_range("forty"); },
                                     [&](const auto& work) { return maker(work); }),
                        std::out_of_range);
    }
    CHECK_THROWS_AS(parallel_for(100, 4, [](int i) { if (i == 40) throw std::out_of_range("forty"); }), std::out_of_range);
}

TEST_CASE("parallel_for without jobs runs nothing and a thread count below one means one thread") {
    int runs = 0;
    CHECK(parallel_for(0, 8, [&](int) { ++runs; }) == 1);
    CHECK(runs == 0);
    for (const int threads : {-3, 0, 1}) CHECK(parallel_for(5, threads, [&](int) { ++runs; }) == 1);
    CHECK(runs == 15);
}
