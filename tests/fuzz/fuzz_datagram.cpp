// Datagrams to a RemoteDevice, and the ticks that read them. The input is a sequence of datagrams: a length byte, then
// as many bytes.
#include <arpa/inet.h>
#include <sys/socket.h>

#include <algorithm>

#include "../haptic/haptic_example.h"
#include "fuzz_file.h"
#include "haptic/remote_device.h"

using namespace tissue;

namespace {

/// A peer that sends positions and receives forces.
class Sender {
   public:
    explicit Sender(int port) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        to.sin_port = htons(static_cast<std::uint16_t>(port));
        must(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0, "no socket");
    }
    ~Sender() { ::close(socket_); }
    Sender(const Sender&) = delete;
    Sender& operator=(const Sender&) = delete;

    void send(const std::uint8_t* data, std::size_t size) { must(::send(socket_, data, size, 0) == static_cast<ssize_t>(size), "not sent"); }
    void hear() {
        char out[256];
        while (::recv(socket_, out, sizeof out, 0) > 0) {}
    }

   private:
    int socket_;
};

}  // namespace

FUZZ_TARGET(datagram)(const std::uint8_t* data, std::size_t size) {
    static const TissueModel tissue = energy_model_example(make_lattice("grid8", 2, 2, 0.1, 0.1));
    static const HapticModel model(tissue, {});
    RemoteDevice device(0);
    device.start();
    Sender sender(device.port());
    Simulation simulation(model);
    double time_s = 0;
    for (std::size_t at = 0; at < size && time_s < 0.04;) {
        const std::size_t length = std::min<std::size_t>(data[at] % 128, size - at - 1);
        sender.send(data + at + 1, length);
        at += 1 + length;
        for (int tick = 0; tick < 2; ++tick, time_s += 0.001) {
            const Eigen::Vector3d force_N = simulation.tick(device.read(time_s));
            must(force_N.allFinite() && force_N.norm() <= model.options.safety.force_max_N * (1 + 1e-12), "a force that is not finite or above its maximum");
            device.write(force_N);
            sender.hear();
        }
    }
    device.statistics();
    return 0;
}
