#include "haptic/moving_outline.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "error.h"
#include "hot_loop.h"

namespace tissue {
namespace kernel {

/// 1 where a ray from p along +x crosses an odd number of segments, else 0.
TISSUE_HOT int odd_crossings(int n, const double* __restrict x, const double* __restrict y, double px, double py) {
    int crossings = 0;
    for (int b = 0; b < n; ++b) {
        const double rise = y[b + 1] - y[b], side = (x[b + 1] - x[b]) * (py - y[b]) - (px - x[b]) * rise;
        const int up = (y[b] <= py) & (y[b + 1] > py) & (side > 0);
        const int down = (y[b + 1] <= py) & (y[b] > py) & (side < 0);
        crossings += up + down;
    }
    return crossings & 1;
}

/// Number of boxes from `first` on that touch box a.
TISSUE_HOT int overlaps(int first, int n, const double* __restrict low_x, const double* __restrict high_x,
                        const double* __restrict low_y, const double* __restrict high_y, int a) {
    const double lx = low_x[a], hx = high_x[a], ly = low_y[a], hy = high_y[a];
    int count = 0;
    for (int b = first; b < n; ++b)
        count += (low_x[b] <= hx) & (high_x[b] >= lx) & (low_y[b] <= hy) & (high_y[b] >= ly);
    return count;
}

}  // namespace kernel

namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
}

/// Twice the signed area of a, b, c.
double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return cross(b - a, c - a);
}

}  // namespace

MovingOutline::MovingOutline(int segments)
    : count_(segments), x_(static_cast<std::size_t>(segments) + 1, 0.0), y_(x_), low_x_(static_cast<std::size_t>(segments), 0.0),
      high_x_(low_x_), low_y_(low_x_), high_y_(low_x_) {}

MovingOutline::MovingOutline(const SpringMesh& mesh) : MovingOutline(static_cast<int>(mesh.facets.rows())) {
    if (mesh.is_solid()) throw MismatchError("an outline needs a mesh in the plane");
    nodes_ = mesh.loop();
    move(Point::Zero(2), mesh.nodes, NodeColumns::Zero(mesh.node_count(), 2));
}

void MovingOutline::move(const Point& place_m, const NodeColumns& rest, const NodeColumns& u) noexcept {
    for (std::size_t b = 0; b < nodes_.size(); ++b) {
        x_[b] = place_m[0] + (rest(nodes_[b], 0) + u(nodes_[b], 0));
        y_[b] = place_m[1] + (rest(nodes_[b], 1) + u(nodes_[b], 1));
    }
    refresh();
}

void MovingOutline::refresh() noexcept {
    x_[static_cast<std::size_t>(count_)] = x_[0];
    y_[static_cast<std::size_t>(count_)] = y_[0];
    for (std::size_t b = 0; b < static_cast<std::size_t>(count_); ++b) {
        low_x_[b] = std::min(x_[b], x_[b + 1]);
        high_x_[b] = std::max(x_[b], x_[b + 1]);
        low_y_[b] = std::min(y_[b], y_[b + 1]);
        high_y_[b] = std::max(y_[b], y_[b + 1]);
    }
}

bool MovingOutline::contains(const Point& p) const noexcept {
    return kernel::odd_crossings(count_, x_.data(), y_.data(), p.x(), p.y()) != 0;
}

SurfacePlace MovingOutline::nearest(const Point& asked) const noexcept {
    const Eigen::Vector2d p = asked;
    SurfacePlace best;
    double best2 = std::numeric_limits<double>::infinity();
    for (int b = 0; b < count_; ++b) {
        const Eigen::Vector2d start = node(b), along = node(b + 1) - start;
        const double length2 = along.squaredNorm();
        const double w = length2 > 0 ? std::clamp((p - start).dot(along) / length2, 0.0, 1.0) : 0.0;
        const double distance2 = (start + w * along - p).squaredNorm();
        if (distance2 < best2) {
            best2 = distance2;
            best.facet = b;
            best.weight << 1 - w, w, 0;
        }
    }
    best.position_m = at(best.facet, best.weight[1]);
    best.distance_m = (best.position_m - asked).norm();
    return best;
}

std::optional<SurfacePlace> MovingOutline::first_crossing(const Point& from, const Point& to) const noexcept {
    const Eigen::Vector2d p = from, m = to;
    std::optional<SurfacePlace> deepest;
    const Eigen::Vector2d way = m - p;
    const double low_x = std::min(p.x(), m.x()), high_x = std::max(p.x(), m.x());
    const double low_y = std::min(p.y(), m.y()), high_y = std::max(p.y(), m.y());
    for (int b = 0; b < count_; ++b) {
        const auto s = static_cast<std::size_t>(b);
        if (low_x_[s] > high_x || high_x_[s] < low_x || low_y_[s] > high_y || high_y_[s] < low_y) continue;
        const Eigen::Vector2d start = node(b), along = node(b + 1) - start;
        const double denominator = cross(way, along);
        if (denominator == 0) continue;  // parallel: the crossing is found on a neighbour
        const double t = cross(start - p, along) / denominator, w = cross(start - p, way) / denominator;
        if (!(t >= 0 && t <= 1 && w >= 0 && w <= 1)) continue;
        const Eigen::Vector2d point = at(b, w);
        const double depth = (m - point).norm();
        if (!deepest || depth > deepest->distance_m) deepest = SurfacePlace{b, {1 - w, w, 0}, point, depth};
    }
    return deepest;
}

bool MovingOutline::crosses(int a, int b) const noexcept {
    const Eigen::Vector2d a0 = node(a), a1 = node(a + 1), b0 = node(b), b1 = node(b + 1);
    if (b == a + 1 || (a == 0 && b == count_ - 1)) {
        // neighbours share a node; they touch elsewhere only when one is folded back on the other
        const Eigen::Vector2d joint = b == a + 1 ? a1 : a0, one = b == a + 1 ? a0 : a1, other = b == a + 1 ? b1 : b0;
        return cross(one - joint, other - joint) == 0 && (one - joint).dot(other - joint) >= 0;
    }
    const double d0 = turn(a0, a1, b0), d1 = turn(a0, a1, b1), d2 = turn(b0, b1, a0), d3 = turn(b0, b1, a1);
    return ((d0 >= 0 && d1 <= 0) || (d0 <= 0 && d1 >= 0)) && ((d2 >= 0 && d3 <= 0) || (d2 <= 0 && d3 >= 0));
}

bool MovingOutline::simple() noexcept {
    double area = 0;
    for (int b = 0; b < count_; ++b) area += cross(node(b) - node(0), node(b + 1) - node(0));
    if (!(area > 0)) return false;  // clockwise: inverted
    for (int a = 0; a + 1 < count_; ++a) {
        // the box of the next segment always touches; that of the last segment touches the first
        const int touching =
            kernel::overlaps(a + 1, count_, low_x_.data(), high_x_.data(), low_y_.data(), high_y_.data(), a);
        if (touching <= (a == 0 ? 2 : 1)) {
            if (crosses(a, a + 1) || (a == 0 && crosses(0, count_ - 1))) return false;
            continue;
        }
        for (int b = a + 1; b < count_; ++b) {
            const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
            if (low_x_[i] <= high_x_[j] && high_x_[i] >= low_x_[j] && low_y_[i] <= high_y_[j] &&
                high_y_[i] >= low_y_[j] && crosses(a, b))
                return false;
        }
    }
    return true;
}

}  // namespace tissue
