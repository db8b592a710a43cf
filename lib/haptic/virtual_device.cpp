#include "haptic/virtual_device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <random>

#include "error.h"

namespace tissue {
namespace {

constexpr double clearance_m = 0.005;    ///< how far outside the surface a motion starts
constexpr double ring_m = 0.015;         ///< how far outside it goes round the tissue
constexpr double travel_m_s = 0.2;

/// Uniform in [0, 1), the same on every machine (std::uniform_real_distribution is not).
double uniform(std::mt19937_64& random) {
    return static_cast<double>(random() >> 11) * 0x1.0p-53;
}

/// Counter-clockwise round a box, from its low corner: the point at `along`, and the inward normal there.
struct Ring {
    Eigen::Vector2d low, high;
    double length() const { return 2 * (high - low).sum(); }
    Eigen::Vector2d at(double along, Eigen::Vector2d* inward = nullptr) const {
        const double w = (high - low).x(), h = (high - low).y();
        double s = std::fmod(along, length());
        if (s < 0) s += length();
        Eigen::Vector2d p, n;
        if (s < w) p = low + Eigen::Vector2d(s, 0), n = {0, 1};
        else if ((s -= w) < h) p = low + Eigen::Vector2d(w, s), n = {-1, 0};
        else if ((s -= h) < w) p = high - Eigen::Vector2d(s, 0), n = {0, -1};
        else p = high - Eigen::Vector2d(w, s - w), n = {1, 0};
        if (inward) *inward = n;
        return p;
    }
};

std::vector<Waypoint> poke(const MotionOptions& o) {
    std::mt19937_64 random(o.seed);
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant(ring_m);
    const Ring box{o.low_m, o.high_m}, ring{o.low_m - margin, o.high_m + margin};
    const double w = (o.high_m - o.low_m).x(), h = (o.high_m - o.low_m).y();
    std::vector<Waypoint> motion;
    double time = 0, ring_at = -1;
    while (time < o.seconds) {
        // a place on the right, top or left side, not at its ends
        const double along = w + 0.1 * h + uniform(random) * (2 * h + w - 0.2 * h);
        Eigen::Vector2d inward;
        const Eigen::Vector2d place = box.at(along, &inward), outside = place - ring_m * inward;
        // round the tissue to it
        const auto ring_along = [&](const Eigen::Vector2d& p) {
            double best = 0, distance = 1e9;
            for (int k = 0; k < 400; ++k) {
                const double s = ring.length() * k / 400, d = (ring.at(s) - p).norm();
                if (d < distance) distance = d, best = s;
            }
            return best;
        };
        const double target = ring_along(outside);
        if (ring_at < 0) {
            motion.push_back({time, ring.at(target)});
        } else {
            const int steps = std::max(1, static_cast<int>(std::abs(target - ring_at) / 0.01));
            const double from = ring_at;
            for (int k = 0; k <= steps; ++k) {
                const Eigen::Vector2d p = ring.at(from + (target - from) * k / steps);
                time += (p - motion.back().point_m).norm() / travel_m_s + 1e-3;
                motion.push_back({time, p});
            }
        }
        ring_at = target;
        const double depth = o.depth_m * (0.2 + 0.8 * uniform(random)), slant = 0.5 * (2 * uniform(random) - 1);
        const Eigen::Vector2d aim = place + depth * (inward + slant * Eigen::Vector2d(-inward.y(), inward.x()));
        const double in = 0.15 + 0.35 * uniform(random);
        motion.push_back({time += 0.1, outside});
        motion.push_back({time += in, aim});
        motion.push_back({time += 0.2 * uniform(random) + 0.05, aim});
        motion.push_back({time += in, outside});
    }
    return motion;
}

}  // namespace

const std::vector<std::string>& motion_names() {
    static const std::vector<std::string> names = {"press", "slide", "poke", "sine"};
    return names;
}

std::vector<Waypoint> press_motion(const Eigen::Vector2d& contact_m, const Eigen::Vector2d& inward,
                                   const Eigen::Vector2d& push_m, double seconds, double inset_m) {
    const Eigen::Vector2d touch = contact_m + inset_m * inward;
    return {{0, contact_m - clearance_m * inward}, {0.25 * seconds, touch}, {seconds, touch + push_m}};
}

std::vector<Waypoint> make_motion(const MotionOptions& o) {
    if (!(o.depth_m > 0) || !(o.seconds > 0)) throw MismatchError("a motion needs a positive depth and time");
    const Eigen::Vector2d top(0.5 * (o.low_m.x() + o.high_m.x()), o.high_m.y()), down(0, -1);
    const double side = 0.2 * (o.high_m - o.low_m).x();
    if (o.name == "press") return press_motion(top, down, o.depth_m * down, 1, 0);
    if (o.name == "poke") return poke(o);
    std::vector<Waypoint> motion = {{0, top - clearance_m * down}};
    const auto go = [&](double seconds, const Eigen::Vector2d& p) {
        motion.push_back({motion.back().time_s + seconds, p});
    };
    if (o.name == "slide") {
        const Eigen::Vector2d across(side, 0);
        while (motion.back().time_s < o.seconds) {
            go(0.5, top + o.depth_m * down);
            go(1.0, top + o.depth_m * down + across);
            go(1.0, top + o.depth_m * down - across);
            go(0.5, top - clearance_m * down);
        }
        return motion;
    }
    if (o.name == "sine") {
        while (motion.back().time_s < o.seconds) {
            go(0.5, top + o.depth_m * down);
            go(0.5, top - clearance_m * down);
        }
        return motion;
    }
    throw MismatchError(fmt::format("motion '{}' is not known; allowed: {}", o.name, fmt::join(motion_names(), ", ")));
}

VirtualDevice::VirtualDevice(std::vector<Waypoint> motion, const DeviceMap& map) : motion_(std::move(motion)), map_(map) {
    if (motion_.empty()) throw MismatchError("a motion without waypoints");
}

DeviceSample VirtualDevice::read(double time_s) noexcept {
    while (next_ < motion_.size() && motion_[next_].time_s <= time_s) ++next_;
    DeviceSample sample;
    const Waypoint& before = motion_[next_ - 1];
    Eigen::Vector2d point = before.point_m;
    if (next_ < motion_.size()) {
        const Waypoint& after = motion_[next_];
        const double t = std::max(0.0, (time_s - before.time_s) / (after.time_s - before.time_s));
        point += t * t * (3 - 2 * t) * (after.point_m - before.point_m);
    }
    sample.position_m = map_.to_device(point);
    return sample;
}

}  // namespace tissue
