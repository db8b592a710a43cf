#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>

#include "haptic/device_kinds.h"

namespace tissue {

/// Position of the device, from the client; 48 bytes, magic "TSP1". See RemoteDevice.
struct PositionDatagram {
    char magic[4];
    std::uint32_t sequence;
    double time_s, position_m[3], grasp;  ///< grasp: 1 while the tool grasps, else 0
};
/// The same with the force of a sensor in the tool; 72 bytes, magic "TSP2".
struct SensorDatagram {
    PositionDatagram position;
    double measured_N[3];
};
/// Force to the client; 48 bytes, magic "TSF1".
struct ForceDatagram {
    char magic[4];
    std::uint32_t sequence;
    double age_s, force_N[3], tick;
};
static_assert(sizeof(PositionDatagram) == 48 && sizeof(SensorDatagram) == 72 && sizeof(ForceDatagram) == 48, "datagrams have no padding");

/// A device in another process on this machine, over UDP on the loopback address only. All values are little-endian:
///   in,  48 bytes: char magic[4] "TSP1", uint32 sequence, float64 time_s, float64 position_m[3],
///                  float64 grasp: 1 while the tool grasps (Simulation::grasp), else 0
///   or   72 bytes: "TSP2", the same, and float64 measured_N[3] of a force sensor in the tool
///   out, 48 bytes: char magic[4] "TSF1", uint32 sequence of the newest position used, float64 age_s of it,
///                  float64 force_N[3], float64 tick
/// sequence increases by one per datagram, from any start. time_s is the client's monotonic clock at the measurement,
/// in seconds from any start. It must be a clock, not a count of datagrams. A client whose time never changes never
/// becomes the peer. Where its time runs slower than the program's clock by more than a thousandth, the computed age of
/// its positions grows and grows. An example is sequence / 1000 where the client sends less than 1000 datagrams a
/// second. Positions older than SafetyOptions::stale_s count as `stale`, and there is no force.
///
/// Choice of the peer. Two datagrams of one sender make it the peer, if the second follows the first and has a later
/// time. The socket is then connected to the peer, and the system drops datagrams of others. A datagram follows if
///   - its sequence is ahead by 1000 at most, plus 10,000 for each second of its time;
///   - its time does not go back;
///   - its time is at most half a second ahead of the program's clock.
/// So a client of another byte order never becomes the peer, and one that counts milliseconds is not used. A peer
/// without a datagram that follows for half a second loses its role. Then it, or another sender, starts anew.
///
/// Use of datagrams. Each read() takes all datagrams that have arrived and uses the newest. It counts
///   `received`: all that followed;             `skipped`: those of them that a newer one replaced;
///   `late`: sequence not ahead of the newest;  `lost`: gaps in the sequence;
///   `leaps`: datagrams that do not follow;     `others`: datagrams of another sender;
///   `foreign`: datagrams of another format.
/// The age of a position is computed from the time in its datagram and the difference of the two clocks. That
/// difference is the smallest one observed; it may grow by a thousandth of the time that passes. So a position that
/// waited in the socket while the program stalled has its true age.
///
/// Forces. A force goes to the peer in every tick between start() and stop(). The client should send one position per
/// tick. If it sends fewer, the hand's speed is computed from the time between two measurements, by time_s. The
/// smallest age observed counts as 0, so that a constant delay of the transport is not visible. A delay of a
/// millisecond or more makes a hand oscillate on tissue on which it would otherwise come to rest. The client controls
/// the motors. It must accept forces from this socket only, limit them, and release a force when no other has come for
/// three quarters of force_held_s, as scripts/remote_device.py does.
class RemoteDevice final : public Device {
   public:
    static const DeviceKind kind;

    /// port: UDP port; 0: any free one, which port() returns. Throws DeviceError where no port can be bound.
    explicit RemoteDevice(int port);
    ~RemoteDevice() override;
    RemoteDevice(const RemoteDevice&) = delete;
    RemoteDevice& operator=(const RemoteDevice&) = delete;

    std::string name() const override { return kind.name; }
    void start() override;
    DeviceSample read(double time_s) noexcept override;
    void write(const Eigen::Vector3d& force_N) noexcept override;
    void stop() noexcept override;
    std::vector<std::pair<std::string, double>> statistics() const override;

    int port() const { return port_; }

   private:
    enum class Peer { none, candidate, leads };

    void take(const SensorDatagram& datagram, ssize_t size, const sockaddr_in& from) noexcept;
    bool follows(const PositionDatagram& in) const noexcept;
    void remember(const PositionDatagram& in) noexcept;
    void release() noexcept;

    int socket_ = -1, port_ = 0;
    bool running_ = false, has_position_ = false;
    Peer state_ = Peer::none;
    sockaddr_in peer_{};
    std::uint32_t sequence_ = 0;   ///< of the peer's newest datagram
    double client_s_ = 0;          ///< time of that datagram, by the peer's clock
    double offset_s_ = 0;          ///< schedule time minus the peer's clock
    double heard_s_ = 0;           ///< schedule time at which that datagram was read
    double measured_s_ = 0;        ///< schedule time at which position_m_ was measured
    double time_s_ = 0;            ///< schedule time of the last read()
    bool grasps_ = false;          ///< as the newest position says
    bool fresh_ = false;           ///< a position has come in this read()
    Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero(), measured_N_ = DeviceSample().measured_N;
    long long received_ = 0, skipped_ = 0, late_ = 0, lost_ = 0, leaps_ = 0, foreign_ = 0, others_ = 0, sent_ = 0, waiting_ = 0;
};

}  // namespace tissue
