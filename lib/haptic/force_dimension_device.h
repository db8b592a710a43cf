#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "haptic/device_kinds.h"
#include "haptic/servo_exchange.h"

namespace tissue {

struct ForceDimensionOptions {
    /// path of libdrd.so; "": the newest of the first of these places that has one: $FDSDK/lib/release/lin-MACHINE-gcc,
    /// ~/.local/lib, /usr/local/lib (as the Python bindings forcedimension_core look for it), else the system's loader
    std::string library;
    int id = 0;            ///< index of the device, in the order of the vendor's library, up to 31
    bool home = false;     ///< the user agrees that start() moves the device by its motors where it is not initialised
    bool realtime = true;  ///< request SCHED_FIFO for the servo thread
};

/// A device of Force Dimension (omega, delta, sigma, lambda) or a Novint Falcon, driven through the vendor's library
/// libdrd.so, version 3.16 or newer, which contains the functions of libdhd.so. The library is loaded when the device
/// is made: building needs no SDK, and this file contains none of the SDK's text. Functions, their types and return
/// values are those of forcedimension_core 1.0, whose documentation is the vendor's. No such device was ever connected,
/// and the vendor's library was never loaded: tests use a stand-in.
///
/// Servo. The library has no servo of its own: a thread here measures the position, sends the force, and exchanges both
/// with the tick (ServoExchange). Its period is that in which the device answers, at least 0.25 ms: 4 kHz is the most
/// that USB carries, by the vendor's documentation. Periods longer than 1 ms count as `slow_periods`. read() adds the
/// mean period to the age of a position, since its force goes out in the period after it.
///
/// Zero force. Where ticks cease, the servo thread sends zero. Where the thread itself stalls or the program is killed,
/// the device's watchdog disables its forces after force_held_s (`watchdog` 1). It is the one thing here that needs the
/// library's expert mode. A device without it (`watchdog` 0) keeps its last force until the library returns. After a
/// stall the thread enables forces again, but only if the watchdog was the cause of their end, not a button or a limit
/// of speed. stop() sends zero, disables forces and puts the brakes on; it waits until the library returns. Zero means
/// no force of this program: gravity compensation stays as the library has it, on by default.
///
/// Initialisation. A device that was not initialised since it was powered on does not know where it is. start() then
/// moves it by its motors, if `home` is set; else the constructor refuses.
///
/// Limit of force. The type that the library reports determines the largest force that goes out; a longer one is
/// shortened. Types without a known limit are refused. kind.impedance is that of the weakest type.
///
/// Errors. A negative return value is an error; DHD_TIMEGUARD (1, the position is that of a recent exchange) and
/// DHD_MOTOR_SATURATED (2, the library has shortened the force) are none, and are counted. A device that has returned
/// nothing but errors for 2 s has finished.
///
/// Grasping: the first button (0), or a gripper that is closed to less than 7 degrees, until it opens beyond 10, as the
/// switch of CHAI3D's grippers. A button or gripper that cannot be read counts as released.
///
/// The axes are the vendor's: x towards the user, y to the right, z up; in metres.
class ForceDimensionDevice final : public Device {
   public:
    static const DeviceKind kind;

    /// Throws DeviceError, which states what is missing or refused, and what to do.
    explicit ForceDimensionDevice(const ForceDimensionOptions& options = {});
    ~ForceDimensionDevice() override;
    ForceDimensionDevice(const ForceDimensionDevice&) = delete;
    ForceDimensionDevice& operator=(const ForceDimensionDevice&) = delete;

    /// With the device's type, as in "force-dimension (omega.3)".
    std::string name() const override;
    double force_max_N() const { return force_max_N_; }  ///< of the device's type
    /// May take seconds, in which the device moves (`home`).
    void start() override;
    DeviceSample read(double time_s) noexcept override;
    void write(const Eigen::Vector3d& force_N) noexcept override;
    bool finished() const noexcept override;
    void stop() noexcept override;
    std::string last_error() const override;
    std::vector<std::pair<std::string, double>> statistics() const override;

   private:
    struct Library;

    void serve() noexcept;
    void servo_period() noexcept;
    void after_stall() noexcept;
    bool grasps() noexcept;

    const ForceDimensionOptions options_;
    std::unique_ptr<Library> library_;
    std::string type_;
    double force_max_N_ = 0;
    bool gripper_ = false;
    bool closed_ = false;                    ///< the gripper; used by the servo thread alone
    long long commanded_ns_ = 0;             ///< time of the last force that was sent; used by the servo thread alone
    bool watchdog_ = false, started_ = false;
    unsigned char watchdog_before_ = 0;      ///< the device's own setting, which stop() restores
    ServoExchange exchange_;
    std::thread servo_;
    std::atomic<bool> ending_{false};
    std::atomic<double> period_s_{0};        ///< mean of the last servo periods
    std::atomic<long> slow_{0}, saturated_{0}, time_guarded_{0}, enabled_again_{0};
    std::atomic<bool> scheduled_{false};
};

}  // namespace tissue
