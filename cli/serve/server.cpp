#include "server.h"

#include <fmt/format.h>

#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <csignal>
#include <deque>
#include <set>

#include "access.h"
#include "error.h"
#include "metrics.h"
#include "page.h"
#include "show.h"
#include "version.h"

namespace tissue::serve {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using Code = beast::error_code;
using Clock = std::chrono::steady_clock;
using Text = std::shared_ptr<const std::string>;

constexpr std::chrono::seconds request_time{5};    ///< for a whole request, and between two of a connection
constexpr std::chrono::seconds idle_time{20};      ///< a page that answers no ping for this long is gone
constexpr std::chrono::seconds slow_time{2};       ///< a page that takes longer to take one message is too slow
constexpr std::chrono::milliseconds step_time{16}; ///< of the show: 60 a second
constexpr std::chrono::seconds farewell_time{1};   ///< for clients to close, at the end
constexpr std::size_t longest_queue = 64;          ///< texts that wait for one page
constexpr int send_buffer = 64 * 1024;             ///< so that a page that does not read shows soon
constexpr int connections_max = 64;                ///< of all kinds at a time
constexpr double messages_s = 250;                 ///< of one page: a mouse says 60 to 125

double now_s() {
    return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// So many a second, and as many at once.
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

std::string view(beast::string_view text) {
    return {text.data(), text.size()};
}

}  // namespace

bool is_loopback(const std::string& address) {
    Code error;
    const asio::ip::address parsed = asio::ip::make_address(address, error);
    if (error) throw Error(fmt::format("'{}' is not an address in digits", address));
    return parsed.is_loopback();
}

// ---- what all connections share

class Page;

struct Server::Impl {
    Impl(Stage& s, const ServerOptions& o)
        : options(o), stage(s), acceptor(context), signals(context, SIGINT, SIGTERM), tick(context), end(context), again(context),
          show(s, [this](Show::Client client, const std::string& text) { tell(client, text); }) {}

    void listen();
    void accept();
    void step();
    void finish(const std::string& reason);
    void tell(Show::Client client, const std::string& text);
    void refuse(const char* kind) { ++traffic.refused[kind]; }

    ServerOptions options;
    Stage& stage;
    int connections = 0, next_client = 0, port = 0;
    bool ending = false;
    asio::io_context context{1};
    Tcp::acceptor acceptor;
    asio::signal_set signals;
    asio::steady_timer tick, end, again;
    Traffic traffic;
    std::map<Show::Client, std::shared_ptr<Page>> pages;
    Show show;
};

namespace {

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

}  // namespace

// ---- one page: a WebSocket

class Page : public std::enable_shared_from_this<Page> {
   public:
    Page(Server::Impl& server, Seat seat, beast::tcp_stream stream, Show::Client client)
        : server_(server), seat_(std::move(seat)), socket_(std::move(stream)), client_(client) {}

    void start(const http::request<http::empty_body>& request) {
        websocket::stream_base::timeout times{};
        times.handshake_timeout = request_time;
        times.idle_timeout = idle_time;
        times.keep_alive_pings = true;
        socket_.set_option(times);
        socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& answer) {
            answer.set(http::field::server, std::string("tissuectl/") + version);
        }));
        socket_.read_message_max(0);  // the limit is ours, so that it comes with a reason
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

    void tell(const std::string& text) {
        if (closing_) return;
        if (texts_.size() >= longest_queue) {  // not now: the show is talking to everyone
            too_slow_ = true;
            return;
        }
        texts_.push_back(std::make_shared<std::string>(text));
        write();
    }

    void offer(const Text& state) {
        if (!open_ || closing_) return;
        if (state_) ++server_.traffic.frames_dropped;
        state_ = state;
        write();
    }

    /// States of a model that runs no more are worth nothing.
    void forget_state() { state_.reset(); }

    void check_speed() {
        if (too_slow_ || (writing_ && Clock::now() - writing_since_ > slow_time)) drop("slow");
    }

    /// Says why, closes, and waits for the other side only as long as the timeouts allow.
    void close(const websocket::close_reason& reason) {
        if (closing_) return;
        closing_ = true;
        leave();
        if (writing_) {  // after what is on its way
            farewell_ = reason;
            return;
        }
        socket_.async_close(reason, [self = shared_from_this()](Code) { self->gone(); });
    }

    void say_bye(const std::string& reason) {
        tell(bye_message(reason));
        if (!closing_) bye_ = true;
        write();
    }

   private:
    void read() {
        socket_.async_read_some(buffer_, longest_message + 1 - buffer_.size(), [self = shared_from_this()](Code error, std::size_t) {
            self->have_read(error);
        });
    }

    void have_read(Code error) {
        if (error) return gone();
        if (closing_) return;
        if (!allowance_.take()) return refuse_flood();  // a piece of a message costs as much as a whole one
        if (buffer_.size() > longest_message)
            return refuse(websocket::close_code::too_big, {"too_long", fmt::format("a message of more than {} bytes", longest_message)});
        if (!socket_.is_message_done()) return read();
        ++server_.traffic.messages;
        if (!socket_.got_text()) return refuse(websocket::close_code::policy_error, {"message", "a message is text"});
        const std::string text = beast::buffers_to_string(buffer_.data());
        buffer_.consume(buffer_.size());
        if (const std::optional<Refusal> refusal = server_.show.hear(client_, text, now_s()))
            return refuse(websocket::close_code::policy_error, *refusal);
        if (!closing_) read();
    }

    void refuse_flood() { refuse(websocket::close_code::policy_error, {"rate", "too many messages a second"}); }

    void refuse(websocket::close_code code, const Refusal& refusal) {
        if (closing_) return;
        server_.refuse(refusal.kind);
        close({code, refusal.reason});
    }

    void write() {
        if (writing_ || !open_ || (closing_ && !farewell_)) return;
        Text next;
        if (!texts_.empty()) {
            next = texts_.front();
            texts_.pop_front();
            socket_.text(true);
        } else if (bye_) {
            return close({websocket::close_code::going_away, "the program ends"});
        } else if (state_) {
            next = std::move(state_);
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

    /// Without a word: it would not be read.
    void drop(const char* kind) {
        if (!closing_) server_.refuse(kind);
        gone();
    }

    void leave() {
        if (left_) return;
        left_ = true;
        if (open_) server_.show.leave(client_);
    }

    void gone() {
        closing_ = true;
        leave();
        beast::get_lowest_layer(socket_).close();
        if (server_.pages.erase(client_) > 0) --server_.traffic.clients;
    }

    Server::Impl& server_;
    Seat seat_;
    websocket::stream<beast::tcp_stream> socket_;
    Show::Client client_;
    beast::flat_buffer buffer_;
    std::deque<Text> texts_;
    Text state_;
    std::optional<websocket::close_reason> farewell_;
    Allowance allowance_;
    Clock::time_point writing_since_;
    bool open_ = false, writing_ = false, closing_ = false, left_ = false, bye_ = false,
         flooded_ = false, too_slow_ = false;
};

// ---- one connection that speaks HTTP

class Visitor : public std::enable_shared_from_this<Visitor> {
   public:
    Visitor(Server::Impl& server, Tcp::socket socket)
        : server_(server), seat_(server.connections), stream_(std::move(socket)) {}

    void read() {
        parser_.emplace();
        parser_->header_limit(8192);
        parser_->body_limit(0);
        stream_.expires_after(request_time);
        http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](Code error, std::size_t) {
            self->have_read(error);
        });
    }

   private:
    using Answer = http::response<http::string_body>;

    void have_read(Code error) {
        if (error == http::error::end_of_stream || error == beast::error::timeout || error == asio::error::connection_reset ||
            error == asio::error::operation_aborted || error == asio::error::eof)
            return close();
        if (error) {
            server_.refuse("malformed");
            keep_ = false;
            return answer(text(http::status::bad_request, "not an HTTP request: " + error.message()));
        }
        ++server_.traffic.requests;
        keep_ = parser_->keep_alive() && !server_.ending;
        const http::request<http::empty_body>& request = parser_->get();
        const std::string host = view(request[http::field::host]), origin = view(request[http::field::origin]),
                          target = view(request.target()), cookie = view(request[http::field::cookie]);
        if (const std::optional<Refusal> refusal =
                serve::refuse({host, origin, target, cookie, request.count(http::field::origin) > 0}, server_.options.token)) {
            server_.refuse(refusal->kind);
            keep_ = false;
            return answer(text(std::string(refusal->kind) == "token" ? http::status::unauthorized : http::status::forbidden, refusal->reason));
        }
        const std::string path(path_of(target));
        const bool get = request.method() == http::verb::get, head = request.method() == http::verb::head;
        if (!get && !head) {
            server_.refuse("method");
            keep_ = false;
            Answer refused = text(http::status::method_not_allowed, "only GET and HEAD");
            refused.set(http::field::allow, "GET, HEAD");
            return answer(std::move(refused));
        }
        if (!parser_->is_done()) {  // a body
            server_.refuse("body");
            keep_ = false;
            return answer(text(http::status::payload_too_large, "a request has no body"));
        }
        if (path == "/ws") return get ? upgrade(request) : answer(text(http::status::bad_request, "a WebSocket"));
        if (path == "/healthz") return answer(text(http::status::ok, "ok"));
        if (path == "/metrics") {
            Answer metrics = text(http::status::ok, metrics_text(server_.show, server_.traffic));
            metrics.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
            return answer(std::move(metrics));
        }
        const PageFile* file = page_file(path);
        if (!file) return answer(text(http::status::not_found, "there is nothing here"));
        Answer page = text(http::status::ok, std::string(file->text));
        page.set(http::field::content_type, std::string(file->type));
        page.set("Content-Security-Policy", fmt::format("default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
                                                        "connect-src 'self' ws://{}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'", host));
        if (const auto token = token_in_query(target); token && !server_.options.token.empty())
            page.set(http::field::set_cookie, "tissue_token=" + *token + "; Path=/; HttpOnly; SameSite=Strict");
        answer(std::move(page));
    }

    void upgrade(const http::request<http::empty_body>& request) {
        if (!websocket::is_upgrade(request)) {
            server_.refuse("malformed");
            Answer refused = text(http::status::upgrade_required, "a WebSocket");
            refused.set(http::field::upgrade, "websocket");
            return answer(std::move(refused));
        }
        if (server_.ending || static_cast<int>(server_.pages.size()) >= server_.options.clients) {
            server_.refuse("clients");
            keep_ = false;
            return answer(text(http::status::service_unavailable, fmt::format("{} pages are connected already", server_.pages.size())));
        }
        const Show::Client client = server_.next_client++;
        stream_.expires_never();
        const auto page = std::make_shared<Page>(server_, std::move(seat_), std::move(stream_), client);
        server_.pages[client] = page;
        ++server_.traffic.clients;
        page->start(request);
    }

    Answer text(http::status status, std::string words) {
        Answer answer{status, 11};
        if (status != http::status::ok) words += '\n';
        answer.set(http::field::content_type, "text/plain; charset=utf-8");
        answer.body() = std::move(words);
        return answer;
    }

    void answer(Answer given) {
        answer_ = std::move(given);
        answer_.version(11);
        answer_.set(http::field::server, std::string("tissuectl/") + version);
        answer_.set(http::field::cache_control, "no-store");
        answer_.set("X-Content-Type-Options", "nosniff");
        answer_.set("Referrer-Policy", "no-referrer");
        answer_.set("Cross-Origin-Resource-Policy", "same-origin");
        answer_.keep_alive(keep_);
        answer_.prepare_payload();
        if (parser_->is_header_done() && parser_->get().method() == http::verb::head) answer_.body().clear();  // its length stays
        http::async_write(stream_, answer_, [self = shared_from_this()](Code error, std::size_t) {
            if (error || !self->keep_) return self->close();
            self->read();
        });
    }

    void close() {
        Code ignored;
        stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    }

    Server::Impl& server_;
    Seat seat_;
    beast::tcp_stream stream_;
    beast::flat_buffer buffer_{16 * 1024};
    std::optional<http::request_parser<http::empty_body>> parser_;
    Answer answer_;
    bool keep_ = false;
};

// ---- the server

void Server::Impl::listen() {
    const asio::ip::address address = asio::ip::make_address(options.bind);
    const Tcp::endpoint endpoint(address, static_cast<unsigned short>(options.port));
    Code error;
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor.set_option(asio::socket_base::send_buffer_size(send_buffer), error);  // connections inherit it
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(connections_max, error);
    if (error) throw Error(fmt::format("cannot listen on {} port {}: {}", options.bind, options.port, error.message()));
    port = acceptor.local_endpoint().port();
}

void Server::Impl::accept() {
    if (ending) return;
    acceptor.async_accept([this](Code error, Tcp::socket socket) {
        if (ending || error == asio::error::operation_aborted) return;
        if (error) {  // out of file descriptors: later again
            again.expires_after(std::chrono::milliseconds(100));
            again.async_wait([this](Code) { accept(); });
            return;
        }
        ++traffic.connections;
        Code ignored;
        socket.set_option(Tcp::no_delay(true), ignored);
        if (connections >= connections_max)
            refuse("connections");
        else
            std::make_shared<Visitor>(*this, std::move(socket))->read();
        accept();
    });
}

void Server::Impl::step() {
    if (show.step(now_s())) {
        const auto frame = std::make_shared<const std::string>(show.frame());
        for (const auto& [client, page] : pages) page->offer(frame);
    }
    std::vector<std::shared_ptr<Page>> all;
    for (const auto& [client, page] : pages) all.push_back(page);
    for (const auto& page : all) page->check_speed();
    if (stage.failed()) return finish("the simulation has failed");
    tick.expires_after(step_time);
    tick.async_wait([this](Code) {
        if (!ending) step();
    });
}

void Server::Impl::tell(Show::Client client, const std::string& text) {
    const auto found = pages.find(client);
    if (found == pages.end()) return;
    if (text.compare(0, 16, R"({"type":"model",)") == 0) found->second->forget_state();
    found->second->tell(text);
}

/// No force first; then the clients are told.
void Server::Impl::finish(const std::string& reason) {
    if (ending) return;
    ending = true;
    stage.stop();
    Code ignored;
    acceptor.close(ignored);
    signals.cancel(ignored);
    tick.cancel();
    end.cancel();
    again.cancel();
    std::vector<std::shared_ptr<Page>> all;
    for (const auto& [client, page] : pages) all.push_back(page);
    for (const auto& page : all) page->say_bye(reason);
}

Server::Server(Stage& stage, const ServerOptions& options) : impl_(std::make_unique<Impl>(stage, options)) {
    impl_->listen();
}

Server::~Server() = default;

int Server::port() const {
    return impl_->port;
}

std::string Server::url() const {
    const auto& o = impl_->options;
    const std::string host = o.bind.find(':') == std::string::npos ? o.bind : "[" + o.bind + "]";
    return fmt::format("http://{}:{}/{}", host, impl_->port, o.token.empty() ? "" : "?token=" + o.token);
}

void Server::run() {
    Impl& s = *impl_;
    s.signals.async_wait([&s](Code error, int) {
        if (!error) s.finish("the program ends");
    });
    if (s.options.seconds > 0) {
        s.end.expires_after(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s.options.seconds)));
        s.end.async_wait([&s](Code error) {
            if (!error) s.finish("the time is up");
        });
    }
    s.accept();
    s.step();
    while (!s.ending) s.context.run_one();
    s.context.run_for(farewell_time);
    s.context.stop();
}

}  // namespace tissue::serve
