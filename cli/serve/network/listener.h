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

    /// Gives a connection a seat. Where all are taken, the HTTP connection that has most reason to go gives way; a page never does.
    void seat(Tcp::socket socket);

    ServerOptions options;
    const std::string session = draw_secret();  ///< a path, which no other server's pages know
    Stage& stage;
    int connections = 0, next_client = 0, port = 0;
    bool ending = false;
    std::map<std::string, Neighbour> neighbours;
    std::set<Visitor*> visitors;
    asio::io_context context{1};  // after what its connections refer to
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
