#pragma once

#include <chrono>
#include <thread>

namespace tissue {

/// Waits until an event has come, and says whether it has. It comes soon; only a test that fails, or a machine that is
/// busy, waits longer. wanted: asked every millisecond.
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
