// The page's server, on a loopback connection: bytes of a client, HTTP first and then possibly WebSocket frames. Not in
// the library's tests, which do not use Boost.
#include <arpa/inet.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <thread>

#include "../../cli/serve/network/listener.h"
#include "../../cli/serve/network/page_socket.h"
#include "../haptic/haptic_example.h"
#include "fuzz_file.h"

using namespace tissue;
using namespace tissue::serve;

namespace {

std::string model_file() {
    const std::string file = FuzzFile::folder() + "/served.h5";
    write_model(file, haptic_example({"grid4", "isotropic", 3}), {"fuzz", 0, {}});
    return file;
}

class Visit {
   public:
    explicit Visit(int port) {
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        to.sin_port = htons(static_cast<std::uint16_t>(port));
        // Ports may run out for a moment, and libFuzzer's alarm interrupts connect().
        for (int tries = 0;; ++tries) {
            socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
            if (::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0) break;
            const int why = errno;
            ::close(socket_);
            must(tries < 100, std::strerror(why));
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
        const linger at_once{1, 0};  // otherwise each connection occupies a port for a minute
        ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    }
    ~Visit() { ::close(socket_); }
    Visit(const Visit&) = delete;
    Visit& operator=(const Visit&) = delete;

    /// False when the server has closed the connection, or does not read.
    bool send(const char* data, std::size_t size) { return ::send(socket_, data, size, MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(size); }
    void hear() {
        char answer[65536];
        while (::recv(socket_, answer, sizeof answer, MSG_DONTWAIT) > 0) {}
    }

   private:
    int socket_ = -1;
};

void work(Listener& server) {
    server.context.restart();
    for (int k = 0; k < 200 && server.context.poll_one() > 0; ++k) {}
}

}  // namespace

/// The input is a sequence of pieces. The byte before each piece is its length less one.
FUZZ_TARGET(server)(const std::uint8_t* data, std::size_t size) {
    static Stage stage({model_file()}, StageOptions{{}, false});
    static Listener& server = *[] {
        auto* listener = new Listener(stage, ServerOptions{});  // lives until the program ends, as its connections do
        listener->listen();
        listener->accept();
        return listener;
    }();
    {
        Visit visit(server.port);
        work(server);
        for (std::size_t at = 0; at < size;) {
            const std::size_t length = std::min<std::size_t>(std::size_t{1} + data[at], size - at - 1);
            if (!visit.send(reinterpret_cast<const char*>(data) + at + 1, length)) break;
            at += 1 + length;
            work(server);
            visit.hear();
        }
        server.step();
        work(server);
        visit.hear();
    }
    for (int k = 0; k < 2000 && server.connections > 0; ++k) {
        work(server);
        if (k > 20) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    must(server.connections == 0 && server.pages.empty(), "a closed connection or its page is still registered");
    return 0;
}
