#include "haptic/remote_device.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "haptic/device_error.h"

namespace tissue {

const DeviceKind RemoteDevice::kind = {
    "remote",
    {{"port", "number", "47474", "of remote: UDP, on this machine alone", false,
      [](const std::string& text) -> std::string {
          char* end = nullptr;
          const long port = std::strtol(text.c_str(), &end, 10);
          return !text.empty() && *end == '\0' && port >= 0 && port <= 65535 ? "" : "wanted a number from 0 to 65535, not " + text;
      }}},
    [](const DeviceValues& v, const DeviceContext&) -> std::unique_ptr<Device> {
        return std::make_unique<RemoteDevice>(std::stoi(v.at("port")));
    }};

RemoteDevice::RemoteDevice(int port) {
    socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (socket_ < 0) throw DeviceError(fmt::format("remote device: no socket: {}", std::strerror(errno)));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    socklen_t length = sizeof address;
    if (::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
        ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
        const std::string why = std::strerror(errno);
        ::close(socket_);
        throw DeviceError(fmt::format("remote device: cannot listen on UDP port {} of this machine: {}", port, why));
    }
    port_ = ntohs(address.sin_port);
}

RemoteDevice::~RemoteDevice() {
    ::close(socket_);
}

DeviceSample RemoteDevice::read(double time_s) noexcept {
    time_s_ = time_s;
    SensorDatagram datagram;
    const PositionDatagram& in = datagram.position;
    sockaddr_in from{};
    constexpr int most = 64;  // a flood must not hold up the tick
    constexpr double leads_s = 0.5;
    for (int k = 0; k < most; ++k) {
        socklen_t length = sizeof from;
        const ssize_t size = ::recvfrom(socket_, &datagram, sizeof datagram, MSG_TRUNC, reinterpret_cast<sockaddr*>(&from), &length);
        if (size < 0) break;
        const bool sensor = size == sizeof datagram && std::memcmp(in.magic, "TSP2", 4) == 0;
        if (!sensor && (size != sizeof in || std::memcmp(in.magic, "TSP1", 4) != 0)) {
            ++foreign_;
            continue;
        }
        const bool same_peer = has_peer_ && from.sin_port == peer_.sin_port && from.sin_addr.s_addr == peer_.sin_addr.s_addr;
        const bool led = has_peer_ && time_s - received_s_ < leads_s;
        if (led && !same_peer) {
            ++others_;
            continue;
        }
        const auto ahead = static_cast<std::int32_t>(in.sequence - sequence_);
        const bool goes_on = led && same_peer;  // after a silence its numbers may begin anew
        if (goes_on && ahead <= 0) {
            ++late_;
            continue;
        }
        if (goes_on) lost_ += ahead - 1;
        ++received_;
        peer_ = from;
        has_peer_ = true;
        sequence_ = in.sequence;
        received_s_ = time_s;
        position_m_ = Eigen::Vector3d(in.position_m[0], in.position_m[1], in.position_m[2]);
        measured_N_ = sensor ? Eigen::Vector3d(datagram.measured_N[0], datagram.measured_N[1], datagram.measured_N[2]) : DeviceSample().measured_N;
    }
    if (!has_peer_) ++waiting_;
    DeviceSample sample;
    sample.position_m = position_m_;
    sample.measured_N = measured_N_;
    sample.valid = has_peer_;
    sample.age_s = time_s - received_s_;
    return sample;
}

void RemoteDevice::write(const Eigen::Vector3d& force_N) noexcept {
    if (!has_peer_) return;
    const ForceDatagram out{{'T', 'S', 'F', '1'}, sequence_, time_s_ - received_s_,
                            {force_N.x(), force_N.y(), force_N.z()}, static_cast<double>(sent_)};
    if (::sendto(socket_, &out, sizeof out, 0, reinterpret_cast<const sockaddr*>(&peer_), sizeof peer_) == sizeof out)
        ++sent_;
}

std::vector<std::pair<std::string, double>> RemoteDevice::ledger() const {
    return {{"received", static_cast<double>(received_)}, {"late", static_cast<double>(late_)},
            {"lost", static_cast<double>(lost_)},         {"foreign", static_cast<double>(foreign_)},
            {"others", static_cast<double>(others_)},     {"sent", static_cast<double>(sent_)},
            {"ticks_before_first", static_cast<double>(waiting_)}};
}

}  // namespace tissue
