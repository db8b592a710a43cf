#pragma once

#include <chrono>
#include <thread>

namespace tissue {

/// Waits until `wanted`, called every millisecond, returns true. False after two minutes; only a failing test or a busy
/// machine waits that long.
template <class Wanted>
bool wait_for(Wanted&& wanted) {
    using std::chrono::steady_clock;
    const auto give_up = steady_clock::now() + std::chrono::minutes(2);
    while (!wanted()) {
        if (steady_clock::now() > give_up) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

}  // namespace tissue
