#include "haptic/virtual_device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include <Eigen/Geometry>

#include "error.h"
#include "mesh/facet.h"
#include "mesh/free_surface.h"

namespace tissue {
namespace {

constexpr double clearance_m = 0.005;    ///< distance from the surface at which a motion starts
constexpr double ring_m = 0.015;         ///< least distance from the tissue on the path around it
constexpr double pi = 3.14159265358979323846;
constexpr double travel_m_s = 0.2;

/// Uniform in [0, 1), the same on every machine (std::uniform_real_distribution is not).
double uniform(std::mt19937_64& random) {
    return static_cast<double>(random() >> 11) * 0x1.0p-53;
}

/// A point of the free surface, and the inward normal there.
struct Aim {
    Point place_m, inward;
};

/// Draws points uniformly over the free surface: a facet by its measure, then a point in it. Points near creases and
/// ends are left out, and points from which the straight path out of the tissue meets the tissue again.
class Aims {
   public:
    Aims(const SpringMesh& mesh, unsigned long seed)
        : surface_(mesh), random_(seed), centre_m_((low(mesh) + high(mesh)) / 2), radius_m_((high(mesh) - low(mesh)).norm() / 2 + ring_m),
          clear_m_(0.1 * (high(mesh) - low(mesh)).minCoeff()), nodes_(mesh.nodes), facets_(mesh.facets) {}

    static Point low(const SpringMesh& mesh) { return mesh.own_nodes().colwise().minCoeff().transpose(); }
    static Point high(const SpringMesh& mesh) { return mesh.own_nodes().colwise().maxCoeff().transpose(); }
    double uniform() { return tissue::uniform(random_); }

    Aim draw() {
        constexpr int most_tries = 1000;
        Aim aim;
        for (int tries = 0; tries < most_tries; ++tries) {
            double share = uniform() * surface_.measure().sum();
            Eigen::Index facet = 0;
            while (facet + 1 < surface_.facets().rows() && (share -= surface_.measure()[facet]) > 0) ++facet;
            double a = uniform(), b = surface_.facets().cols() == 3 ? uniform() : 0;
            if (a + b > 1) a = 1 - a, b = 1 - b;
            const FreeSurface::Place place = surface_.nearest(surface_.at(facet, {1 - a - b, a, b}));
            aim = {place.point_m, place.inward};
            if (surface_.to_crease_m(aim.place_m) > clear_m_ && goes_out(aim)) break;
        }
        return aim;
    }

    /// Point where the straight path out of the tissue meets the circle, or sphere, around it.
    Point exit(const Aim& aim) const {
        const Point from = aim.place_m - centre_m_;
        const double along = from.dot(aim.inward), off = from.squaredNorm() - radius_m_ * radius_m_;
        return aim.place_m - (along + std::sqrt(along * along - off)) * aim.inward;
    }

    /// Points of the path around the tissue from one such point to another; the last is the end itself.
    std::vector<Point> round(const Point& from, const Point& to) const {
        constexpr double step = 0.1;  // rad
        const Point a = (from - centre_m_) / radius_m_, b = (to - centre_m_) / radius_m_;
        const double angle = std::acos(std::clamp(a.dot(b), -1.0, 1.0));
        Point across = b - a.dot(b) * a;
        if (across.norm() < 1e-6) {  // opposite: over the top
            across = Point::Unit(a.size(), a.size() - 1);
            across -= a.dot(across) * a;
        }
        across.normalize();
        std::vector<Point> way;
        const int steps = std::max(1, static_cast<int>(angle / step));
        for (int k = 1; k <= steps; ++k) way.push_back(centre_m_ + radius_m_ * (std::cos(angle * k / steps) * a + std::sin(angle * k / steps) * across));
        return way;
    }

   private:
    /// Whether the straight path out stays clear of the surface: farther from it than half of the distance travelled,
    /// or clearance_m if that is less.
    bool goes_out(const Aim& aim) const {
        const Point end = exit(aim);
        const double length = (end - aim.place_m).norm();
        for (double at = 2 * clearance_m; at < length; at += clearance_m)
            for (Eigen::Index f = 0; f < facets_.rows(); ++f)
                if (nearest_on_facet(nodes_, facets_, f, aim.place_m - at * aim.inward).distance_m < std::min(at / 2, clearance_m)) return false;
        return true;
    }

    FreeSurface surface_;
    std::mt19937_64 random_;
    Point centre_m_;
    double radius_m_, clear_m_;
    NodeField nodes_;
    Cells facets_;
};

/// A unit vector perpendicular to `inward`, as near to the first axis as possible, or to the last where inward is
/// nearly along the first.
Point sideways(const Point& inward) {
    Eigen::Vector3d along = Eigen::Vector3d::Zero(), in = Eigen::Vector3d::Zero();
    in.head(inward.size()) = inward;
    along[std::abs(inward[0]) < 0.9 ? 0 : inward.size() - 1] = 1;
    return (along - along.dot(in) * in).normalized().head(inward.size());
}

/// Indentations at points of the free surface drawn by seed, up to 27 degrees off its normal. The tool stays at the
/// deepest point for stay_s at least.
std::vector<Waypoint> pokes(const MotionOptions& o, double stay_s) {
    Aims aims(*o.rest, o.seed);
    std::vector<Waypoint> motion;
    double time = 0;
    Point exit, first_exit;
    const auto travel = [&](const Point& to) {
        time += (to - motion.back().point_m).norm() / travel_m_s + 1e-3;
        motion.push_back({time, to});
    };
    while (time < o.seconds) {
        const Aim aim = aims.draw();
        const Point outside = aim.place_m - ring_m * aim.inward;
        if (motion.empty()) {
            motion.push_back({time, outside});
            first_exit = aims.exit(aim);
        } else {
            travel(exit);
            for (const Point& point : aims.round(exit, aims.exit(aim))) travel(point);
            travel(outside);
        }
        exit = aims.exit(aim);
        const double depth = o.depth_m * (0.2 + 0.8 * aims.uniform()), slant = 0.5 * (2 * aims.uniform() - 1);
        Point across = sideways(aim.inward);
        if (across.size() == 3) {
            const Eigen::Vector3d in = aim.inward, first = across;
            const double turned = 2 * pi * aims.uniform();
            across = std::cos(turned) * first + std::sin(turned) * in.cross(first);
        }
        const Point deepest = aim.place_m + depth * (aim.inward + slant * across);
        const double in = 0.15 + 0.35 * aims.uniform();
        motion.push_back({time += 0.1, outside});
        motion.push_back({time += in, deepest});
        motion.push_back({time += 0.2 * aims.uniform() + stay_s, deepest});
        motion.push_back({time += in, outside});
    }
    // back to the start, around the tissue, so that the motion can be repeated
    travel(exit);
    for (const Point& point : aims.round(exit, first_exit)) travel(point);
    travel(motion.front().point_m);
    return motion;
}

std::vector<Waypoint> poke(const MotionOptions& o) { return pokes(o, 0.05); }
/// As for a measurement of force: the tool waits until the tissue is at rest.
std::vector<Waypoint> probe(const MotionOptions& o) { return pokes(o, 1); }

}  // namespace

std::vector<Waypoint> indentation_motion(const Point& contact_m, const Point& inward,
                                   const Point& push_m, double seconds, double inset_m) {
    const Point touch = contact_m + inset_m * inward;
    return {{0, contact_m - clearance_m * inward}, {0.25 * seconds, touch}, {seconds, touch + push_m}};
}

namespace {

/// The point of the surface nearest to the middle of the bounding box's top, or to a point aside_m from it.
Aim middle_of_top(const MotionOptions& o) {
    Point top = (Aims::low(*o.rest) + Aims::high(*o.rest)) / 2;
    top[top.size() - 1] = Aims::high(*o.rest)[top.size() - 1];
    if (const double half_m = (Aims::high(*o.rest) - Aims::low(*o.rest))[0] / 2; !(std::abs(o.aside_m) < half_m)) throw MismatchError(fmt::format("aside must be within {:g} m of the middle, not {:g}", half_m, o.aside_m));
    top[0] += o.aside_m;
    const FreeSurface::Place place = FreeSurface(*o.rest).nearest(top);
    return {place.point_m, place.inward};
}

/// Indents the middle of the top, and stays.
std::vector<Waypoint> press(const MotionOptions& o) {
    const Aim top = middle_of_top(o);
    return indentation_motion(top.place_m, top.inward, o.depth_m * top.inward, 1, 0);
}

/// A waypoint `seconds` after the one before, relative to the middle of the top: along the surface, and into the
/// tissue.
struct Stop {
    double seconds, along_m, in_m;
    bool grasp = false;
};

/// From above the middle of the top through the stops, repeatedly.
std::vector<Waypoint> round(const MotionOptions& o, const std::vector<Stop>& stops) {
    const Aim top = middle_of_top(o);
    const Point along = sideways(top.inward);
    std::vector<Waypoint> motion = {{0, top.place_m - clearance_m * top.inward}};
    while (motion.back().time_s < o.seconds)
        for (const Stop& stop : stops)
            motion.push_back({motion.back().time_s + stop.seconds, top.place_m + stop.along_m * along + stop.in_m * top.inward, stop.grasp});
    return motion;
}

/// Indents the middle of the top, then moves along it and back.
std::vector<Waypoint> slide(const MotionOptions& o) {
    const double side = 0.2 * (Aims::high(*o.rest) - Aims::low(*o.rest))[0];
    return round(o, {{0.5, 0, o.depth_m}, {1.0, side, o.depth_m}, {1.0, -side, o.depth_m}, {0.5, 0, -clearance_m}});
}

/// Indents the middle of the top and leaves it, at 1 Hz.
std::vector<Waypoint> sine(const MotionOptions& o) {
    return round(o, {{0.5, 0, o.depth_m}, {0.5, 0, -clearance_m}});
}

/// Touches the middle of the top, grasps it, lifts it by the depth, and lets go.
std::vector<Waypoint> pull(const MotionOptions& o) {
    constexpr double touch_m = 0.001;
    return round(o, {{0.5, 0, touch_m}, {0.2, 0, touch_m, true}, {1.0, 0, -o.depth_m, true}, {1.0, 0, -o.depth_m}, {0.5, 0, -clearance_m}});
}

struct Motion {
    const char* name;
    std::vector<Waypoint> (*make)(const MotionOptions&);
    bool has_middle;  ///< it is at the middle of the top, or aside_m from it
};
constexpr Motion motions[] = {{"press", press, true}, {"slide", slide, true}, {"poke", poke, false}, {"probe", probe, false}, {"sine", sine, true}, {"pull", pull, true}};

std::string not_a_motion(const std::string& name) {
    for (const Motion& motion : motions)
        if (name == motion.name) return "";
    return fmt::format("motion '{}' is not known; allowed: {}", name, fmt::join(motion_names(), ", "));
}

std::string not_a_depth(const std::string& text) {
    char* end = nullptr;
    const double depth = std::strtod(text.c_str(), &end);
    return !text.empty() && *end == '\0' && depth > 0 && std::isfinite(depth) ? "" : "must be a positive number, not " + text;
}

std::string not_a_length(const std::string& text) {
    char* end = nullptr;
    const double length = std::strtod(text.c_str(), &end);
    return !text.empty() && *end == '\0' && std::abs(length) < 10 ? "" : "must be a length of less than 10 m, not " + text;
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
    if (!o.rest) throw MismatchError("a motion needs the tissue's surface");
    MotionOptions made = o;
    made.seconds = std::min(o.seconds, longest_motion_s);
    for (const Motion& motion : motions)
        if (o.name == motion.name) {
            if (o.aside_m != 0 && !motion.has_middle) throw MismatchError(fmt::format("motion {} draws its places at random; --aside has no effect: leave it out", o.name));
            return motion.make(made);
        }
    throw MismatchError(not_a_motion(o.name));
}

const DeviceKind VirtualDevice::kind = {
    "virtual",
    {{"motion", "NAME", motions[0].name, fmt::format("motion of the virtual device: {}", fmt::join(motion_names(), ", ")), false, not_a_motion},
     {"depth", "m", "0.01", "largest depth of the virtual device below the surface; for pull its height above the surface", false, not_a_depth},
     {"aside", "m", "0", "place of press, slide, sine and pull: distance from the middle of the top along the first axis", false, not_a_length}},
    [](const DeviceValues& v, const DeviceContext& c) -> std::unique_ptr<Device> {
        const MotionOptions motion{v.at("motion"), c.seconds > 0 ? c.seconds : longest_motion_s, std::strtod(v.at("depth").c_str(), nullptr), c.seed, c.rest, std::strtod(v.at("aside").c_str(), nullptr)};
        return std::make_unique<VirtualDevice>(make_motion(motion), c.map, true);
    },
    {}, 10, true, true};

VirtualDevice::VirtualDevice(std::vector<Waypoint> motion, const DeviceMap& map, bool over_and_over) : motion_(std::move(motion)), map_(map) {
    if (motion_.empty()) throw MismatchError("a motion needs waypoints");
    map_.fit(static_cast<int>(motion_.front().point_m.size()));
    if (over_and_over && (motion_.back().point_m - motion_.front().point_m).norm() < 1e-9) again_s_ = motion_.back().time_s - motion_.front().time_s;
}

DeviceSample VirtualDevice::read(double time_s) noexcept {
    if (again_s_ > 0 && time_s - begun_s_ > again_s_) {
        begun_s_ += again_s_ * std::floor((time_s - begun_s_) / again_s_);
        next_ = 1;
    }
    time_s -= begun_s_;
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
    sample.grasp = before.grasp;
    return sample;
}

}  // namespace tissue
