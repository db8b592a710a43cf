#pragma once

#include <atomic>
#include <string>

#include "haptic/device_kinds.h"

namespace tissue {

/// A Touch or PHANTOM by the vendor's OpenHaptics library (libHD.so), which is loaded when the device is made: no SDK is
/// needed to build, and none of its text is in here. The vendor's servo thread calls back about 1000 times a second;
/// the callback swaps position and force with our tick through atomics, waits for nothing, and puts out zero force when
/// the newest one is three quarters of force_held_s old: up to 2.5 ms may go by until it is called again.
/// The force that answers a position goes out in the next callback: positions are as old as that when they are used, and DeviceImpedance::delay_s says so to whoever judges a tissue.
/// The vendor works in millimetres; its x goes right, y up, z to the user.
class OpenHapticsDevice final : public Device {
   public:
    static const DeviceKind kind;

    /// library: "" looks for libHD.so where the system looks. device: the vendor's configured name, "" its default.
    /// Throws DeviceError that says what is missing.
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
    struct Exchange;  ///< one writer, one reader, neither waits

    Library* library_;
    Exchange<3>* position_;
    Exchange<3>* force_;
    std::atomic<unsigned long> servo_ticks_{0};
    std::atomic<long long> written_ns_{0};                      ///< when the newest force came
    std::atomic<int> vendor_error_{0};
    std::atomic<long> cut_off_{0};
    unsigned long seen_by_tick_ = 0;                            ///< tick's own
    double seen_at_s_ = 0;
    bool started_ = false;
};

}  // namespace tissue
