#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>

#include "haptic/device_kinds.h"

namespace tissue {

/// A device in another process on this machine, over UDP on the loopback address alone. All little-endian:
///   in,  48 bytes: char magic[4] "TSP1", uint32 sequence, float64 time_s, float64 position_m[3], float64 reserved
///   or   72 bytes: "TSP2", the same, and float64 measured_N[3] of a force sensor in the tool
///   out, 48 bytes: char magic[4] "TSF1", uint32 sequence of the newest position used, float64 age_s of it,
///                  float64 force_N[3], float64 tick
/// sequence ascends by one from any start. time_s is the client's own monotonic clock at the measurement, in seconds from any start: a clock, and no count
/// of datagrams. A time that is always the same never leads. One that runs slower than ours by more than a thousandth, as sequence / 1000 does when the
/// client sends less than 1000 a second, makes its positions older and older: beyond SafetyOptions::stale_s they count as `stale`, and there is no force.
///
/// Who leads. Two datagrams of one sender, the second of which follows the first and has a later time, make it the peer; the socket is then connected to
/// it, and the system refuses what others send. A datagram follows when its sequence is ahead by 1000 at most, and by 10,000 more for each second of its time; when its time
/// does not go back; and when its time is not more than half a second ahead of our clock. So a client of another byte order never leads, and one that
/// counts milliseconds is not used. A peer from which nothing that follows has come for half a second has lost the lead: it, or another one, begins anew.
///
/// What is used. Each read takes all that has come and uses the newest. Counted: `received`, all that followed; `skipped`, those of them for which a newer one
/// stood in for; `late`, not ahead of the newest; `lost`, gaps; `leaps`, what does not follow; `others`, of another sender; `foreign`, no such datagram.
/// The age of a position is that of the time in its datagram, by the difference of the two clocks: the least that has been seen, which may grow by a
/// thousandth of the time that passes. A position that waited in the socket while the program stood still is as old as it is.
///
/// A force goes to the peer in every tick between start() and stop(). One position is wanted for every tick; where they come less often, a hand's speed is judged by the time
/// between two measurements, by time_s. How old a position is when it comes is known but for the least age seen, which counts as 0: a way that takes a millisecond or more each time makes a hand
/// swing on tissue that would let it rest. The motors are
/// the client's: it takes forces of this socket alone, limits them, and lets go of one when no other has come for three quarters of force_held_s, as
/// scripts/remote_device.py does.
struct PositionDatagram {
    char magic[4];
    std::uint32_t sequence;
    double time_s, position_m[3], reserved;
};
struct SensorDatagram {
    PositionDatagram position;
    double measured_N[3];
};
struct ForceDatagram {
    char magic[4];
    std::uint32_t sequence;
    double age_s, force_N[3], tick;
};
static_assert(sizeof(PositionDatagram) == 48 && sizeof(SensorDatagram) == 72 && sizeof(ForceDatagram) == 48, "datagrams have no padding");

class RemoteDevice final : public Device {
   public:
    static const DeviceKind kind;

    /// port 0: any that is free; port() returns it. Throws DeviceError.
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
    std::uint32_t sequence_ = 0;   ///< of the peer's newest
    double client_s_ = 0;          ///< its time, by the peer's clock
    double offset_s_ = 0;          ///< of the schedule against the peer's clock
    double heard_s_ = 0;           ///< schedule time at which it was read
    double measured_s_ = 0;        ///< schedule time at which it was measured
    double time_s_ = 0;            ///< now
    bool fresh_ = false;           ///< a position has come in this read
    Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero(), measured_N_ = DeviceSample().measured_N;
    long long received_ = 0, skipped_ = 0, late_ = 0, lost_ = 0, leaps_ = 0, foreign_ = 0, others_ = 0, sent_ = 0, waiting_ = 0;
};

}  // namespace tissue
