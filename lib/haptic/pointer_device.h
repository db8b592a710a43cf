#pragma once

#include <atomic>
#include <string>
#include <utility>
#include <vector>

#include "haptic/device.h"
#include "haptic/device_map.h"
#include "haptic/latest.h"

namespace tissue {

struct PointerOptions {
    double speed_m_s = 1;      ///< largest speed in the tissue's space; hands at work stay below about 1 m/s
    double settle_s = 0.012;   ///< time constant: smooths the 60 positions a second of a mouse; the lag is twice this
};

/// A mouse, or a touch on a page: a point without mass. Another thread sets its target, at any rate. The point follows
/// smoothly (critically damped) and never faster than its largest speed, so that rare or distant targets are no fault.
class PointerDevice final : public Device {
   public:
    /// start_m: where the point starts, in the tissue's space (D). map: the session's. safe_speed_m_s: the session's
    /// SafetyOptions::speed_max_m_s, of which at most nine tenths are used. Throws MismatchError for a start that is
    /// not finite, for a speed or settling time that is not positive, and as DeviceMap::fit.
    PointerDevice(const Point& start_m, const DeviceMap& map, double safe_speed_m_s,
                  const PointerOptions& options = {});

    std::string name() const override { return "pointer"; }
    DeviceSample read(double time_s) noexcept override;
    DeviceSample skip_tick(double time_s) noexcept override;
    void write(const Eigen::Vector3d&) noexcept override {}
    std::vector<std::pair<std::string, double>> statistics() const override;

    /// Sets the target, in the tissue's space [m] (D); called by one other thread. A target that is not finite, or not
    /// of D numbers, is ignored and counted.
    void aim(const Point& target_m) noexcept;
    /// Whether the tool grasps from now on (Simulation::grasp); from one other thread.
    void grasp(bool on) noexcept { grasps_.store(on, std::memory_order_relaxed); }

   private:
    DeviceMap map_;
    double speed_m_s_, settle_s_;
    Latest<Point> target_;
    std::atomic<long long> aimed_{0}, refused_{0};
    std::atomic<bool> grasps_{false};
    Point point_m_, velocity_m_s_;
    double time_s_ = 0;
};

}  // namespace tissue
