#include "visitor.h"

#include <fmt/format.h>

#include <sstream>
#include <tuple>

#include "../access.h"
#include "../page.h"
#include "listener.h"
#include "page_socket.h"
#include "version.h"

namespace tissue::serve {
namespace {

std::string view(beast::string_view text) {
    return {text.data(), text.size()};
}

std::string head_text(const http::response<http::empty_body>& head) {
    std::ostringstream out;
    out << head.base();
    return out.str();
}

}  // namespace

Visitor::Visitor(Listener& server, Seat seat, Tcp::socket socket) : server_(server), seat_(std::move(seat)), stream_(std::move(socket)) {
    server_.visitors.insert(this);
}

Visitor::~Visitor() {
    leave();
}

void Visitor::read() {
    answering_ = false;
    since_ = Clock::now();
    spoke_ = buffer_.size() > 0;
    parser_.emplace();
    parser_->header_limit(8192);
    parser_->body_limit(0);
    if (spoke_) return read_header();
    stream_.async_read_some(buffer_.prepare(4096), [self = shared_from_this()](Code error, std::size_t size) {
        if (error || self->gone_) return self->close();
        self->buffer_.commit(size);
        self->spoke_ = true;
        self->read_header();
    });
}

void Visitor::read_header() {
    http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](Code error, std::size_t) { self->have_read(error); });
}

void Visitor::have_read(Code error) {
    if (gone_ || error == http::error::end_of_stream || error == asio::error::connection_reset || error == asio::error::operation_aborted ||
        error == asio::error::eof)
        return close();
    if (error) return answer(refuse("malformed", http::status::bad_request, "not an HTTP request: " + error.message()));
    ++server_.traffic.requests;
    keep_ = parser_->keep_alive() && !server_.ending;
    const http::request<http::empty_body>& request = parser_->get();
    if (std::optional<Answer> refused = refusal(request)) return answer(std::move(*refused));
    if (path_of(view(request.target())) == "/ws" && request.method() == http::verb::get) return upgrade(request);
    answer(answer_to(request));
}

/// Why a request is refused; nullopt when it is let in.
std::optional<Visitor::Answer> Visitor::refusal(const http::request<http::empty_body>& request) {
    const std::string host = view(request[http::field::host]), origin = view(request[http::field::origin]), target = view(request.target()),
                      cookie = view(request[http::field::cookie]);
    const std::optional<Refusal> why =
        serve::refuse({host, origin, target, cookie, request.count(http::field::origin) > 0}, server_.options.token, server_.port);
    if (!why) admitted_ = true;
    Neighbour& of = seat_.neighbour();
    if (!(why ? of.others : of.admitted).take()) {
        Answer refused = refuse("requests", http::status::too_many_requests, fmt::format("more than {} requests a second from one address", requests_s));
        refused.head.set(http::field::retry_after, "1");
        return refused;
    }
    if (why) return refuse(why->kind, std::string(why->kind) == "token" ? http::status::unauthorized : http::status::forbidden, why->reason);
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
        Answer refused = refuse("method", http::status::method_not_allowed, "only GET and HEAD are allowed");
        refused.head.set(http::field::allow, "GET, HEAD");
        return refused;
    }
    if (!parser_->is_done()) return refuse("body", http::status::payload_too_large, "a request must have no body");
    return {};
}

Visitor::Answer Visitor::answer_to(const http::request<http::empty_body>& request) {
    const std::string target = view(request.target());
    const std::string_view path = path_of(target);
    if (path == "/ws") return text(http::status::bad_request, "only for a WebSocket");
    if (path == "/healthz") return text(http::status::ok, "ok");
    if (const std::string& surface = server_.show.stage().scene().carried(); path == "/surface" && !surface.empty()) {
        Answer bytes = text(http::status::ok, "");
        bytes.file = surface;  // constant while the server runs
        bytes.head.set(http::field::content_type, "application/octet-stream");
        return bytes;
    }
    if (path == "/metrics") {
        Answer metrics = text(http::status::ok, metrics_text(server_.show, server_.traffic));
        metrics.head.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
        return metrics;
    }
    // removes the token from the address bar
    if (const auto token = token_in_query(target); path == "/" && token && !server_.options.token.empty()) {
        // Lax: after a link on another site, such as in a mail, a browser would not send a Strict cookie to the
        // redirected address
        Answer moved = text(http::status::see_other, "the page is at its own path");
        moved.head.set(http::field::location, "/" + server_.session + "/");
        moved.head.set(http::field::set_cookie, fmt::format("{}={}; Path=/{}/; HttpOnly; SameSite=Lax", cookie_name(server_.port), *token, server_.session));
        return moved;
    }
    return page(request, path);
}

Visitor::Answer Visitor::page(const http::request<http::empty_body>& request, std::string_view path) {
    const PageFile* file = page_file(path);
    if (!file) return text(http::status::not_found, "not found");
    Answer page;
    page.head.result(http::status::ok);
    page.file = file->text;
    page.head.set(http::field::content_type, std::string(file->type));
    page.head.set("Content-Security-Policy", fmt::format("default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self' ws://{}; "
                                                         "base-uri 'none'; form-action 'none'; frame-ancestors 'none'", view(request[http::field::host])));
    return page;
}

void Visitor::upgrade(const http::request<http::empty_body>& request) {
    if (!websocket::is_upgrade(request)) {
        Answer refused = refuse("malformed", http::status::upgrade_required, "only for a WebSocket");
        refused.head.set(http::field::upgrade, "websocket");
        return answer(std::move(refused));
    }
    if (server_.ending || static_cast<int>(server_.pages.size()) >= server_.options.clients)
        return answer(refuse("clients", http::status::service_unavailable, fmt::format("{} pages are connected already", server_.pages.size())));
    const Show::Client client = server_.next_client++;
    server_.visitors.erase(this);
    const auto page = std::make_shared<PageSocket>(server_, std::move(seat_), std::move(stream_), client);
    server_.pages[client] = page;
    ++server_.traffic.clients;
    page->start(request);
}

void Visitor::check_time() {
    const auto past = std::chrono::duration<double>(Clock::now() - since_).count(), whole = std::chrono::duration<double>(request_time).count();
    if (lingering_) {
        if (past > std::chrono::duration<double>(farewell_time).count()) close();
        return;
    }
    if (answering_) {
        if (past > whole + static_cast<double>(written_) / download_B_s) {
            server_.refuse("slow");
            close();
        }
        return;
    }
    if (!spoke_ && admitted_) {  // between two requests, after which a browser opens another connection
        if (past > whole) close();
    } else if (!spoke_ && past > std::chrono::duration<double>(first_byte_time).count()) {
        server_.refuse("late");
        send_off(http::status::request_timeout, fmt::format("no data was received within {} s", first_byte_time.count()));
    } else if (past > whole) {
        server_.refuse("late");
        send_off(http::status::request_timeout, fmt::format("no complete request was received within {} s", request_time.count()));
    }
}

bool Visitor::goes_before(const Visitor& other) const {
    const auto reason = [](const Visitor& v) {
        return std::tuple(!v.admitted_ || v.lingering_ ? 0 : v.answering_ ? 2 : 1, -v.neighbour().connections, v.since_);
    };
    return reason(*this) < reason(other);
}

void Visitor::send_off(http::status status, const std::string& reason) {
    if (gone_) return;
    if (!answering_) send_off(stream_.socket(), status, reason);
    close();
}

void Visitor::send_off(Tcp::socket& socket, http::status status, const std::string& reason) {
    Answer last = text(status, reason);
    last.head.keep_alive(false);
    last.head.content_length(last.text.size());
    Code ignored;
    socket.write_some(asio::buffer(head_text(last.head) + last.text), ignored);
    socket.shutdown(Tcp::socket::shutdown_send, ignored);
    char unread[4096];  // with unread bytes the system would discard the answer
    for (int k = 0; k < 16 && socket.read_some(asio::buffer(unread), ignored) == sizeof unread; ++k) {}
}

Visitor::Answer Visitor::refuse(const char* kind, http::status status, std::string words) {
    server_.refuse(kind);
    keep_ = false;
    return text(status, std::move(words));
}

Visitor::Answer Visitor::text(http::status status, std::string words) {
    Answer answer;
    answer.head.result(status);
    if (status != http::status::ok) words += '\n';
    answer.head.set(http::field::content_type, "text/plain; charset=utf-8");
    answer.text = std::move(words);
    return answer;
}

void Visitor::answer(Answer given) {
    answer_ = std::move(given);
    http::response<http::empty_body>& head = answer_.head;
    const std::string_view body = answer_.file.empty() ? std::string_view(answer_.text) : answer_.file;
    head.version(11);
    head.set(http::field::server, std::string("tissuectl/") + version);
    head.set(http::field::cache_control, "no-store");
    head.set("X-Content-Type-Options", "nosniff");
    head.set("Referrer-Policy", "no-referrer");
    head.set("Cross-Origin-Resource-Policy", "same-origin");
    head.keep_alive(keep_);
    head.content_length(body.size());
    head_ = head_text(head);
    // the content length of a HEAD answer stays
    const bool bare = parser_->is_header_done() && parser_->get().method() == http::verb::head;
    rest_.emplace(std::array{asio::const_buffer(head_.data(), head_.size()), asio::const_buffer(body.data(), bare ? 0 : body.size())});
    written_ = 0;
    answering_ = true;
    since_ = Clock::now();
    write();
}

void Visitor::write() {
    stream_.async_write_some(*rest_, [self = shared_from_this()](Code error, std::size_t size) {
        if (error || self->gone_) return self->close();
        self->written_ += size;
        self->rest_->consume(size);
        if (asio::buffer_size(*self->rest_) > 0) return self->write();
        if (!self->keep_) return self->linger();
        self->read();
    });
}

/// Reads and discards what still arrives, for a second. If a connection is closed with unread bytes, the system
/// discards the answer.
void Visitor::linger() {
    Code ignored;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    lingering_ = true;
    since_ = Clock::now();
    buffer_.clear();
    discard(0);
}

void Visitor::discard(int times) {
    if (times == 64) return close();
    stream_.async_read_some(buffer_.prepare(16 * 1024), [self = shared_from_this(), times](Code error, std::size_t) {
        if (error) return self->close();
        self->discard(times + 1);
    });
}

/// Frees the seat at once; pending operations end by themselves.
void Visitor::close() {
    if (gone_) return;
    gone_ = true;
    leave();
    Code ignored;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    stream_.close();
}

void Visitor::leave() {
    server_.visitors.erase(this);
    seat_.give_up();
}
}  // namespace tissue::serve
