#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "haptic/device_kinds.h"
#include "haptic/latest.h"

namespace tissue {

/// A Haply Inverse3, Inverse3x or Minverse, through the vendor's program on this machine, the Haply Inverse Service
/// 3.5 or later. No device and no service was ever available; tests use a stand-in that speaks the documented protocol
/// (docs.haply.co, inverseSDK 3.5: "WebSocket Protocol", "Simulation Channel", "Control Commands", "Filters", "Events &
/// Monitoring", "HTTP"; wire types of Haply's Rust client `haply` 1.3.1).
///
/// Exchange. The service answers each message with one state of all devices. A thread of this object sends a force
/// (inverse3[i].commands.set_cursor_force.vector, in N), waits for the answer, takes the position from it
/// (inverse3[i].state.cursor_position, in m) and sends the next force: the rate is that of the service. Position and
/// force pass between this thread and the tick without a lock. A component that an answer leaves out is 0, as all
/// values at their defaults are. Before 3.5 the force had another name, so an older service is refused.
///
/// Force. The thread sends zero in place of a force that is older than three quarters of force_held_s, and at the end,
/// before it closes. The service applies a force once and then returns the device to idle; after how long is not
/// documented. So where the service itself stalls, the end of a force is up to the service.
///
/// Age. A position was measured between the sending of a message and its answer, and the force that is computed from it
/// goes out within the exchange that follows. The age is counted from the sending: the middle of what is possible.
///
/// Filters. The service changes forces before the device gets them: its force gate reduces them where it finds an
/// oscillation, its damping and its force scale act always. Gain of the gate and damping are read when a session
/// starts, and stand in its statistics as `force_gate_gain` and `service_damping`; NaN: the service did not say.
///
/// End. Whatever the service does wrong ends the exchange: positions are no longer valid, finished() is true, and
/// failure() has the reason. That is: no answer for half a second, JSON that is malformed or has a number that is none,
/// a frame beyond 256 KiB, a frame without our device, a closed connection, an event that says that the device was
/// disconnected.
///
/// Only the loopback address is accepted. Whoever is on the way to another machine could move the hand, as neither end
/// proves who it is and nothing is encrypted; and the delay of a network makes a contact unstable.
class HaplyDevice final : public Device {
   public:
    static const DeviceKind kind;

    struct Options {
        std::string url = "ws://localhost:10001";  ///< ws://HOST[:PORT], HOST: localhost, 127.0.0.1 or [::1]
        int events_port = 10020;                   ///< of the service's events, on the same host; 0: without events
        std::string device_id;                     ///< as the service names it; "": the only one
        std::string grip_id;                       ///< the VerseGrip whose button grasps; "": any
    };

    /// Throws MismatchError for options that are out of range.
    explicit HaplyDevice(Options options);
    ~HaplyDevice() override;
    HaplyDevice(const HaplyDevice&) = delete;
    HaplyDevice& operator=(const HaplyDevice&) = delete;

    std::string name() const override { return kind.name; }
    /// Connects, checks the service's version and the device, and begins the exchange with zero force. Throws
    /// DeviceError after at most 5 s a step.
    void start() override;
    /// grasp: the button of a VerseGrip is down, or button a of a wireless or custom one.
    DeviceSample read(double time_s) noexcept override;
    void write(const Eigen::Vector3d& force_N) noexcept override;
    bool finished() const noexcept override { return started_ && !alive_.load(std::memory_order_acquire); }
    /// Waits until the service has answered a zero force and the connection is closed; half a second if it does not answer.
    void stop() noexcept override;
    std::string failure() const override;
    std::vector<std::pair<std::string, double>> statistics() const override;

   private:
    class Link;  ///< the connections; Boost stays in haply_device.cpp

    struct Measured {
        Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
        long long asked_ns = 0;             ///< when the message was sent that this answers
        bool ready = false, grasp = false;  ///< ready: the device does not say that it is not calibrated or not ready
    };
    struct Written {
        Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
        long long at_ns = 0;
    };
    struct Counts {
        std::atomic<long long> exchanges{0}, exchanges_ns{0}, longest_ns{0};
        std::atomic<long long> late{0};     ///< exchanges longer than haply_impedance.delay_s
        std::atomic<long long> cut_off{0};  ///< zero forces in place of one that was too old
        std::atomic<long long> not_ready{0};
        std::atomic<long long> events{0}, safety{0}, errors{0}, disconnected{0}, foreign{0};
        std::atomic<bool> events_heard{false};
        std::atomic<double> gate{0}, damping{0};
    };

    const Options options_;
    Latest<Measured> measured_;  ///< from the link to the tick
    Latest<Written> force_;      ///< from the tick to the link
    Counts counts_;
    std::unique_ptr<Link> link_;
    std::thread thread_;
    bool started_ = false;
    std::atomic<bool> alive_{false};     ///< the exchange goes on
    std::atomic<bool> stopping_{false};
    std::string failure_;                ///< written before alive_ becomes false
};

}  // namespace tissue
