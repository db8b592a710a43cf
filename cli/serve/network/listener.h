#pragma once

#include <map>
#include <set>

#include "../access.h"
#include "../metrics.h"
#include "../show.h"
#include "beast.h"
#include "limits.h"
#include "server.h"

namespace tissue::serve {

class PageSocket;
class Visitor;

/// Shared by all connections of one server: the port, the show and its clock, the connected pages. Not thread-safe.
class Listener {
   public:
    Listener(Stage& stage, const ServerOptions& options);

    void listen();                           ///< throws Error when the address or the port is not available
    void accept();
    void step();                             ///< a step of the show; schedules the next
    void finish(const std::string& reason);  ///< stops the force first, then informs the clients
    void tell(Show::Client client, const std::string& text);
    void refuse(const char* kind) { ++traffic.refused[kind]; }

    /// Gives a connection a seat. If all are taken, the HTTP connection with the lowest priority is closed; pages are
    /// never closed.
    void seat(Tcp::socket socket);

    ServerOptions options;
    const std::string session = draw_secret();  ///< a path that pages of other servers do not have
    Stage& stage;
    int connections = 0, next_client = 0, port = 0;
    bool ending = false;
    std::map<std::string, Neighbour> neighbours;
    std::set<Visitor*> visitors;
    asio::io_context context{1};  // declared after what its connections refer to
    Tcp::acceptor acceptor;
    asio::signal_set signals;
    asio::steady_timer tick, end, again;
    Traffic traffic;
    std::map<Show::Client, std::shared_ptr<PageSocket>> pages;
    Show show;

   private:
    Neighbour& neighbour(const asio::ip::address& address);
    bool make_room(const Neighbour* of);
};

}  // namespace tissue::serve
