#pragma once

#include <memory>
#include <string>

#include "../stage.h"

namespace tissue::serve {

struct ServerOptions {
    std::string bind = "127.0.0.1";   ///< address to listen on
    int port = 0;                     ///< 0: any that is free
    std::string token;                ///< wanted from every request; empty: none
    int clients = 8;                  ///< pages at a time
    double seconds = 0;               ///< 0: until a signal
};

class Listener;

/// HTTP and WebSocket about one stage, in the calling thread.
class Server {
   public:
    /// Listens from here on. Throws Error when the address or the port cannot be had.
    Server(Stage& stage, const ServerOptions& options);
    ~Server();

    int port() const;
    std::string url() const;     ///< with the token, if one is wanted: for the one who started it

    /// Serves until SIGINT, SIGTERM, or the time is up. The stage has stopped before the clients are told.
    void run();

   private:
    std::unique_ptr<Listener> listener_;
};

/// Whether an address is this machine's own, which nobody else can reach. Throws Error when it is no address.
bool is_loopback(const std::string& address);

}  // namespace tissue::serve
