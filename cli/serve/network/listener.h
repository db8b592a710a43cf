#pragma once

#include <map>

#include "../metrics.h"
#include "../show.h"
#include "beast.h"
#include "server.h"

namespace tissue::serve {

class PageSocket;

/// What all connections of one server share: the port, the show and its clock, the pages that are connected. One thread's.
class Listener {
   public:
    Listener(Stage& stage, const ServerOptions& options);

    void listen();                           ///< throws Error when the address or the port cannot be had
    void accept();
    void step();                             ///< of the show, and all that follow
    void finish(const std::string& reason);  ///< no force first; then the clients are told
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
    std::map<Show::Client, std::shared_ptr<PageSocket>> pages;
    Show show;
};

}  // namespace tissue::serve
