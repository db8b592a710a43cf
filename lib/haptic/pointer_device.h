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
    double speed_m_s = 1;      ///< fastest in the tissue's space; hands at work stay below about 1 m/s
    double settle_s = 0.012;   ///< time constant: smooths the 60 positions a second of a mouse, lags by two of these
};

/// A mouse or a finger on a page: a point without a body. Another thread says where it is wanted, as often
/// as it likes; the device follows smoothly (critically damped) and never faster than its speed, so that positions
/// that come seldom or far apart are no fault.
class PointerDevice final : public Device {
   public:
    /// safe_speed_m_s: SafetyOptions::speed_max_m_s, of which at most nine tenths are used. Throws MismatchError for
    /// limits that are not positive.
    PointerDevice(const Point& start_m, const DeviceMap& map, double safe_speed_m_s,
                  const PointerOptions& options = {});

    std::string name() const override { return "pointer"; }
    DeviceSample read(double time_s) noexcept override;
    DeviceSample stand_still(double time_s) noexcept override;
    void write(const Eigen::Vector3d&) noexcept override {}
    std::vector<std::pair<std::string, double>> statistics() const override;

    /// Where the point shall be, in the tissue's space (D); from one other thread. What is not finite is left out.
    void aim(const Point& target_m) noexcept;

   private:
    DeviceMap map_;
    double speed_m_s_, settle_s_;
    Latest<Point> target_;
    std::atomic<long long> aimed_{0}, refused_{0};
    Point point_m_, velocity_m_s_;
    double time_s_ = 0;
};

}  // namespace tissue
