#include "haptic/remote_device.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "haptic/device_error.h"

namespace tissue {

const DeviceKind RemoteDevice::kind = {
    "remote",
    {{"port", "number", "47474", "for remote: UDP port, on this machine only", false,
      [](const std::string& text) -> std::string {
          char* end = nullptr;
          const long port = std::strtol(text.c_str(), &end, 10);
          return !text.empty() && *end == '\0' && port >= 0 && port <= 65535 ? "" : "must be a number from 0 to 65535, not " + text;
      }}},
    [](const DeviceValues& v, const DeviceContext&) -> std::unique_ptr<Device> {
        return std::make_unique<RemoteDevice>(std::stoi(v.at("port")));
    }};

namespace {

// more datagrams than the system keeps per socket: a flood must not delay the tick
constexpr int most_a_read = 512;
constexpr double leads_s = 0.5;        // a peer keeps its role for this time without a datagram that follows
constexpr double leap = 1000, rate_max_hz = 10000;  // largest step of the sequence, and its growth per second
// the first datagram may have waited this long in the socket, the next not at all
constexpr double early_s = 0.5;
constexpr double drift = 1e-3;         // between two clocks: ten times that of a quartz

bool same(const sockaddr_in& a, const sockaddr_in& b) noexcept {
    return a.sin_port == b.sin_port && a.sin_addr.s_addr == b.sin_addr.s_addr;
}

/// A socket on the loopback address and this port; 0: any port. Returns -1 and sets errno where there is none.
int bound_socket(int port) noexcept {
    const int made = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    if (made < 0 || ::bind(made, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return made;
    const int why = errno;
    ::close(made);
    errno = why;
    return -1;
}

int port_of(int socket) noexcept {
    sockaddr_in address{};
    socklen_t length = sizeof address;
    return ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length) == 0 ? ntohs(address.sin_port) : 0;
}

}  // namespace

RemoteDevice::RemoteDevice(int port) : socket_(bound_socket(port)), port_(port) {
    // a socket loses a port that the system chose when the socket is disconnected: bind that port by its number
    for (int tries = 0; port == 0 && socket_ >= 0 && tries < 10; ++tries) {
        port_ = port_of(socket_);
        ::close(socket_);
        socket_ = bound_socket(port_);
        if (socket_ >= 0) break;
        socket_ = bound_socket(0);  // another program has taken the port in between
        port_ = 0;
    }
    if (socket_ >= 0 && port_ > 0) return;
    const std::string why = socket_ < 0 ? std::strerror(errno) : "no port is free";
    if (socket_ >= 0) ::close(socket_);
    throw DeviceError(fmt::format("remote device: cannot listen on UDP port {} of this machine: {}", port, why));
}

RemoteDevice::~RemoteDevice() {
    ::close(socket_);
}

/// Discards datagrams that arrived before: they belong to another session.
void RemoteDevice::start() {
    release();
    char old[sizeof(SensorDatagram)];
    for (int k = 0; k < most_a_read && ::recv(socket_, old, sizeof old, 0) >= 0; ++k) {}
    has_position_ = false;
    running_ = true;
}

void RemoteDevice::stop() noexcept {
    running_ = false;
    release();
}

DeviceSample RemoteDevice::read(double time_s) noexcept {
    time_s_ = time_s;
    fresh_ = false;
    SensorDatagram datagram;
    sockaddr_in from{};
    for (int k = 0; k < most_a_read; ++k) {
        socklen_t length = sizeof from;
        const ssize_t size = ::recvfrom(socket_, &datagram, sizeof datagram, MSG_TRUNC, reinterpret_cast<sockaddr*>(&from), &length);
        if (size >= 0)
            take(datagram, size, from);
        // refused: the peer has closed its port; other datagrams may wait
        else if (errno != ECONNREFUSED && errno != EINTR)
            break;
    }
    // after reading all datagrams, so that a stall of this program does not count as silence of the peer
    if (state_ != Peer::none && time_s - heard_s_ >= leads_s) release();
    if (!has_position_) ++waiting_;
    DeviceSample sample;
    sample.position_m = position_m_;
    sample.measured_N = measured_N_;
    sample.grasp = grasps_;
    sample.valid = has_position_;
    sample.age_s = std::max(0.0, time_s - measured_s_);
    return sample;
}

void RemoteDevice::take(const SensorDatagram& datagram, ssize_t size, const sockaddr_in& from) noexcept {
    const PositionDatagram& in = datagram.position;
    const bool sensor = size == sizeof datagram && std::memcmp(in.magic, "TSP2", 4) == 0;
    if (!sensor && (size != sizeof in || std::memcmp(in.magic, "TSP1", 4) != 0)) {
        ++foreign_;
        return;
    }
    if (state_ == Peer::none) {
        if (!std::isfinite(in.time_s)) {
            ++leaps_;
            return;
        }
        state_ = Peer::candidate;
        peer_ = from;
        offset_s_ = time_s_ - in.time_s;
        heard_s_ = time_s_;  // an old value may be of an earlier session, whose schedule had another origin
        remember(in);
        return;
    }
    if (!same(from, peer_)) {
        ++others_;
        return;
    }
    const auto ahead = static_cast<std::int32_t>(in.sequence - sequence_);
    if (ahead <= 0) {
        ++late_;
        return;
    }
    if (!follows(in)) {
        leaps_ += state_ == Peer::candidate ? 2 : 1;  // a candidate's first datagram is counted with its second
        if (state_ == Peer::candidate) state_ = Peer::none;
        return;
    }
    if (state_ == Peer::candidate) {
        // same time: a coarse clock, one that stands still, or another unit; a later datagram decides
        if (!(in.time_s > client_s_)) {
            ++leaps_;
            sequence_ = in.sequence;
            return;
        }
        state_ = Peer::leads;
        // datagrams of others that have arrived already are recognised by their address
        ::connect(socket_, reinterpret_cast<const sockaddr*>(&peer_), sizeof peer_);
        ++received_;
        ++skipped_;
    }
    ++received_;
    if (fresh_) ++skipped_;
    fresh_ = has_position_ = true;
    lost_ += ahead - 1;
    remember(in);
    position_m_ = Eigen::Vector3d(in.position_m[0], in.position_m[1], in.position_m[2]);
    measured_N_ = sensor ? Eigen::Vector3d(datagram.measured_N[0], datagram.measured_N[1], datagram.measured_N[2]) : DeviceSample().measured_N;
    measured_s_ = client_s_ + offset_s_;
    grasps_ = in.grasp == 1;
}

bool RemoteDevice::follows(const PositionDatagram& in) const noexcept {
    const double later = in.time_s - client_s_;
    return later >= 0 && in.time_s <= time_s_ - offset_s_ + early_s && static_cast<std::int32_t>(in.sequence - sequence_) <= leap + rate_max_hz * later;
}

void RemoteDevice::remember(const PositionDatagram& in) noexcept {
    sequence_ = in.sequence;
    client_s_ = in.time_s;
    offset_s_ = std::min(offset_s_ + drift * (time_s_ - heard_s_), time_s_ - in.time_s);
    heard_s_ = time_s_;
}

void RemoteDevice::release() noexcept {
    if (state_ == Peer::leads) {
        sockaddr nobody{};
        nobody.sa_family = AF_UNSPEC;
        ::connect(socket_, &nobody, sizeof nobody);
    }
    state_ = Peer::none;
}

void RemoteDevice::write(const Eigen::Vector3d& force_N) noexcept {
    if (!running_ || state_ != Peer::leads) return;
    const ForceDatagram out{{'T', 'S', 'F', '1'}, sequence_, std::max(0.0, time_s_ - measured_s_),
                            {force_N.x(), force_N.y(), force_N.z()}, static_cast<double>(sent_)};
    if (::sendto(socket_, &out, sizeof out, 0, reinterpret_cast<const sockaddr*>(&peer_), sizeof peer_) == sizeof out)
        ++sent_;
}

std::vector<std::pair<std::string, double>> RemoteDevice::statistics() const {
    return {{"received", static_cast<double>(received_)}, {"skipped", static_cast<double>(skipped_)}, {"late", static_cast<double>(late_)},
            {"lost", static_cast<double>(lost_)},         {"leaps", static_cast<double>(leaps_)},     {"foreign", static_cast<double>(foreign_)},
            {"others", static_cast<double>(others_)},     {"sent", static_cast<double>(sent_)},       {"ticks_before_first", static_cast<double>(waiting_)}};
}

}  // namespace tissue
