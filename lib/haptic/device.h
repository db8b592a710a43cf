#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace tissue {

/// Input from a device in one tick, in the device's own three axes.
struct DeviceSample {
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    bool valid = true;   ///< false: the device reports an error, or has not sent a position yet
    double age_s = 0;    ///< age of the position at the time when the force of this tick begins
    /// Force of the tool on a real tissue that it touches [N], by a force sensor in the tool. NaN without a sensor.
    Eigen::Vector3d measured_N = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    bool grasp = false;  ///< the tool grasps the tissue that it touches (Simulation::grasp)
    bool reset = false;  ///< replay: in the recorded session all meshes were put to rest before this tick
};

/// Longest time that a device keeps a force without a new write() [s]. A device with motors sets the force to zero by
/// itself after at least half of this time and at most all of it. So the force ends when a program hangs or dies.
constexpr double force_held_s = 0.010;

/// A haptic device of the impedance kind: it gives positions and takes forces. Each kind has its own file. Set-up may
/// throw, allocate and print. read() and write() are part of the 1 kHz tick: they do none of that and do not wait.
/// Devices are started through RunningDevice only.
class Device {
   public:
    virtual ~Device() = default;
    virtual std::string name() const = 0;

    /// Called before the first tick. Throws DeviceError; stop() then ends what was begun.
    virtual void start() {}

    /// Position at time_s, the scheduled time of the tick [s], 0 at the first.
    virtual DeviceSample read(double time_s) noexcept = 0;

    /// Called in place of read() where the tick is left out. By default the device moves on; a pointer stays in place.
    virtual DeviceSample skip_tick(double time_s) noexcept { return read(time_s); }

    /// Sets the force on the hand [N] until the next write(), or for force_held_s. Before start() and after stop() the
    /// force is zero, whatever is written.
    virtual void write(const Eigen::Vector3d& force_N) noexcept = 0;

    /// True when no more positions will come, as at the end of a recording.
    virtual bool finished() const noexcept { return false; }

    /// Called after the last tick, when the force has been set to zero, and after a start() that threw. May be called
    /// any number of times.
    virtual void stop() noexcept {}

    /// Why no more positions come although a session was to go on, in one line; "" where nothing has failed. May be
    /// called while finished() is true, and after stop().
    virtual std::string failure() const { return ""; }

    /// The last error since start() that the device or its vendor's library reported, as text; "": none.
    virtual std::string last_error() const { return ""; }

    /// The device's own counts and figures, for session statistics: name and value.
    virtual std::vector<std::pair<std::string, double>> statistics() const { return {}; }
};

}  // namespace tissue
