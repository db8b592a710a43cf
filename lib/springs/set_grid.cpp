#include "springs/set_grid.h"

#include <algorithm>
#include <cmath>

namespace tissue {
namespace {

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

int SetGrid::nearest(double arc_m, const Eigen::Vector2d& direction, double depth_m) const {
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
    return push->set[depth];
}

}  // namespace tissue
