#pragma once

#include <atomic>
#include <string>

#include "haptic/device_kinds.h"

namespace tissue {

/// A Touch or PHANTOM, driven through the vendor's OpenHaptics library (libHD.so). The library is loaded when the
/// device is made: building needs no SDK, and this file contains none of the SDK's text.
///
/// The vendor's servo thread calls servo() about 1000 times a second. The callback exchanges position and force with
/// the tick through atomics and never waits. It outputs zero force when the newest force is older than three quarters
/// of force_held_s, since up to 2.5 ms may pass until the next call.
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
    std::vector<std::pair<std::string, double>> statistics() const override;

   private:
    struct Library;
    static unsigned servo(void* self) noexcept;

    template <int Size>
    struct Exchange;  ///< for one writer and one reader, of which neither waits

    Library* library_;
    Exchange<4>* position_;  ///< three axes [m], and 1 while the first button is down
    Exchange<3>* force_;
    std::atomic<unsigned long> servo_ticks_{0};
    std::atomic<long long> written_ns_{0};                      ///< time of the newest force; 0: none since start()
    std::atomic<int> vendor_error_{0};
    std::atomic<long> cut_off_{0};                              ///< callbacks that found the newest force too old
    /// servo_ticks_ at the newest position that read() found
    unsigned long seen_by_tick_ = 0;
    double seen_at_s_ = 0;                                      ///< schedule time of that read()
    bool started_ = false;
};

}  // namespace tissue
