#include "mesh/outline.h"

#include <algorithm>
#include <cmath>

#include "error.h"

namespace tissue {
namespace {

constexpr double corner_cosine = 0.7071067811865476;  // cos 45 degrees

Eigen::Vector2d left_of(const Eigen::Vector2d& along) {
    return Eigen::Vector2d(-along.y(), along.x()).normalized();
}

}  // namespace

Outline::Outline(const SpringMesh& mesh) {
    const std::vector<int> loop = mesh.loop();
    const std::size_t count = loop.size();
    const auto is_fixed = [&](std::size_t b) {
        return std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), loop[b % count]);
    };
    // the surface starts at the last fixed node before a free one, and ends at the next fixed node
    std::size_t starts = 0, first = 0;
    for (std::size_t b = 0; b < count; ++b)
        if (is_fixed(b) && !is_fixed(b + 1)) {
            ++starts;
            first = b;
        }
    if (starts != 1) throw MismatchError("the fixed nodes do not leave one connected free surface");
    for (std::size_t b = first;; ++b) {
        nodes_.push_back(loop[b % count]);
        points_.emplace_back(mesh.nodes.row(nodes_.back()));
        arc_.push_back(arc_.empty() ? 0 : arc_.back() + (points_.back() - points_[points_.size() - 2]).norm());
        if (b > first && is_fixed(b)) break;
    }
}

std::size_t Outline::segment(double arc_m) const {
    const auto above = std::upper_bound(arc_.begin() + 1, arc_.end() - 1, arc_m);
    return static_cast<std::size_t>(above - arc_.begin()) - 1;
}

std::vector<double> Outline::corners() const {
    std::vector<double> arcs;
    for (std::size_t b = 1; b + 1 < points_.size(); ++b)
        if (is_corner(b)) arcs.push_back(arc_[b]);
    return arcs;
}

bool Outline::is_corner(std::size_t b) const {
    const Eigen::Vector2d before = (points_[b] - points_[b - 1]).normalized(),
                          after = (points_[b + 1] - points_[b]).normalized();
    return before.dot(after) < corner_cosine;
}

Eigen::Vector2d Outline::segment_normal(std::size_t b) const {
    return left_of(points_[b + 1] - points_[b]);  // counter-clockwise: the tissue lies to the left
}

Eigen::Vector2d Outline::position(double arc_m) const {
    const double s = std::clamp(arc_m, 0.0, length());
    const std::size_t b = segment(s);
    const double w = (s - arc_[b]) / (arc_[b + 1] - arc_[b]);
    return (1 - w) * points_[b] + w * points_[b + 1];
}

Eigen::Vector2d Outline::inward_normal(double arc_m) const {
    const double s = std::clamp(arc_m, 0.0, length()), tolerance = 1e-9 * length();
    const std::size_t b = segment(s);
    const bool follows = b > 0, goes_on = b + 2 < points_.size();
    Eigen::Vector2d normal = segment_normal(b);
    // curved surface: interpolate between the nodes' normals, each the mean of its two segments' normals
    const double w = (s - arc_[b]) / (arc_[b + 1] - arc_[b]);
    const bool curved_before = follows && !is_corner(b), curved_after = goes_on && !is_corner(b + 1);
    if (curved_before || curved_after) {
        Eigen::Vector2d first = normal, last = normal;
        if (curved_before) first = (normal + segment_normal(b - 1)).normalized();
        if (curved_after) last = (normal + segment_normal(b + 1)).normalized();
        normal = ((1 - w) * first + w * last).normalized();
    }
    if (s - arc_[b] < tolerance && follows && is_corner(b)) normal += segment_normal(b - 1);
    if (arc_[b + 1] - s < tolerance && goes_on && is_corner(b + 1)) normal += segment_normal(b + 1);
    return normal.normalized();
}

Eigen::Vector2d Outline::direction(double arc_m, double angle) const {
    const Eigen::Vector2d n = inward_normal(arc_m);
    return {std::cos(angle) * n.x() - std::sin(angle) * n.y(), std::sin(angle) * n.x() + std::cos(angle) * n.y()};
}

double Outline::angle(double arc_m, const Eigen::Vector2d& direction) const {
    const Eigen::Vector2d n = inward_normal(arc_m);
    return std::atan2(n.x() * direction.y() - n.y() * direction.x(), n.dot(direction));
}

double Outline::arc_of(const Eigen::Vector2d& position_m) const {
    double best = std::numeric_limits<double>::infinity(), arc = 0;
    for (std::size_t b = 0; b + 1 < points_.size(); ++b) {
        const Eigen::Vector2d along = points_[b + 1] - points_[b];
        const double w = std::clamp((position_m - points_[b]).dot(along) / along.squaredNorm(), 0.0, 1.0);
        const double distance = (points_[b] + w * along - position_m).norm();
        if (distance < best) {
            best = distance;
            arc = arc_[b] + w * along.norm();
        }
    }
    return arc;
}

}  // namespace tissue
