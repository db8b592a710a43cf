#include "visitor.h"

#include <fmt/format.h>

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

}  // namespace

Visitor::Visitor(Listener& server, Tcp::socket socket)
    : server_(server), seat_(server.connections), stream_(std::move(socket)) {}

void Visitor::read() {
    parser_.emplace();
    parser_->header_limit(8192);
    parser_->body_limit(0);
    stream_.expires_after(request_time);
    http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](Code error, std::size_t) {
        self->have_read(error);
    });
}

void Visitor::have_read(Code error) {
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

void Visitor::upgrade(const http::request<http::empty_body>& request) {
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
    const auto page = std::make_shared<PageSocket>(server_, std::move(seat_), std::move(stream_), client);
    server_.pages[client] = page;
    ++server_.traffic.clients;
    page->start(request);
}

Visitor::Answer Visitor::text(http::status status, std::string words) {
    Answer answer{status, 11};
    if (status != http::status::ok) words += '\n';
    answer.set(http::field::content_type, "text/plain; charset=utf-8");
    answer.body() = std::move(words);
    return answer;
}

void Visitor::answer(Answer given) {
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

void Visitor::close() {
    Code ignored;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
}
}  // namespace tissue::serve
