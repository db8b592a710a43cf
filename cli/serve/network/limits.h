#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>

namespace tissue::serve {

inline constexpr std::chrono::seconds request_time{5};     ///< for a whole request, and between two of a connection
inline constexpr std::chrono::seconds idle_time{20};       ///< a page that answers no ping for this long is gone
inline constexpr std::chrono::seconds slow_time{2};        ///< a page that takes longer to take one message is too slow
inline constexpr std::chrono::milliseconds step_time{16};  ///< of the show: 60 a second
inline constexpr std::chrono::seconds farewell_time{1};    ///< for clients to close, at the end
inline constexpr std::size_t longest_queue = 64;           ///< texts that wait for one page
inline constexpr int send_buffer = 64 * 1024;              ///< so that a page that does not read shows soon
inline constexpr int connections_max = 64;                 ///< of all kinds at a time
inline constexpr double messages_s = 250;                  ///< of one page: a mouse says 60 to 125
inline constexpr std::size_t frame_header = 14;            ///< bytes, at most, before what a page says

inline double now_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// So many messages a second, and as many at once.
class Allowance {
   public:
    bool take() {
        const double now = now_s();
        left_ = std::min(messages_s, left_ + messages_s * (now - then_));
        then_ = now;
        return (left_ -= 1) >= 0;
    }

   private:
    double left_ = messages_s, then_ = now_s();
};

/// Counts a connection while it lives.
class Seat {
   public:
    explicit Seat(int& count) : count_(&count) { ++*count_; }
    Seat(Seat&& other) noexcept : count_(std::exchange(other.count_, nullptr)) {}
    Seat& operator=(Seat&&) = delete;
    ~Seat() {
        if (count_) --*count_;
    }

   private:
    int* count_;
};

}  // namespace tissue::serve
