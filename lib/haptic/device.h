#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace tissue {

/// What a device says in one tick, in its own three axes.
struct DeviceSample {
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    bool valid = true;   ///< false: the device reports an error, or has not spoken yet
    double age_s = 0;    ///< since the device measured it, at the time when the force of this tick begins
    /// What a force sensor in the tool feels of the tissue that it touches in the world [N], as the tool pushes; NaN where there is none.
    Eigen::Vector3d measured_N = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    bool reset = false;  ///< the session that a replay plays was put to rest before this tick
};

/// The longest that a force stays on the hand without a new write(). A device with motors makes them zero by itself,
/// not before half of this is over and before all of it is: a program that hangs or dies lets go.
constexpr double force_held_s = 0.010;

/// A haptic device of the impedance kind: position in, force out. One file a kind. Set-up may throw, allocate and
/// print; read() and write() are part of the 1 kHz tick: they do none of that and do not wait. Whoever starts one does
/// so through RunningDevice.
class Device {
   public:
    virtual ~Device() = default;
    virtual std::string name() const = 0;

    /// Before the first tick. Throws DeviceError; what it had begun by then is stop()'s to end.
    virtual void start() {}

    /// Position at `time_s`, the tick's place on the schedule, 0 at the first.
    virtual DeviceSample read(double time_s) noexcept = 0;

    /// In place of read(), where the tick is left out. By default the device goes on; a pointer stays where it is.
    virtual DeviceSample stand_still(double time_s) noexcept { return read(time_s); }

    /// The force to put on the hand [N] until the next write, or for force_held_s. Before start() and after stop()
    /// there is none, whatever is written.
    virtual void write(const Eigen::Vector3d& force_N) noexcept = 0;

    /// True when the device has no more to say (a recording's end).
    virtual bool finished() const noexcept { return false; }

    /// After the last tick, when the force has been set to zero; also after a start() that threw. Any number of times.
    virtual void stop() noexcept {}

    /// Counts and figures of its own, for session statistics.
    virtual std::vector<std::pair<std::string, double>> statistics() const { return {}; }
};

}  // namespace tissue
