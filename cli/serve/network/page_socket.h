#pragma once

#include <deque>
#include <optional>

#include "../show.h"
#include "beast.h"
#include "limits.h"

namespace tissue::serve {

class Listener;

using Text = std::shared_ptr<const std::string>;

/// The WebSocket of one page.
class PageSocket : public std::enable_shared_from_this<PageSocket> {
   public:
    PageSocket(Listener& server, Seat seat, Stream stream, Show::Client client)
        : server_(server), seat_(std::move(seat)), socket_(std::move(stream)), client_(client) {}

    void start(const http::request<http::empty_body>& request);
    void tell(const std::string& text);
    void offer(const std::shared_ptr<const Frame>& state);

    /// Drops the state of a model that no longer runs.
    void forget_state() {
        state_.reset();
        coder_.forget();
    }

    void check_speed();

    /// Sends the reason, closes, and waits for the other side only as long as the timeouts allow.
    void close(const websocket::close_reason& reason);
    void say_bye(const std::string& reason);

   private:
    void read();
    void have_read(Code error);

    Intake& intake() { return beast::get_lowest_layer(socket_).rate_policy(); }

    void refuse_flood() { refuse(websocket::close_code::policy_error, {"rate", "too many messages a second"}); }

    void refuse(websocket::close_code code, const Refusal& refusal);
    void write();

    /// Closes without a reason, because it would not be read.
    void drop(const char* kind);
    void leave();
    void gone();

    Listener& server_;
    Seat seat_;
    websocket::stream<Stream> socket_;
    Show::Client client_;
    beast::flat_buffer buffer_;
    std::deque<Text> texts_;
    std::shared_ptr<const Frame> state_;   ///< the newest state that has not been sent
    FrameCoder coder_;
    std::optional<websocket::close_reason> farewell_;
    Allowance allowance_{messages_s};
    Clock::time_point writing_since_;
    bool open_ = false, writing_ = false, closing_ = false, left_ = false, bye_ = false,
         flooded_ = false, too_slow_ = false;
};

}  // namespace tissue::serve
