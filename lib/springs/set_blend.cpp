#include "springs/set_blend.h"

#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

/// Two neighbours in an ascending list and the second's weight; one when the value is at the end or beyond.
struct Bracket {
    std::size_t low, high;
    double weight_high;
    bool outside;
};

template <class List, class Value>
Bracket bracket(const List& list, double x, double tolerance, Value value) {
    std::size_t high = 0;
    while (high < list.size() && value(list[high]) < x) ++high;
    if (high == 0) return {0, 0, 0, x < value(list[0]) - tolerance};
    if (high == list.size()) return {high - 1, high - 1, 0, x > value(list[high - 1]) + tolerance};
    const double a = value(list[high - 1]), b = value(list[high]);
    return {high - 1, high, (x - a) / (b - a), false};
}

constexpr double same_place = 1e-7;  // [m]
constexpr double same_angle = 1e-6;  // [rad]

}  // namespace

SetGrid::SetGrid(const SpringMesh& mesh, const NodeField& contact_m, const NodeField& direction,
                 const Eigen::VectorXd& depth_m)
    : outline_(mesh) {
    for (int c = 0; c < static_cast<int>(depth_m.size()); ++c) {
        const double arc = outline_.arc_of(contact_m.row(c));
        const double angle = outline_.angle(arc, direction.row(c).transpose());
        auto position = std::find_if(positions_.begin(), positions_.end(),
                                     [&](const Position& p) { return std::abs(p.arc - arc) < same_place; });
        if (position == positions_.end()) position = positions_.insert(positions_.end(), {arc, {}});
        auto& pushes = position->pushes;
        auto push = std::find_if(pushes.begin(), pushes.end(),
                                 [&](const Push& p) { return std::abs(p.angle - angle) < same_angle; });
        if (push == pushes.end()) push = pushes.insert(pushes.end(), {angle, {}, {}});
        const auto place = std::upper_bound(push->depth.begin(), push->depth.end(), depth_m[c]);
        push->set.insert(push->set.begin() + (place - push->depth.begin()), c);
        push->depth.insert(place, depth_m[c]);
    }
    std::sort(positions_.begin(), positions_.end(), [](const auto& a, const auto& b) { return a.arc < b.arc; });
    for (Position& p : positions_)
        std::sort(p.pushes.begin(), p.pushes.end(), [](const auto& a, const auto& b) { return a.angle < b.angle; });
}

bool SetGrid::dense() const {
    return positions_.size() > 1 &&
           std::all_of(positions_.begin(), positions_.end(), [](const Position& p) { return p.pushes.size() > 1; });
}

SetWeights SetGrid::blended(double arc_m, const Eigen::Vector2d& direction, double depth_m) const {
    SetWeights result;
    const Bracket p = bracket(positions_, arc_m, same_place, [](const Position& q) { return q.arc; });
    result.extrapolated = p.outside;
    const auto add = [&](int set, double weight) {
        if (!(weight > 0)) return;
        result.set[static_cast<std::size_t>(result.count)] = set;
        result.weight[static_cast<std::size_t>(result.count++)] = weight;
    };
    for (int i = 0; i < (p.low == p.high ? 1 : 2); ++i) {
        const double wp = i == 0 ? 1 - p.weight_high : p.weight_high;
        if (!(wp > 0)) continue;
        const Position& position = positions_[i == 0 ? p.low : p.high];
        const Bracket a = bracket(position.pushes, outline_.angle(position.arc, direction), same_angle,
                                  [](const Push& q) { return q.angle; });
        result.extrapolated |= a.outside;
        for (int j = 0; j < (a.low == a.high ? 1 : 2); ++j) {
            const double wa = wp * (j == 0 ? 1 - a.weight_high : a.weight_high);
            const Push& push = position.pushes[j == 0 ? a.low : a.high];
            const Bracket d = bracket(push.depth, depth_m, same_place, [](double x) { return x; });
            result.extrapolated |= d.outside && depth_m > push.depth.front();
            add(push.set[d.low], wa * (1 - d.weight_high));
            if (d.high != d.low) add(push.set[d.high], wa * d.weight_high);
        }
    }
    return result;
}

SetWeights SetGrid::nearest(double arc_m, const Eigen::Vector2d& direction, double depth_m) const {
    SetWeights result = blended(arc_m, direction, depth_m);  // for what is outside
    const Position* position = &positions_[0];
    for (const Position& q : positions_)
        if (std::abs(q.arc - arc_m) < std::abs(position->arc - arc_m)) position = &q;
    const double angle = outline_.angle(position->arc, direction);
    const Push* push = &position->pushes[0];
    for (const Push& q : position->pushes)
        if (std::abs(q.angle - angle) < std::abs(push->angle - angle)) push = &q;
    std::size_t depth = 0;
    for (std::size_t i = 1; i < push->depth.size(); ++i)
        if (std::abs(push->depth[i] - depth_m) < std::abs(push->depth[depth] - depth_m)) depth = i;
    result.count = 1;
    result.set[0] = push->set[depth];
    result.weight[0] = 1;
    return result;
}

Eigen::VectorXd blend(const NodeField& theta, const SetWeights& weights) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(theta.cols());
    for (int i = 0; i < weights.count; ++i)
        sum += weights.weight[static_cast<std::size_t>(i)] * theta.row(weights.set[static_cast<std::size_t>(i)]).transpose();
    return sum;
}

}  // namespace tissue
