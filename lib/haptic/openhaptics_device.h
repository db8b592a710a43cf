#pragma once

#include <memory>
#include <string>

#include "haptic/device_kinds.h"
#include "haptic/servo_exchange.h"

namespace tissue {

/// A Touch or PHANTOM, driven through the vendor's OpenHaptics library (libHD.so). The library is loaded when the
/// device is made: building needs no SDK, and this file contains none of the SDK's text.
///
/// The vendor's servo thread calls servo() about 1000 times a second. The callback exchanges position and force with
/// the tick (ServoExchange), which also outputs zero force where ticks cease.
///
/// The force for a position goes out in the callback after it. read() adds this delay to the age of a position. The
/// check of a tissue's stiffness gets it as DeviceImpedance::delay_s.
///
/// The vendor's library works in millimetres; its x axis points right, y up, z towards the user.
class OpenHapticsDevice final : public Device {
   public:
    static const DeviceKind kind;

    /// library: path of libHD.so; "": the system's search path. device: name in the vendor's configuration; "": its
    /// default device. Throws DeviceError, which states what is missing.
    explicit OpenHapticsDevice(const std::string& library = "", const std::string& device = "");
    ~OpenHapticsDevice() override;
    OpenHapticsDevice(const OpenHapticsDevice&) = delete;
    OpenHapticsDevice& operator=(const OpenHapticsDevice&) = delete;

    std::string name() const override { return kind.name; }
    void start() override;
    DeviceSample read(double time_s) noexcept override;
    void write(const Eigen::Vector3d& force_N) noexcept override;
    void stop() noexcept override;
    std::string last_error() const override;
    std::vector<std::pair<std::string, double>> statistics() const override { return exchange_.statistics(); }

   private:
    struct Library;
    static unsigned servo(void* self) noexcept;

    std::unique_ptr<Library> library_;
    ServoExchange exchange_;
    bool started_ = false;
};

}  // namespace tissue
