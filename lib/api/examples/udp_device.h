/* UdpDevice: the client's end of `tissue-haptic MODEL --device remote`, for an engine in C++ such as Unreal.
 *
 * It needs the sockets of POSIX alone, and links nothing of tissuectl: an engine under any licence talks to the
 * program as a process of its own. cli/view/PROTOCOL.md has the datagrams. SI units, axes of the tissue.
 *
 * One thread owns a device. Either it sends and receives once every millisecond (a device with motors), or once in
 * every frame (a tracked controller, a mouse). Send a position when it has been measured, not again: the program takes
 * the hand's speed from the time between two measurements. Positions at 25 Hz or fewer are too old (option stale). */
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "datagrams are little-endian, and are copied as they are in memory");

class UdpDevice {
   public:
    using Vector = std::array<double, 3>;

    /// port: of tissue-haptic on this machine. force_max_N: longest force that force_N() returns; 3.3 N is a Touch's.
    /// held_s: how long a force is valid; 0.0075 s is three quarters of the 0.01 s after which the energy log of
    /// tissue-haptic assumes that the device has released it. Throws std::runtime_error where there is no socket.
    explicit UdpDevice(int port, double force_max_N = 3.3, double held_s = 0.0075)
        : force_max_N_(force_max_N), held_s_(held_s), socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
        sockaddr_in program{};
        program.sin_family = AF_INET;
        program.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        program.sin_port = htons(static_cast<std::uint16_t>(port));
        // a connected socket receives nothing from other programs
        if (socket_ >= 0 && ::fcntl(socket_, F_SETFL, O_NONBLOCK) == 0 && ::connect(socket_, reinterpret_cast<sockaddr*>(&program), sizeof program) == 0) return;
        const std::string why = std::strerror(errno);
        if (socket_ >= 0) ::close(socket_);
        throw std::runtime_error("UDP port " + std::to_string(port) + " of this machine: " + why);
    }
    ~UdpDevice() { ::close(socket_); }
    UdpDevice(const UdpDevice&) = delete;
    UdpDevice& operator=(const UdpDevice&) = delete;

    /// A position that has just been measured [m]. grasp: whether the tool grasps the tissue that it touches.
    void send(const Vector& position_m, bool grasp = false) {
        PositionDatagram out{{'T', 'S', 'P', '1'}, ++sequence_, now_s(), {position_m[0], position_m[1], position_m[2]}, grasp ? 1.0 : 0.0};
        sent_s_[sequence_ % remembered] = out.time_s;
        // fails while the program does not listen yet, or follows another client: the next position comes soon
        (void)!::send(socket_, &out, sizeof out, 0);
    }

    /// Takes the forces that have arrived, and returns the force on the hand [N]. Zero without a force of the last
    /// held_s: a device with motors must call this at least that often, and release its force when it stops.
    Vector force_N() {
        for (int k = 0; k < 512; ++k) {  // more than the system keeps: a flood ends
            char bytes[sizeof(ForceDatagram) + 1];
            const ssize_t size = ::recv(socket_, bytes, sizeof bytes, 0);
            if (size >= 0)
                take(bytes, static_cast<std::size_t>(size));
            else if (errno != ECONNREFUSED && errno != EINTR)
                break;
        }
        return now_s() - computed_s_ <= held_s_ ? newest_N_ : Vector{};
    }

    /// Numbers of positions sent, forces used, and datagrams refused.
    long sent() const { return static_cast<long>(sequence_); }
    long answers() const { return answers_; }
    long refused() const { return refused_; }

    /// Monotonic time since the start [s].
    double now_s() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

   private:
    struct PositionDatagram {
        char magic[4];
        std::uint32_t sequence;
        double time_s, position_m[3], grasp;
    };
    struct ForceDatagram {
        char magic[4];
        std::uint32_t sequence;
        double age_s, force_N[3], tick;
    };
    static_assert(sizeof(PositionDatagram) == 48 && sizeof(ForceDatagram) == 48, "datagrams have no padding");
    static constexpr std::uint32_t remembered = 1024;  // positions whose time is kept

    void take(const char* bytes, std::size_t size) {
        ForceDatagram in;
        if (size != sizeof in || std::memcmp(bytes, "TSF1", 4) != 0) {
            ++refused_;
            return;
        }
        std::memcpy(&in, bytes, sizeof in);
        // not std::hypot of three, which libstdc++ computes as 0 where one of them is not a number
        const double length = std::sqrt(in.force_N[0] * in.force_N[0] + in.force_N[1] * in.force_N[1] + in.force_N[2] * in.force_N[2]);
        // it must answer one of the last positions; the first has sequence 1
        const std::uint32_t before = sequence_ - in.sequence;
        if (before >= std::min(sequence_, remembered) || !std::isfinite(length) || !std::isfinite(in.age_s)) {
            ++refused_;
            return;
        }
        const double share = length > force_max_N_ ? force_max_N_ / length : 1;
        for (int k = 0; k < 3; ++k) newest_N_[k] = share * in.force_N[k];
        // by the position's time: a force that has waited in the socket while this program stalled is old
        computed_s_ = std::min(sent_s_[in.sequence % remembered] + in.age_s, now_s());
        ++answers_;
    }

    const double force_max_N_, held_s_;
    const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    int socket_;
    std::uint32_t sequence_ = 0;
    std::array<double, remembered> sent_s_{};
    Vector newest_N_{};
    double computed_s_ = -1e9;  ///< when the program computed newest_N_, by the clock of this client
    long answers_ = 0, refused_ = 0;
};
