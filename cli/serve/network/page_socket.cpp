#include "page_socket.h"

#include <fmt/format.h>

#include "listener.h"
#include "version.h"

namespace tissue::serve {

void PageSocket::start(const http::request<http::empty_body>& request) {
    websocket::stream_base::timeout times{};
    times.handshake_timeout = request_time;
    times.idle_timeout = idle_time;
    times.keep_alive_pings = true;
    socket_.set_option(times);
    socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& answer) {
        answer.set(http::field::server, std::string("tissuectl/") + version);
    }));
    intake().limit(static_cast<std::size_t>(messages_s) * (longest_message + frame_header));
    socket_.read_message_max(0);  // the limit is checked here, to answer with a reason
    socket_.auto_fragment(false);
    socket_.control_callback([this](websocket::frame_type kind, beast::string_view) {
        if (kind == websocket::frame_type::close || flooded_ || allowance_.take()) return;
        flooded_ = true;
        asio::post(socket_.get_executor(), [self = shared_from_this()] { self->refuse_flood(); });
    });
    socket_.async_accept(request, [self = shared_from_this()](Code error) {
        if (error) return self->gone();
        self->open_ = true;
        self->server_.show.join(self->client_);
        self->read();
    });
}

void PageSocket::tell(const std::string& text) {
    if (closing_) return;
    if (texts_.size() >= longest_queue) {  // dropped later: the show is sending to all clients
        too_slow_ = true;
        return;
    }
    texts_.push_back(std::make_shared<std::string>(text));
    write();
}

void PageSocket::offer(const std::shared_ptr<const Frame>& state) {
    if (!open_ || closing_) return;
    if (state_) ++server_.traffic.frames_dropped;
    state_ = state;
    write();
}

void PageSocket::check_speed() {
    if (intake().spent()) refuse_flood();
    if (too_slow_ || (writing_ && Clock::now() - writing_since_ > slow_time)) drop("slow");
}

void PageSocket::close(const websocket::close_reason& reason) {
    if (closing_) return;
    closing_ = true;
    leave();
    if (writing_) {  // after the message that is being sent
        farewell_ = reason;
        return;
    }
    socket_.async_close(reason, [self = shared_from_this()](Code) { self->gone(); });
}

void PageSocket::say_bye(const std::string& reason) {
    tell(bye_message(reason));
    if (!closing_) bye_ = true;
    write();
}

void PageSocket::read() {
    socket_.async_read_some(buffer_, longest_message + 1 - buffer_.size(), [self = shared_from_this()](Code error, std::size_t) {
        self->have_read(error);
    });
}

void PageSocket::have_read(Code error) {
    if (error) return gone();
    if (closing_) return;
    if (!allowance_.take()) return refuse_flood();  // a fragment of a message costs as much as a whole message
    if (buffer_.size() > longest_message)
        return refuse(websocket::close_code::too_big, {"too_long", fmt::format("a message longer than {} bytes", longest_message)});
    if (!socket_.is_message_done()) return read();
    ++server_.traffic.messages;
    if (!socket_.got_text()) return refuse(websocket::close_code::policy_error, {"message", "a message must be text"});
    const std::string text = beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    if (const std::optional<Refusal> refusal = server_.show.hear(client_, text, now_s()))
        return refuse(websocket::close_code::policy_error, *refusal);
    if (!closing_) read();
}

void PageSocket::refuse(websocket::close_code code, const Refusal& refusal) {
    if (closing_) return;
    server_.refuse(refusal.kind);
    close({code, refusal.reason});
}

void PageSocket::write() {
    if (writing_ || !open_ || (closing_ && !farewell_)) return;
    Text next;
    if (!texts_.empty()) {
        next = texts_.front();
        texts_.pop_front();
        socket_.text(true);
    } else if (bye_) {
        return close({websocket::close_code::going_away, "the program ends"});
    } else if (state_) {
        next = std::make_shared<const std::string>(coder_.encode(*state_));
        state_.reset();
        socket_.binary(true);
        ++server_.traffic.frames;
    } else
        return;
    writing_ = true;
    writing_since_ = Clock::now();
    socket_.async_write(asio::buffer(*next), [self = shared_from_this(), next](Code error, std::size_t) {
        self->writing_ = false;
        if (error) return self->gone();
        if (self->closing_) {
            if (self->farewell_)
                self->socket_.async_close(*std::exchange(self->farewell_, {}), [self](Code) { self->gone(); });
            return;
        }
        self->write();
    });
}

void PageSocket::drop(const char* kind) {
    if (!closing_) server_.refuse(kind);
    gone();
}

void PageSocket::leave() {
    if (left_) return;
    left_ = true;
    if (open_) server_.show.leave(client_);
}

void PageSocket::gone() {
    closing_ = true;
    leave();
    beast::get_lowest_layer(socket_).close();
    if (server_.pages.erase(client_) > 0) --server_.traffic.clients;
}
}  // namespace tissue::serve
