#include "listener.h"

#include <fmt/format.h>

#include <csignal>

#include "error.h"
#include "limits.h"
#include "page_socket.h"
#include "visitor.h"

namespace tissue::serve {
namespace {

std::string group_of(const asio::ip::address& address) {
    if (address.is_loopback()) return "loopback";  // local users may use any loopback address
    if (address.is_v4()) return address.to_string();
    const asio::ip::address_v6 v6 = address.to_v6();
    if (v6.is_v4_mapped()) return group_of(asio::ip::make_address_v4(asio::ip::v4_mapped, v6));
    const auto bytes = v6.to_bytes();
    return {bytes.begin(), bytes.begin() + 8};
}

}  // namespace

Listener::Listener(Stage& s, const ServerOptions& o)
    : options(o), stage(s), acceptor(context), signals(context, SIGINT, SIGTERM), tick(context), end(context), again(context),
      show(s, [this](Show::Client client, const std::string& text) { tell(client, text); }) {
    struct sigaction hangup {};
    // under nohup SIGHUP is ignored and the program continues
    if (::sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) signals.add(SIGHUP);
}

void Listener::listen() {
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

void Listener::accept() {
    if (ending) return;
    acceptor.async_accept([this](Code error, Tcp::socket socket) {
        if (ending || error == asio::error::operation_aborted) return;
        if (error) {  // out of file descriptors: try again later
            again.expires_after(std::chrono::milliseconds(100));
            again.async_wait([this](Code) { accept(); });
            return;
        }
        ++traffic.connections;
        Code ignored;
        socket.set_option(Tcp::no_delay(true), ignored);
        seat(std::move(socket));
        accept();
    });
}

void Listener::seat(Tcp::socket socket) {
    Code error;
    const Tcp::endpoint from = socket.remote_endpoint(error);
    if (!error) socket.non_blocking(true, error);
    if (error) return;  // the peer has disconnected already
    Neighbour& of = neighbour(from.address());
    const bool crowded = of.connections >= connections_of_address;
    if ((crowded || connections >= connections_max) && !make_room(crowded ? &of : nullptr)) {
        refuse("connections");
        return Visitor::send_off(socket, http::status::service_unavailable, "all connections are taken by pages; try again later");
    }
    std::make_shared<Visitor>(*this, Seat(connections, of), std::move(socket))->read();
}

/// Closes an HTTP connection of this address; of any address for nullptr. False if there is none.
bool Listener::make_room(const Neighbour* of) {
    Visitor* first = nullptr;
    for (Visitor* visitor : visitors)
        if ((!of || &visitor->neighbour() == of) && (!first || visitor->goes_before(*first))) first = visitor;
    if (!first) return false;
    refuse("connections");
    first->send_off(http::status::service_unavailable, "too many connections; this one was closed to accept another");
    return true;
}

Neighbour& Listener::neighbour(const asio::ip::address& address) {
    if (neighbours.size() >= addresses_max)
        for (auto at = neighbours.begin(); at != neighbours.end();) at = at->second.connections == 0 ? neighbours.erase(at) : std::next(at);
    return neighbours[group_of(address)];
}

void Listener::step() {
    if (show.step(now_s())) {
        const auto frame = std::make_shared<const Frame>(show.frame());
        for (const auto& [client, page] : pages) page->offer(frame);
    }
    std::vector<std::shared_ptr<PageSocket>> all;
    for (const auto& [client, page] : pages) all.push_back(page);
    for (const auto& page : all) page->check_speed();
    const std::set<Visitor*> now = visitors;
    for (Visitor* visitor : now) visitor->check_time();
    if (stage.failed()) return finish("the simulation has failed");
    tick.expires_after(step_time);
    tick.async_wait([this](Code) {
        if (!ending) step();
    });
}

void Listener::tell(Show::Client client, const std::string& text) {
    const auto found = pages.find(client);
    if (found == pages.end()) return;
    if (text.compare(0, 16, R"({"type":"model",)") == 0) found->second->forget_state();
    found->second->tell(text);
}

void Listener::finish(const std::string& reason) {
    if (ending) return;
    ending = true;
    stage.stop();
    Code ignored;
    acceptor.close(ignored);
    signals.cancel(ignored);
    tick.cancel();
    end.cancel();
    again.cancel();
    std::vector<std::shared_ptr<PageSocket>> all;
    for (const auto& [client, page] : pages) all.push_back(page);
    for (const auto& page : all) page->say_bye(reason);
}

}  // namespace tissue::serve
