#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>

namespace tissue::serve {

inline constexpr std::chrono::seconds first_byte_time{2};  ///< for the first byte of a connection
inline constexpr std::chrono::seconds request_time{5};     ///< for a request, and between two of a connection
inline constexpr std::chrono::seconds idle_time{20};       ///< a page that answers no ping for this long is closed
inline constexpr std::chrono::seconds slow_time{2};        ///< a page that needs longer to receive a message is closed
inline constexpr std::chrono::milliseconds step_time{16};  ///< between two steps of the show: 60 per second
inline constexpr std::chrono::seconds farewell_time{1};    ///< for the other side to close, at the end
inline constexpr std::size_t longest_queue = 64;           ///< texts waiting for one page
inline constexpr int send_buffer = 64 * 1024;              ///< small, so that a page that does not read is noticed soon
inline constexpr double download_B_s = 50e3;               ///< lowest mean rate of receiving, after request_time
inline constexpr int connections_max = 64;                 ///< of all kinds at a time
inline constexpr int connections_of_address = 48;          ///< more than 32 pages and what they load need
inline constexpr int addresses_max = 1024;                 ///< number of addresses that are kept
inline constexpr double messages_s = 250;                  ///< of one page; a mouse sends 60 to 125
inline constexpr double requests_s = 250;                  ///< of one address; a page loads 30 files
inline constexpr std::size_t frame_header = 14;            ///< largest header of a WebSocket frame, in bytes

inline double now_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A rate limit: at most rate_s per second, and as many at once.
class Allowance {
   public:
    explicit Allowance(double rate_s) : rate_s_(rate_s) {}
    bool take() {
        const double now = now_s();
        left_ = std::min(rate_s_, left_ + rate_s_ * (now - then_));
        then_ = now;
        if (left_ < 1) return false;  // a refused item costs nothing, so that a flood ends with its last message
        left_ -= 1;
        return true;
    }

   private:
    double rate_s_, left_ = rate_s_, then_ = now_s();
};

/// An address from which connections come. A network of 64 bits of IPv6 counts as one, and so does the loopback.
struct Neighbour {
    int connections = 0;
    /// requests with a valid token, and others, which do not reduce the former
    Allowance admitted{requests_s}, others{requests_s};
};

/// Counts a connection, in total and for its address, as long as it exists.
class Seat {
   public:
    Seat(int& all, Neighbour& neighbour) : all_(&all), neighbour_(&neighbour) { ++*all_, ++neighbour_->connections; }
    Seat(Seat&& other) noexcept : all_(std::exchange(other.all_, nullptr)), neighbour_(other.neighbour_) {}
    Seat& operator=(Seat&&) = delete;
    ~Seat() { give_up(); }

    void give_up() {
        if (!all_) return;
        --*std::exchange(all_, nullptr);
        --neighbour_->connections;
    }
    Neighbour& neighbour() const { return *neighbour_; }

   private:
    int* all_;
    Neighbour* neighbour_;
};

}  // namespace tissue::serve
