#include "server.h"

#include <fmt/format.h>

#include "error.h"
#include "limits.h"
#include "listener.h"
#include "page_socket.h"

namespace tissue::serve {

bool is_loopback(const std::string& address) {
    Code error;
    const asio::ip::address parsed = asio::ip::make_address(address, error);
    if (error) throw Error(fmt::format("'{}' is not an address in digits", address));
    return parsed.is_loopback();
}

Server::Server(Stage& stage, const ServerOptions& options) : listener_(std::make_unique<Listener>(stage, options)) {
    listener_->listen();
}

Server::~Server() = default;

int Server::port() const {
    return listener_->port;
}

std::string Server::url() const {
    const auto& o = listener_->options;
    const std::string host = o.bind.find(':') == std::string::npos ? o.bind : "[" + o.bind + "]";
    return fmt::format("http://{}:{}/{}", host, listener_->port, o.token.empty() ? "" : "?token=" + o.token);
}

void Server::run() {
    Listener& s = *listener_;
    s.signals.async_wait([&s](Code error, int) {
        if (!error) s.finish("the program ends");
    });
    if (s.options.seconds > 0) {
        s.end.expires_after(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s.options.seconds)));
        s.end.async_wait([&s](Code error) {
            if (!error) s.finish("the time limit of the session is reached");
        });
    }
    s.accept();
    s.step();
    while (!s.ending) s.context.run_one();
    s.context.run_for(farewell_time);
    s.context.stop();
}

}  // namespace tissue::serve
