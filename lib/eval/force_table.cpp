#include "eval/force_table.h"

#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

constexpr double same_place = 1e-7;  // [m]
constexpr double same_angle = 1e-6;  // [rad]

/// Indices of the two neighbours of a value in an ascending list, and the weight of the second. At the ends of the
/// list, and outside, both indices are equal.
struct Bracket {
    std::size_t low, high;
    double weight_high;
    bool below, above;
};

template <class List, class Value>
Bracket bracket(const List& list, double x, double tolerance, Value value) {
    std::size_t high = 0;
    while (high < list.size() && value(list[high]) < x) ++high;
    if (high == 0) return {0, 0, 0, x < value(list[0]) - tolerance, false};
    if (high == list.size()) return {high - 1, high - 1, 0, false, x > value(list[high - 1]) + tolerance};
    const double a = value(list[high - 1]), b = value(list[high]);
    return {high - 1, high, (x - a) / (b - a), false, false};
}

template <class At>
ForceTable::Entry between(const Bracket& b, const At& at) {
    ForceTable::Entry entry = at(b.low);
    if (b.weight_high > 0) {
        const ForceTable::Entry high = at(b.high);
        entry.force_N += b.weight_high * (high.force_N - entry.force_N);
        entry.extrapolated |= high.extrapolated;
    }
    entry.extrapolated |= b.below || b.above;
    return entry;
}

}  // namespace

ForceTable::ForceTable(const Outline& outline, const std::vector<TablePush>& all) : outline_(outline) {
    for (const TablePush& one : all) {
        const double arc = outline_.arc_of(one.contact_m), angle = outline_.angle(arc, one.direction);
        auto place = std::find_if(places_.begin(), places_.end(),
                                  [&](const Place& p) { return std::abs(p.arc_m - arc) < same_place; });
        if (place == places_.end()) place = places_.insert(places_.end(), {arc, {}});
        auto& pushes = place->pushes;
        auto push = std::find_if(pushes.begin(), pushes.end(),
                                 [&](const Push& p) { return std::abs(p.angle - angle) < same_angle; });
        if (push == pushes.end()) push = pushes.insert(pushes.end(), {angle, {}, {}});
        const double depth_m = one.depth_m;
        const auto deeper = std::upper_bound(push->depth_m.begin(), push->depth_m.end(), depth_m);
        push->force_N.insert(push->force_N.begin() + (deeper - push->depth_m.begin()), one.force_N);
        push->depth_m.insert(deeper, depth_m);
    }
    std::sort(places_.begin(), places_.end(), [](const auto& a, const auto& b) { return a.arc_m < b.arc_m; });
    for (Place& p : places_)
        std::sort(p.pushes.begin(), p.pushes.end(), [](const auto& a, const auto& b) { return a.angle < b.angle; });
}

ForceTable::Entry ForceTable::along(const Push& push, double depth_m) {
    const Bracket b = bracket(push.depth_m, depth_m, same_place, [](double x) { return x; });
    Entry entry = between(b, [&](std::size_t i) { return Entry{push.force_N[i], false}; });
    if (b.below) return {depth_m / push.depth_m.front() * entry.force_N, false};
    return entry;
}

ForceTable::Entry ForceTable::at(double arc_m, const Eigen::Vector2d& direction, double depth_m) const {
    const Bracket p = bracket(places_, arc_m, same_place, [](const Place& q) { return q.arc_m; });
    return between(p, [&](std::size_t i) {
        const Place& place = places_[i];
        const Bracket a = bracket(place.pushes, outline_.angle(place.arc_m, direction), same_angle,
                                  [](const Push& q) { return q.angle; });
        return between(a, [&](std::size_t j) { return along(place.pushes[j], depth_m); });
    });
}

}  // namespace tissue
