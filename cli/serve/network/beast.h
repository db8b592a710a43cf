#pragma once

#include <algorithm>
#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <limits>
#include <memory>
#include <string>

// Short names for Boost. Of the programs only this folder depends on Boost; in lib, haptic/haply_device.cpp uses Beast too.
namespace tissue::serve {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;

/// Limit on the bytes that a connection reads per second: Beast's RatePolicy. Beast asks it before reading, and resets
/// it each second. Fragments without content are not reported to us, so bytes are counted in their place.
class Intake {
   public:
    void limit(std::size_t bytes_a_second) { left_ = limit_ = bytes_a_second; }
    /// the limit of this second is used up, and nothing is read before the next
    bool spent() const { return left_ == 0; }

   private:
    friend class beast::rate_policy_access;
    static constexpr std::size_t all = std::numeric_limits<std::size_t>::max();
    std::size_t available_read_bytes() const noexcept { return left_; }
    std::size_t available_write_bytes() const noexcept { return all; }
    void transfer_read_bytes(std::size_t n) noexcept { left_ -= left_ == all ? 0 : std::min(n, left_); }
    void transfer_write_bytes(std::size_t) noexcept {}
    void on_timer() noexcept { left_ = limit_; }

    std::size_t limit_ = all, left_ = all;
};

using Stream = beast::basic_stream<Tcp, asio::any_io_executor, Intake>;
using Code = beast::error_code;
using Clock = std::chrono::steady_clock;

}  // namespace tissue::serve
