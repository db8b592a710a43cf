#pragma once

#include <memory>
#include <string>

#include "../stage.h"

namespace tissue::serve {

struct ServerOptions {
    std::string bind = "127.0.0.1";   ///< address to listen on
    int port = 0;                     ///< 0: any free port
    std::string token;                ///< required of every request; empty: none
    int clients = 8;                  ///< largest number of pages at a time
    double seconds = 0;               ///< duration [s]; 0: until a signal
};

class Listener;

/// HTTP and WebSocket server of one stage; runs in the calling thread.
class Server {
   public:
    /// Listens from here on. Throws Error when the address or the port is not available.
    Server(Stage& stage, const ServerOptions& options);
    ~Server();

    int port() const;
    std::string url() const;     ///< with the token, if one is required

    /// Serves until SIGINT, SIGTERM or SIGHUP (which is ignored under nohup), until the time is up, or until the
    /// simulation fails. The stage stops before the clients are informed.
    void run();

   private:
    std::unique_ptr<Listener> listener_;
};

/// Whether an address is a loopback address, which only this machine can reach. Throws Error when it is not an address.
bool is_loopback(const std::string& address);

}  // namespace tissue::serve
