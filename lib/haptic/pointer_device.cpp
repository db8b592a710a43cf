#include "haptic/pointer_device.h"

#include <algorithm>

#include "error.h"

namespace tissue {
namespace {

constexpr double longest_s = 0.01;   ///< longest step [s]: after a pause the point continues instead of jumping

/// Largest distance to a target; a farther one only gives a direction. The distance times the filter's gain must not
/// overflow.
constexpr double far_m = 1e3;

}  // namespace

PointerDevice::PointerDevice(const Point& start_m, const DeviceMap& map, double safe_speed_m_s,
                             const PointerOptions& options)
    : map_(map), speed_m_s_(std::min(options.speed_m_s, 0.9 * safe_speed_m_s * map.scale)), settle_s_(options.settle_s),
      target_(start_m), point_m_(start_m), velocity_m_s_(Point::Zero(start_m.size())) {
    map_.fit(static_cast<int>(start_m.size()));
    if (!(speed_m_s_ > 0) || !(settle_s_ > 0) || !start_m.allFinite())
        throw MismatchError("a pointer needs a finite start, a positive speed and a positive settling time");
}

void PointerDevice::aim(const Point& target_m) noexcept {
    if (target_m.size() != point_m_.size() || !target_m.allFinite()) {
        refused_.fetch_add(1, std::memory_order_relaxed);
        return;
    }
    target_.back() = target_m;
    target_.publish();
    aimed_.fetch_add(1, std::memory_order_relaxed);
}

DeviceSample PointerDevice::read(double time_s) noexcept {
    target_.fetch();
    const double h = std::clamp(time_s - time_s_, 0.0, longest_s), w = 1 / settle_s_;
    time_s_ = time_s;
    Point way = target_.front() - point_m_;
    const double farthest = way.cwiseAbs().maxCoeff();
    if (farthest > far_m) way *= far_m / farthest;
    // backward Euler of x'' = w^2 (target - x) - 2 w x': stable and without overshoot for any step
    velocity_m_s_ = (velocity_m_s_ + h * w * w * way) / ((1 + h * w) * (1 + h * w));
    const double speed = velocity_m_s_.norm();
    if (speed > speed_m_s_) velocity_m_s_ *= speed_m_s_ / speed;
    point_m_ += h * velocity_m_s_;
    DeviceSample sample;
    sample.position_m = map_.to_device(point_m_);
    sample.grasp = grasps_.load(std::memory_order_relaxed);
    return sample;
}

DeviceSample PointerDevice::skip_tick(double time_s) noexcept {
    time_s_ = time_s;  // so that read() makes a step of length 0
    velocity_m_s_.setZero();
    return read(time_s);
}

std::vector<std::pair<std::string, double>> PointerDevice::statistics() const {
    return {{"targets", static_cast<double>(aimed_.load())}, {"refused_targets", static_cast<double>(refused_.load())}};
}

}  // namespace tissue
