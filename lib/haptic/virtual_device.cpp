#include "haptic/virtual_device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdlib>
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

/// In and out at places of the free outline drawn by seed.
std::vector<Waypoint> poke(const MotionOptions& o) {
    std::mt19937_64 random(o.seed);
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant(ring_m);
    const Eigen::Vector2d low = o.low_m, high = o.high_m;
    const Ring box{low, high}, ring{low - margin, high + margin};
    const double w = (high - low).x(), h = (high - low).y();
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

std::vector<Waypoint> press_motion(const Point& contact_m, const Point& inward,
                                   const Point& push_m, double seconds, double inset_m) {
    const Point touch = contact_m + inset_m * inward;
    return {{0, contact_m - clearance_m * inward}, {0.25 * seconds, touch}, {seconds, touch + push_m}};
}

namespace {

Eigen::Vector2d middle_of_top(const MotionOptions& o) {
    return {0.5 * (o.low_m.x() + o.high_m.x()), o.high_m.y()};
}

/// Into the middle of the top, and stay.
std::vector<Waypoint> press(const MotionOptions& o) {
    const Eigen::Vector2d down(0, -1);
    return press_motion(middle_of_top(o), down, o.depth_m * down, 1, 0);
}

Waypoint stop(double seconds, double x, double y) { return {seconds, Eigen::Vector2d(x, y)}; }

/// From above the middle of the top through the stops, each a time and a place from there, over and over.
std::vector<Waypoint> round(const MotionOptions& o, const std::vector<Waypoint>& stops) {
    const Eigen::Vector2d top = middle_of_top(o);
    std::vector<Waypoint> motion = {{0, top + Eigen::Vector2d(0, clearance_m)}};
    while (motion.back().time_s < o.seconds)
        for (const Waypoint& stop : stops) motion.push_back({motion.back().time_s + stop.time_s, Eigen::Vector2d(top + stop.point_m)});
    return motion;
}

/// Into the middle of the top, then along it and back.
std::vector<Waypoint> slide(const MotionOptions& o) {
    const double side = 0.2 * (o.high_m - o.low_m).x();
    return round(o, {stop(0.5, 0, -o.depth_m), stop(1, side, -o.depth_m), stop(1, -side, -o.depth_m), stop(0.5, 0, clearance_m)});
}

/// In and out of the middle of the top at 1 Hz.
std::vector<Waypoint> sine(const MotionOptions& o) {
    return round(o, {stop(0.5, 0, -o.depth_m), stop(0.5, 0, clearance_m)});
}

struct Motion {
    const char* name;
    std::vector<Waypoint> (*make)(const MotionOptions&);
};
constexpr Motion motions[] = {{"press", press}, {"slide", slide}, {"poke", poke}, {"sine", sine}};

std::string not_a_motion(const std::string& name) {
    for (const Motion& motion : motions)
        if (name == motion.name) return "";
    return fmt::format("motion '{}' is not known; allowed: {}", name, fmt::join(motion_names(), ", "));
}

std::string not_a_depth(const std::string& text) {
    char* end = nullptr;
    const double depth = std::strtod(text.c_str(), &end);
    return !text.empty() && *end == '\0' && depth > 0 && std::isfinite(depth) ? "" : "wanted a positive number, not " + text;
}

}  // namespace

const std::vector<std::string>& motion_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const Motion& motion : motions) list.push_back(motion.name);
        return list;
    }();
    return names;
}

std::vector<Waypoint> make_motion(const MotionOptions& o) {
    if (!(o.depth_m > 0) || !(o.seconds > 0)) throw MismatchError("a motion needs a positive depth and time");
    for (const Motion& motion : motions)
        if (o.name == motion.name) return motion.make(o);
    throw MismatchError(not_a_motion(o.name));
}

const DeviceKind VirtualDevice::kind = {
    "virtual",
    {{"motion", "NAME", motions[0].name, fmt::format("of the virtual device: {}", fmt::join(motion_names(), ", ")), false, not_a_motion},
     {"depth", "m", "0.01", "of the virtual device below the surface", false, not_a_depth}},
    [](const DeviceValues& v, const DeviceContext& c) -> std::unique_ptr<Device> {
        constexpr double endless_s = 3600;
        const MotionOptions motion{v.at("motion"), c.seconds > 0 ? c.seconds : endless_s, std::stod(v.at("depth")), c.seed, c.low_m, c.high_m};
        return std::make_unique<VirtualDevice>(make_motion(motion), c.map);
    }};

VirtualDevice::VirtualDevice(std::vector<Waypoint> motion, const DeviceMap& map) : motion_(std::move(motion)), map_(map) {
    if (motion_.empty()) throw MismatchError("a motion without waypoints");
}

DeviceSample VirtualDevice::read(double time_s) noexcept {
    while (next_ < motion_.size() && motion_[next_].time_s <= time_s) ++next_;
    DeviceSample sample;
    const Waypoint& before = motion_[next_ - 1];
    Point point = before.point_m;
    if (next_ < motion_.size()) {
        const Waypoint& after = motion_[next_];
        const double t = std::max(0.0, (time_s - before.time_s) / (after.time_s - before.time_s));
        point += t * t * (3 - 2 * t) * (after.point_m - before.point_m);
    }
    sample.position_m = map_.to_device(point);
    return sample;
}

}  // namespace tissue
