#include "haptic/moving_triangles.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string>

#include "error.h"
#include "hot_loop.h"

namespace tissue {
namespace kernel {

/// Bounding boxes of groups of nodes. x: four numbers a node. box: eight numbers a group.
TISSUE_HOT void boxes_of(std::size_t groups, const int* __restrict begin, const int* __restrict nodes, const double* __restrict x, double* __restrict box) {
    for (std::size_t g = 0; g < groups; ++g) {
        double low[4], high[4];
        const double* first = x + 4 * nodes[begin[g]];
        for (int a = 0; a < 4; ++a) low[a] = high[a] = first[a];
        for (int i = begin[g] + 1; i < begin[g + 1]; ++i) {
            const double* p = x + 4 * nodes[i];
            for (int a = 0; a < 4; ++a) low[a] = p[a] < low[a] ? p[a] : low[a];
            for (int a = 0; a < 4; ++a) high[a] = p[a] > high[a] ? p[a] : high[a];
        }
        for (int a = 0; a < 4; ++a) box[8 * g + static_cast<std::size_t>(a)] = low[a];
        for (int a = 0; a < 4; ++a) box[8 * g + static_cast<std::size_t>(a) + 4] = high[a];
    }
}

/// Boxes 1 to count - 1 of a tree whose box i contains the boxes 2 i and 2 i + 1.
TISSUE_HOT void boxes_above(std::size_t count, double* box) {
    for (std::size_t b = count - 1; b > 0; --b) {
        const double *one = box + 16 * b, *other = one + 8;
        double* both = box + 8 * b;
        for (int a = 0; a < 4; ++a) both[a] = one[a] < other[a] ? one[a] : other[a];
        for (int a = 4; a < 8; ++a) both[a] = one[a] > other[a] ? one[a] : other[a];
    }
}

/// Six times the volume inside the triangles: the outward flux of the field (0, 0, z), by the divergence theorem.
/// Coordinates are relative to nodes of the surface, which keeps the rounding error small far from the origin.
TISSUE_HOT double six_volumes(int count, const int* __restrict i, const int* __restrict j, const int* __restrict k, const double* __restrict x) {
    double sum = 0;
    const double from = 3 * x[2];
    for (int t = 0; t < count; ++t) {
        const double *a = x + 4 * i[t], *b = x + 4 * j[t], *c = x + 4 * k[t];
        sum += (a[2] + b[2] + c[2] - from) * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]));
    }
    return sum;
}

}  // namespace kernel

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t most_in_leaf = 4;
constexpr int deepest = 64;            // of the stack: the tree's depth is logarithmic
constexpr int least_looked_at = 6, ticks_of_a_round = 256;  // triangles checked in a call at least; calls at most
constexpr double on_surface_m = 1e-14;  // rounding error of a position on the surface
constexpr double on_edge = 1e-9;         // rounding error of the area of a part of a triangle, over the triangle's
constexpr double folded = 5e-9;         // 1 - cos of 1e-4 rad

/// Weights of the point of a triangle nearest to p, by the Voronoi regions of its features (Ericson, Real-Time
/// Collision Detection, 5.1.5).
Eigen::Vector3d nearest_weights(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
    if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
    if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        const double w = d1 / (d1 - d3);
        return {1 - w, w, 0};
    }
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        const double w = d2 / (d2 - d6);
        return {1 - w, 0, w};
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0, 1 - w, w};
    }
    const double v = vb / (va + vb + vc), w = vc / (va + vb + vc);
    return {1 - v - w, v, w};
}

}  // namespace

/// A line through `from`, and coordinates in which it is the z axis. z is measured along the coordinate axis `az` to
/// which the line is closest; x and y are the distances from the line along the axes `ax` and `ay`.
struct MovingTriangles::Line {
    int ax, ay, az;
    double from[3], slope_x, slope_y;

    Line(const Eigen::Vector3d& p, const Eigen::Vector3d& direction) {
        Eigen::Index most = 0;
        direction.cwiseAbs().maxCoeff(&most);
        az = static_cast<int>(most);
        ax = (az + 1) % 3;
        ay = (az + 2) % 3;
        for (int axis = 0; axis < 3; ++axis) from[axis] = p[axis];
        slope_x = direction[ax] / direction[az];
        slope_y = direction[ay] / direction[az];
    }
    Eigen::Vector3d seen(const double* x) const {
        const double z = x[az] - from[az];
        return {(x[ax] - from[ax]) - slope_x * z, (x[ay] - from[ay]) - slope_y * z, z};
    }
};

MovingTriangles::MovingTriangles(const SpringMesh& mesh) {
    if (!mesh.is_solid()) throw MismatchError("a surface of triangles needs a mesh in space");
    const auto count = static_cast<std::size_t>(mesh.facets.rows());
    std::map<std::array<int, 2>, int> sides;
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f)
        for (int k = 0; k < 3; ++k) ++sides[{mesh.facets(f, k), mesh.facets(f, (k + 1) % 3)}];
    for (const auto& [side, times] : sides) {
        const auto other = sides.find({side[1], side[0]});
        if (times != 1 || other == sides.end())
            throw MismatchError("the mesh's surface is not closed at the edge of nodes " + std::to_string(side[0]) + " and " + std::to_string(side[1]));
    }
    if (count == 0) throw MismatchError("the mesh has no surface");

    while (leaves_ * most_in_leaf < count) leaves_ *= 2;
    std::vector<Eigen::Vector3d> middles;
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f)
        middles.push_back((mesh.nodes.row(mesh.facets(f, 0)) + mesh.nodes.row(mesh.facets(f, 1)) + mesh.nodes.row(mesh.facets(f, 2))).transpose() / 3);
    facet_.resize(count);
    std::iota(facet_.begin(), facet_.end(), 0);
    corners_.resize(count);
    divide(facet_, middles, 0, leaves_);

    std::vector<int> number(static_cast<std::size_t>(mesh.node_count()), -1);
    triangle_of_.resize(count);
    for (std::size_t t = 0; t < count; ++t) {
        triangle_of_[static_cast<std::size_t>(facet_[t])] = static_cast<int>(t);
        for (int k = 0; k < 3; ++k) {
            const int n = mesh.facets(facet_[t], k);
            int& here = number[static_cast<std::size_t>(n)];
            if (here < 0) {
                here = static_cast<int>(nodes_.size());
                nodes_.push_back(n);
            }
            corners_[t][static_cast<std::size_t>(k)] = here;
            corner_[k].push_back(here);
        }
    }
    x_.assign(4 * nodes_.size(), 0.0);
    boxes_.resize(2 * leaves_);
    leaf_begin_.push_back(0);
    for (std::size_t leaf = 0; leaf < leaves_; ++leaf) {
        std::vector<int> own;
        for (int t = first_of(leaf); t < first_of(leaf + 1); ++t) own.insert(own.end(), corners_[static_cast<std::size_t>(t)].begin(), corners_[static_cast<std::size_t>(t)].end());
        std::sort(own.begin(), own.end());
        own.erase(std::unique(own.begin(), own.end()), own.end());
        leaf_nodes_.insert(leaf_nodes_.end(), own.begin(), own.end());
        leaf_begin_.push_back(static_cast<int>(leaf_nodes_.size()));
    }
    crossed_.assign(count, 0);
    looked_at_ = std::min(static_cast<int>(count), std::max(least_looked_at, (static_cast<int>(count) + ticks_of_a_round - 1) / ticks_of_a_round));
    move(Point::Zero(3), mesh.nodes, NodeColumns::Zero(mesh.node_count(), 3));
    for (int t = 0; t < triangles(); ++t) look_at(t);
}

/// Orders the triangles of some leaves: splits them in halves along the axis of their largest extent, recursively.
void MovingTriangles::divide(std::vector<int>& order, const std::vector<Eigen::Vector3d>& middles, std::size_t leaf, std::size_t leaves) {
    if (leaves == 1) return;
    const int first = first_of(leaf), middle = first_of(leaf + leaves / 2), last = first_of(leaf + leaves);
    Eigen::Vector3d low = Eigen::Vector3d::Constant(infinity), high = -low;
    for (int i = first; i < last; ++i) {
        low = low.cwiseMin(middles[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])]);
        high = high.cwiseMax(middles[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])]);
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    std::nth_element(order.begin() + first, order.begin() + middle, order.begin() + last, [&](int a, int b) {
        const double of_a = middles[static_cast<std::size_t>(a)][axis], of_b = middles[static_cast<std::size_t>(b)][axis];
        return of_a != of_b ? of_a < of_b : a < b;
    });
    divide(order, middles, leaf, leaves / 2);
    divide(order, middles, leaf + leaves / 2, leaves / 2);
}

void MovingTriangles::move(const Point& place_m, const NodeColumns& rest, const NodeColumns& u) noexcept {
    for (int axis = 0; axis < 3; ++axis) {
        const double from = place_m[axis];
        const double *r = rest.data() + axis * rest.rows(), *d = u.data() + axis * u.rows();
        for (std::size_t n = 0; n < nodes_.size(); ++n) x_[4 * n + static_cast<std::size_t>(axis)] = from + (r[nodes_[n]] + d[nodes_[n]]);
    }
    refit();
}

void MovingTriangles::refit() noexcept {
    kernel::boxes_of(leaves_, leaf_begin_.data(), leaf_nodes_.data(), x_.data(), boxes_[leaves_].low);
    kernel::boxes_above(leaves_, boxes_[0].low);
}

Point MovingTriangles::at(int facet, const Eigen::Vector3d& weight) const noexcept {
    const Corners& c = corners_[static_cast<std::size_t>(triangle_of_[static_cast<std::size_t>(facet)])];
    return weight[0] * place(c[0]) + weight[1] * place(c[1]) + weight[2] * place(c[2]);
}

/// Whether a line goes through a triangle, and where. Either two edges of the triangle or none cross the line's plane
/// y = 0. The x of such a cut is computed from the edge alone, beginning at its lower node, so that both triangles of
/// the edge get the same value.
bool MovingTriangles::crossed_by(const Line& line, int triangle, Crossing& crossing) const noexcept {
    const Corners& c = corners_[static_cast<std::size_t>(triangle)];
    const Eigen::Vector3d seen[3] = {line.seen(node(c[0])), line.seen(node(c[1])), line.seen(node(c[2]))};
    double cut_x[2], cut_z[2], part[2];
    int from[2], to[2], cuts = 0;
    for (int k = 0; k < 3; ++k) {
        int i = k, j = (k + 1) % 3;
        if (c[static_cast<std::size_t>(i)] > c[static_cast<std::size_t>(j)]) std::swap(i, j);
        if ((seen[i].y() > 0) == (seen[j].y() > 0)) continue;
        const double w = seen[i].y() / (seen[i].y() - seen[j].y());
        part[cuts] = w;
        from[cuts] = i;
        to[cuts] = j;
        cut_x[cuts] = seen[i].x() + w * (seen[j].x() - seen[i].x());
        cut_z[cuts] = seen[i].z() + w * (seen[j].z() - seen[i].z());
        ++cuts;
    }
    if (cuts != 2 || (cut_x[0] > 0) == (cut_x[1] > 0)) return false;
    const double f = std::clamp(cut_x[0] / (cut_x[0] - cut_x[1]), 0.0, 1.0);
    crossing.along = cut_z[0] + f * (cut_z[1] - cut_z[0]);
    crossing.weight.setZero();
    for (int cut = 0; cut < 2; ++cut) {
        const double share = cut == 0 ? 1 - f : f;
        crossing.weight[from[cut]] += share * (1 - part[cut]);
        crossing.weight[to[cut]] += share * part[cut];
    }
    return true;
}

bool MovingTriangles::contains(const Point& asked) const noexcept {
    const Eigen::Vector3d p = asked;
    const Line line(p, Eigen::Vector3d::UnitX());
    bool inside = false;
    std::size_t stack[deepest] = {1};
    int waiting = 1;
    while (waiting > 0) {
        const std::size_t b = stack[--waiting];
        const Box& box = boxes_[b];
        if (!(box.high[0] >= p[0] && box.low[1] <= p[1] && box.high[1] >= p[1] && box.low[2] <= p[2] && box.high[2] >= p[2])) continue;
        if (b < leaves_) {
            stack[waiting++] = 2 * b;
            stack[waiting++] = 2 * b + 1;
            continue;
        }
        for (int t = first_of(b - leaves_); t < first_of(b - leaves_ + 1); ++t) {
            Crossing crossing;
            if (crossed_by(line, t, crossing) && crossing.along > 0) inside = !inside;
        }
    }
    return inside;
}

SurfacePlace MovingTriangles::nearest(const Point& asked) const noexcept {
    const Eigen::Vector3d p = asked;
    const auto away2 = [&](std::size_t b) {
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double off = std::max({0.0, boxes_[b].low[axis] - p[axis], p[axis] - boxes_[b].high[axis]});
            sum += off * off;
        }
        return sum;
    };
    SurfacePlace best;
    double best2 = infinity;
    struct Waiting {
        std::size_t box;
        double away2;
    } stack[deepest];
    stack[0] = {1, 0};
    int waiting = 1;
    while (waiting > 0) {
        const Waiting next = stack[--waiting];
        if (next.away2 >= best2) continue;
        if (next.box < leaves_) {
            Waiting near{2 * next.box, away2(2 * next.box)}, far{2 * next.box + 1, away2(2 * next.box + 1)};
            if (near.away2 > far.away2) std::swap(near, far);
            if (far.away2 < best2) stack[waiting++] = far;
            if (near.away2 < best2) stack[waiting++] = near;
            continue;
        }
        for (int t = first_of(next.box - leaves_); t < first_of(next.box - leaves_ + 1); ++t) {
            const Corners& c = corners_[static_cast<std::size_t>(t)];
            const Eigen::Vector3d x0 = place(c[0]), x1 = place(c[1]), x2 = place(c[2]);
            const Eigen::Vector3d w = nearest_weights(p, x0, x1, x2);
            const double distance2 = (w[0] * x0 + w[1] * x1 + w[2] * x2 - p).squaredNorm();
            if (!(distance2 < best2)) continue;
            best2 = distance2;
            best.facet = facet_[static_cast<std::size_t>(t)];
            best.weight = w;
        }
    }
    best.position_m = at(best.facet, best.weight);
    best.distance_m = (best.position_m - asked).norm();
    return best;
}

std::optional<SurfacePlace> MovingTriangles::first_crossing(const Point& from, const Point& to) const noexcept {
    const Eigen::Vector3d p = from, m = to, way = m - p;
    const double length = way.norm();
    if (!(length > 0)) return {};
    const Line line(p, way);
    // slab test of the boxes on x = p + t way, enlarged by rounding errors
    Eigen::Vector3d per_way;
    for (int axis = 0; axis < 3; ++axis) per_way[axis] = 1 / way[axis];
    const double spare = on_surface_m / length;
    double first_t = 1 + spare;
    SurfacePlace best;
    bool found = false;
    std::size_t stack[deepest] = {1};
    int waiting = 1;
    while (waiting > 0) {
        const std::size_t b = stack[--waiting];
        double enter = -spare, leave = first_t;
        bool beside = false;
        for (int axis = 0; axis < 3; ++axis) {
            const double low = boxes_[b].low[axis] - on_surface_m - p[axis], high = boxes_[b].high[axis] + on_surface_m - p[axis];
            if (way[axis] == 0) {
                beside |= low > 0 || high < 0;
                continue;
            }
            const double one = low * per_way[axis], other = high * per_way[axis];
            enter = std::max(enter, std::min(one, other));
            leave = std::min(leave, std::max(one, other));
        }
        if (beside || enter > leave + 1e-12) continue;
        if (b < leaves_) {
            stack[waiting++] = 2 * b;
            stack[waiting++] = 2 * b + 1;
            continue;
        }
        for (int t = first_of(b - leaves_); t < first_of(b - leaves_ + 1); ++t) {
            Crossing crossing;
            if (!crossed_by(line, t, crossing)) continue;
            const double part = crossing.along / way[line.az];
            if (!(part >= -spare && part <= first_t)) continue;
            const Corners& c = corners_[static_cast<std::size_t>(t)];
            // a path that begins on the surface and leads out does not cross it there
            if (part <= spare && (place(c[1]) - place(c[0])).cross(place(c[2]) - place(c[0])).dot(way) >= 0) continue;
            if (found && part == first_t) continue;
            found = true;
            first_t = part;
            best.facet = facet_[static_cast<std::size_t>(t)];
            best.weight = crossing.weight;
        }
    }
    if (!found) return {};
    best.position_m = at(best.facet, best.weight);
    best.distance_m = (best.position_m - to).norm();
    return best;
}

/// A triangle against which others are tested, with its normal.
struct MovingTriangles::Plane {
    const Corners& nodes;
    Eigen::Vector3d corner[3], normal;
};

/// Whether two triangles intersect in more than the nodes that they share. Two triangles in one plane that share at
/// most one node do not count: either a third triangle crosses one of them, or they lie side by side as at rest.
bool MovingTriangles::meet(const Plane& a, int triangle) const noexcept {
    const Corners& nodes = corners_[static_cast<std::size_t>(triangle)];
    const Eigen::Vector3d b[3] = {place(nodes[0]), place(nodes[1]), place(nodes[2])};
    int shared = 0;
    bool in_a[3], in_b[3] = {};
    for (std::size_t i = 0; i < 3; ++i) {
        in_a[i] = false;
        for (std::size_t j = 0; j < 3; ++j) {
            const bool same = a.nodes[i] == nodes[j];
            in_a[i] |= same;
            in_b[j] |= same;
            shared += same;
        }
    }
    if (shared >= 2) {
        const Eigen::Vector3d normal = (b[1] - b[0]).cross(b[2] - b[0]);
        const double cosine = a.normal.dot(normal);
        if (cosine > 0) return false;
        return !(cosine > (folded - 1) * std::sqrt(a.normal.squaredNorm() * normal.squaredNorm()));
    }
    // shared corners lie in both planes exactly, without rounding
    const auto parted = [](const Eigen::Vector3d& normal, const Eigen::Vector3d& on, const Eigen::Vector3d (&corner)[3], const bool (&on_it)[3],
                           double (&side)[3]) {
        for (int k = 0; k < 3; ++k) side[k] = on_it[k] ? 0 : normal.dot(corner[k] - on);
        return std::max({side[0], side[1], side[2]}) > 0 && std::min({side[0], side[1], side[2]}) < 0;
    };
    double side_b[3], side_a[3];
    if (!parted(a.normal, a.corner[0], b, in_b, side_b)) return false;
    const Eigen::Vector3d normal = (b[1] - b[0]).cross(b[2] - b[0]);
    if (!parted(normal, b[0], a.corner, in_a, side_a)) return false;
    // an edge of one triangle goes through the other, or through one of its edges
    const auto pierces = [](const Eigen::Vector3d (&edge_of)[3], const double (&side)[3], const Eigen::Vector3d (&through)[3],
                            const Eigen::Vector3d& across) {
        for (int k = 0; k < 3; ++k) {
            const int l = (k + 1) % 3;
            if (!((side[k] > 0 && side[l] < 0) || (side[k] < 0 && side[l] > 0))) continue;
            const Eigen::Vector3d x = edge_of[k] + side[k] / (side[k] - side[l]) * (edge_of[l] - edge_of[k]);
            bool in = true;
            for (int e = 0; e < 3 && in; ++e) in = (through[(e + 1) % 3] - through[e]).cross(x - through[e]).dot(across) >= -on_edge * across.squaredNorm();
            if (in) return true;
        }
        return false;
    };
    return pierces(a.corner, side_a, b, normal) || pierces(b, side_b, a.corner, a.normal);
}

/// Whether a triangle intersects one with a larger number. So each pair is checked once, at its earlier triangle.
bool MovingTriangles::meets_a_later_one(int triangle) const noexcept {
    const Corners& c = corners_[static_cast<std::size_t>(triangle)];
    Plane own{c, {place(c[0]), place(c[1]), place(c[2])}, {}};
    own.normal = (own.corner[1] - own.corner[0]).cross(own.corner[2] - own.corner[0]);
    const Eigen::Vector3d low = own.corner[0].cwiseMin(own.corner[1]).cwiseMin(own.corner[2]);
    const Eigen::Vector3d high = own.corner[0].cwiseMax(own.corner[1]).cwiseMax(own.corner[2]);
    struct Waiting {
        std::size_t box, leaves, end;  ///< leaves: their number in the box; end: the index after the last one
    } stack[deepest];
    stack[0] = {1, leaves_, leaves_};
    int waiting = 1;
    while (waiting > 0) {
        const Waiting next = stack[--waiting];
        if (first_of(next.end) <= triangle + 1) continue;
        const Box& box = boxes_[next.box];
        if (!((box.low[0] <= high[0]) & (box.high[0] >= low[0]) & (box.low[1] <= high[1]) & (box.high[1] >= low[1]) & (box.low[2] <= high[2]) &
              (box.high[2] >= low[2])))
            continue;
        if (next.box < leaves_) {
            const std::size_t half = next.leaves / 2;
            stack[waiting++] = {2 * next.box, half, next.end - half};
            stack[waiting++] = {2 * next.box + 1, half, next.end};
            continue;
        }
        for (int t = std::max(triangle + 1, first_of(next.end - 1)); t < first_of(next.end); ++t)
            if (meet(own, t)) return true;
    }
    return false;
}

/// Checks a triangle and updates the count of those that intersect a later one.
void MovingTriangles::look_at(int triangle) noexcept {
    const bool crossed = meets_a_later_one(triangle);
    char& known = crossed_[static_cast<std::size_t>(triangle)];
    crossings_ += static_cast<int>(crossed) - known;
    known = static_cast<char>(crossed);
}

bool MovingTriangles::simple() noexcept {
    for (int i = 0; i < looked_at_; ++i) {
        look_at(next_);
        if (++next_ == triangles()) next_ = 0;
    }
    const double volume = kernel::six_volumes(triangles(), corner_[0].data(), corner_[1].data(), corner_[2].data(), x_.data());
    return volume > 0 && crossings_ == 0;
}

}  // namespace tissue
