#include "listener.h"

#include <fmt/format.h>

#include <csignal>

#include "error.h"
#include "limits.h"
#include "page_socket.h"
#include "visitor.h"

namespace tissue::serve {

Listener::Listener(Stage& s, const ServerOptions& o)
    : options(o), stage(s), acceptor(context), signals(context, SIGINT, SIGTERM), tick(context), end(context), again(context),
      show(s, [this](Show::Client client, const std::string& text) { tell(client, text); }) {
    struct sigaction hangup {};
    if (::sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) signals.add(SIGHUP);  // under nohup it goes on
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

void Listener::step() {
    if (show.step(now_s())) {
        const auto frame = std::make_shared<const Frame>(show.frame());
        for (const auto& [client, page] : pages) page->offer(frame);
    }
    std::vector<std::shared_ptr<PageSocket>> all;
    for (const auto& [client, page] : pages) all.push_back(page);
    for (const auto& page : all) page->check_speed();
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
