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
/// A force goes back in every tick to whoever leads: the first to send, until silent for half a second, when with the default SafetyOptions::stale_s
/// its force has long been zero; what others send meanwhile is counted as `others` and not used. Sequence numbers ascend by one from any start, and
/// may start anew after such a silence; older ones are `late` and not used, gaps are `lost`, anything else is `foreign`. One is wanted for every tick: what a hand has come
/// since the last is taken for its way in one tick, and more of it than SafetyOptions::speed_max_m_s is a jump - at 100 a second, from a tenth of that speed on. Its motors are the client's: it lets go of a
/// force when none has come for three quarters of force_held_s, as scripts/remote_device.py does.
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

    /// port 0: any that is free; port() says which. Throws DeviceError.
    explicit RemoteDevice(int port);
    ~RemoteDevice() override;
    RemoteDevice(const RemoteDevice&) = delete;
    RemoteDevice& operator=(const RemoteDevice&) = delete;

    std::string name() const override { return kind.name; }
    DeviceSample read(double time_s) noexcept override;
    void write(const Eigen::Vector3d& force_N) noexcept override;
    std::vector<std::pair<std::string, double>> ledger() const override;

    int port() const { return port_; }

   private:
    int socket_ = -1, port_ = 0;
    sockaddr_in peer_{};
    bool has_peer_ = false;  ///< someone has sent
    std::uint32_t sequence_ = 0;
    double received_s_ = 0, time_s_ = 0;   ///< schedule time of the newest position, and now
    Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero(), measured_N_ = DeviceSample().measured_N;
    long long received_ = 0, late_ = 0, lost_ = 0, foreign_ = 0, others_ = 0, sent_ = 0, waiting_ = 0;
};

}  // namespace tissue
