#include "mesh/surface_remesh.h"
#include "mesh/nearest_triangle.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "error.h"
#include "mesh/facet.h"

namespace tissue {
namespace {

constexpr double longest = 4.0 / 3, shortest = 4.0 / 5;  // over the wanted length: split above, collapse below
constexpr double by_radius = 0.6;                        // wanted length over the radius of curvature
constexpr double growth = 0.3;                           // of the size limit per length along the surface
constexpr double same_way = 0.5;                         // least cosine between normals before and after an operation
constexpr double least_made = 0.3;                       // a collapse may lower the least quality down to this

std::string at_place(const Eigen::Vector3d& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", p.x(), p.y(), p.z()); }

}  // namespace

double SideLength::at(const Eigen::Vector3d& position_m) const {
    const double out = (position_m - centre_m).norm() - radius_m, over = thickness_m();
    if (out <= 0) return near_m;
    return out < over ? near_m + out / over * (far_m - near_m) : far_m;
}

SurfaceRemesh::SurfaceRemesh(const Surface& base, const SideLength& wanted, double crease) : base_(base), nearest_(base), wanted_(wanted) {
    const auto N = static_cast<std::size_t>(base.nodes.rows());
    for (std::size_t i = 0; i < N; ++i) place_.emplace_back(base.nodes.row(static_cast<Eigen::Index>(i)));
    pinned_.assign(N, 0);
    around_.resize(N);
    for (Eigen::Index t = 0; t < base.triangles.rows(); ++t) {
        triangles_.push_back({{base.triangles(t, 0), base.triangles(t, 1), base.triangles(t, 2)}, base.label[static_cast<std::size_t>(t)], true});
        for (int i = 0; i < 3; ++i) around(base.triangles(t, i)).push_back(static_cast<int>(t));
    }
    // ---- lines to keep; curvature at all other sides
    std::vector<double> turn(N, 0), sides_at(N, 0);
    std::vector<std::array<int, 2>> found, borders;  // borders: between labels
    const std::vector<std::array<int, 2>> all = sides();
    for (const auto& [a, b] : all) {
        const auto [left, right] = triangles_at(a, b);
        const double cosine = nearest_.normal(left).dot(nearest_.normal(right));
        const bool border = triangles_[static_cast<std::size_t>(left)].label != triangles_[static_cast<std::size_t>(right)].label;
        if (border) borders.push_back({a, b});
        if (border || cosine < crease) {
            lines_.insert(side(a, b));
            found.push_back({a, b});
            continue;
        }
        const auto middle = [&](int t) { return Eigen::Vector3d((at(corners(t)[0]) + at(corners(t)[1]) + at(corners(t)[2])) / 3); };
        const double way = (middle(left) - middle(right)).norm(), angle = std::acos(std::clamp(cosine, -1.0, 1.0));
        for (int node : {a, b}) {
            turn[static_cast<std::size_t>(node)] += angle / way;
            sides_at[static_cast<std::size_t>(node)] += 1;
        }
    }
    base_lines_.resize(static_cast<Eigen::Index>(found.size()), 2);
    for (std::size_t k = 0; k < found.size(); ++k) base_lines_.row(static_cast<Eigen::Index>(k)) << found[k][0], found[k][1];
    for (std::size_t i = 0; i < N; ++i)
        base_limit_m_.push_back(sides_at[i] > 0 && turn[i] > 0 ? std::max(wanted.near_m, by_radius * sides_at[i] / turn[i]) : wanted.far_m);
    limit_on_borders(borders);
    for (int sweep = 0; sweep < 30; ++sweep) {
        bool changed = false;
        for (const auto& [a, b] : all)
            for (const auto& [i, j] : {std::pair(a, b), std::pair(b, a)}) {
                const double most = base_limit_m_[static_cast<std::size_t>(i)] + growth * length(a, b);
                if (base_limit_m_[static_cast<std::size_t>(j)] > most * (1 + 1e-9)) {
                    base_limit_m_[static_cast<std::size_t>(j)] = most;
                    changed = true;
                }
            }
        if (!changed) break;
    }
    limit_m_ = base_limit_m_;
    pin_corners();
}

/// Limits the wanted length to 1/16 of the length of a border between labels. Otherwise small fixed parts would vanish.
void SurfaceRemesh::limit_on_borders(const std::vector<std::array<int, 2>>& lines) {
    constexpr double least_sides = 16;
    std::map<int, std::vector<int>> across;
    for (const auto& [a, b] : lines) {
        across[a].push_back(b);
        across[b].push_back(a);
    }
    std::set<int> seen;
    for (const auto& [first, others] : across) {
        if (!seen.insert(first).second) continue;
        std::vector<int> nodes{first};
        double length_m = 0;
        for (std::size_t k = 0; k < nodes.size(); ++k)
            for (int other : across.at(nodes[k])) {
                length_m += length(nodes[k], other) / 2;
                if (seen.insert(other).second) nodes.push_back(other);
            }
        for (int node : nodes) {
            double& limit_m = base_limit_m_[static_cast<std::size_t>(node)];
            limit_m = std::min(limit_m, length_m / least_sides);
        }
    }
}

/// Pins the nodes where lines end, meet or turn by more than 40 degrees.
void SurfaceRemesh::pin_corners() {
    for (int node = 0; node < static_cast<int>(place_.size()); ++node) {
        if (around(node).empty()) continue;
        std::vector<Eigen::Vector3d> way;
        for (int other : neighbours(node))
            if (is_line(node, other)) way.push_back((at(other) - at(node)).normalized());
        if (way.size() == 1 || way.size() > 2 || (way.size() == 2 && way[0].dot(way[1]) > -crease_cosine)) pinned_[static_cast<std::size_t>(node)] = 1;
    }
}

Eigen::Vector3d SurfaceRemesh::twice_area(int t) const {
    const auto& n = corners(t);
    return (at(n[1]) - at(n[0])).cross(at(n[2]) - at(n[0]));
}

double SurfaceRemesh::quality(int t) const { return triangle_quality(at(corners(t)[0]), at(corners(t)[1]), at(corners(t)[2])); }

double SurfaceRemesh::wanted(int a, int b) const {
    return std::min(wanted_.at((at(a) + at(b)) / 2), (limit_m_[static_cast<std::size_t>(a)] + limit_m_[static_cast<std::size_t>(b)]) / 2);
}

std::vector<int> SurfaceRemesh::neighbours(int node) const {
    std::vector<int> others;
    for (int t : around(node))
        for (int other : corners(t))
            if (other != node) others.push_back(other);
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    return others;
}

int SurfaceRemesh::lines_at(int node) const {
    int count = 0;
    for (int other : neighbours(node)) count += is_line(node, other);
    return count;
}

std::vector<std::array<int, 2>> SurfaceRemesh::sides() const {
    std::vector<std::array<int, 2>> all;
    for (const Triangle& t : triangles_)
        if (t.alive)
            for (int i = 0; i < 3; ++i)
                if (t.node[static_cast<std::size_t>(i)] < t.node[static_cast<std::size_t>((i + 1) % 3)])
                    all.push_back({t.node[static_cast<std::size_t>(i)], t.node[static_cast<std::size_t>((i + 1) % 3)]});
    return all;
}

std::array<int, 2> SurfaceRemesh::triangles_at(int a, int b) const {
    std::array<int, 2> found{-1, -1};
    for (int t : around(a)) {
        const auto& n = corners(t);
        for (std::size_t i = 0; i < 3; ++i) {
            if (n[i] == a && n[(i + 1) % 3] == b) found[0] = t;
            if (n[i] == b && n[(i + 1) % 3] == a) found[1] = t;
        }
    }
    return found;
}

int SurfaceRemesh::opposite(int t, int a, int b) const {
    for (int node : corners(t))
        if (node != a && node != b) return node;
    return -1;
}

Eigen::Vector3d SurfaceRemesh::outward(int node) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int t : around(node)) sum += twice_area(t);
    return sum.normalized();
}

Eigen::Vector3d SurfaceRemesh::projected(const Eigen::Vector3d& position_m, const Eigen::Vector3d& outward, bool on_line, bool on_rim,
                                         double* limit_m) const {
    const auto on_surface = [&](const Eigen::Vector3d& p) {
        NearestTriangle::Place place = nearest_.nearest(p, outward);
        if (place.triangle < 0) place = nearest_.nearest(p);
        if (limit_m) {
            *limit_m = 0;
            for (int i = 0; i < 3; ++i) *limit_m += place.weight[i] * base_limit_m_[static_cast<std::size_t>(base_.triangles(place.triangle, i))];
        }
        return place.point_m;
    };
    if (on_rim) {
        const auto on_sphere = [&](const Eigen::Vector3d& p) { return Eigen::Vector3d(rim_centre_m_ + rim_radius_m_ * (p - rim_centre_m_).normalized()); };
        Eigen::Vector3d p = on_sphere(position_m);
        for (int k = 0; k < 4; ++k) p = on_sphere(on_surface(p));
        return p;
    }
    if (!on_line) return on_surface(position_m);
    FacetPoint best{std::numeric_limits<double>::infinity(), {}};
    Eigen::Index line = 0;
    for (Eigen::Index k = 0; k < base_lines_.rows(); ++k) {
        const FacetPoint here = nearest_on_facet(base_.nodes, base_lines_, k, position_m);
        if (here.distance_m < best.distance_m) {
            best = here;
            line = k;
        }
    }
    if (limit_m) *limit_m = best.weight[0] * base_limit_m_[static_cast<std::size_t>(base_lines_(line, 0))] + best.weight[1] * base_limit_m_[static_cast<std::size_t>(base_lines_(line, 1))];
    return best.weight[0] * base_.nodes.row(base_lines_(line, 0)).transpose() + best.weight[1] * base_.nodes.row(base_lines_(line, 1)).transpose();
}

int SurfaceRemesh::split(int a, int b, const Eigen::Vector3d& to_m, double limit_m) {
    const int m = static_cast<int>(place_.size());
    place_.push_back(to_m);
    limit_m_.push_back(limit_m);
    pinned_.push_back(0);
    around_.emplace_back();
    for (int t : triangles_at(a, b)) {
        Triangle other = triangles_[static_cast<std::size_t>(t)];
        const int c = opposite(t, a, b), made = static_cast<int>(triangles_.size());
        for (int& node : triangles_[static_cast<std::size_t>(t)].node)
            if (node == b) node = m;
        for (int& node : other.node)
            if (node == a) node = m;
        triangles_.push_back(other);
        std::vector<int>& at_b = around(b);
        *std::find(at_b.begin(), at_b.end(), t) = made;
        around(c).push_back(made);
        around(m).push_back(t);
        around(m).push_back(made);
    }
    for (auto* set : {&lines_, &rim_})
        if (set->erase(side(a, b)) > 0) {
            set->insert(side(a, m));
            set->insert(side(m, b));
        }
    return m;
}

bool SurfaceRemesh::collapse(int gone, int kept) {
    if (pinned_[static_cast<std::size_t>(gone)]) return false;
    const int lines = lines_at(gone);
    if (lines > 0 && (lines != 2 || !is_line(gone, kept))) return false;
    if (lines > 0 && lines_at(kept) > 0) {  // a rim must not become a crease, nor a crease the rim
        int rims = 0;
        for (int other : neighbours(gone)) rims += is_rim(gone, other);
        if (rims == 1) return false;
    }
    const std::vector<int> of_gone = neighbours(gone), of_kept = neighbours(kept);
    std::vector<int> common;
    std::set_intersection(of_gone.begin(), of_gone.end(), of_kept.begin(), of_kept.end(), std::back_inserter(common));
    if (common.size() != 2) return false;
    for (int c : common)
        if (around(c).size() <= 3) return false;
    double before = 1, after = 1;
    for (int t : around(gone)) {
        before = std::min(before, quality(t));
        const auto& n = corners(t);
        if (std::find(n.begin(), n.end(), kept) != n.end()) continue;
        std::array<int, 3> made = n;
        for (int& node : made)
            if (node == gone) node = kept;
        const Eigen::Vector3d normal = (at(made[1]) - at(made[0])).cross(at(made[2]) - at(made[0])), old = twice_area(t);
        if (!(normal.dot(old) > 0.8 * normal.norm() * old.norm())) return false;
        after = std::min(after, triangle_quality(at(made[0]), at(made[1]), at(made[2])));
    }
    if (after < std::min(before, least_made)) return false;
    for (int other : of_gone)
        if (other != kept && length(kept, other) > longest * wanted(kept, other)) return false;  // would be split again
    // ---- all checks passed: collapse
    for (int other : of_gone)
        for (auto* set : {&lines_, &rim_})
            if (set->erase(side(gone, other)) > 0 && other != kept) set->insert(side(kept, other));
    for (int t : around(gone)) {
        Triangle& triangle = triangles_[static_cast<std::size_t>(t)];
        if (std::find(triangle.node.begin(), triangle.node.end(), kept) != triangle.node.end()) {
            triangle.alive = false;
            for (int node : triangle.node)
                if (node != gone) around(node).erase(std::find(around(node).begin(), around(node).end(), t));
            continue;
        }
        for (int& node : triangle.node)
            if (node == gone) node = kept;
        around(kept).push_back(t);
    }
    around(gone).clear();
    return true;
}

bool SurfaceRemesh::flip(int a, int b) {
    if (is_line(a, b)) return false;
    const auto [left, right] = triangles_at(a, b);
    if (left < 0 || right < 0) return false;
    const int c = opposite(left, a, b), d = opposite(right, a, b);
    if (around(a).size() <= 3 || around(b).size() <= 3 || triangles_at(c, d)[0] >= 0) return false;
    const double before = std::min(quality(left), quality(right));
    const double after = std::min(triangle_quality(at(a), at(d), at(c)), triangle_quality(at(d), at(b), at(c)));
    if (after < before + 0.01) return false;
    const Eigen::Vector3d one = (at(d) - at(a)).cross(at(c) - at(a)), two = (at(b) - at(d)).cross(at(c) - at(d));
    for (int t : {left, right}) {
        const Eigen::Vector3d old = twice_area(t);
        // the normal of a flat triangle is meaningless
        if (quality(t) < 1e-3) continue;
        for (const Eigen::Vector3d& made : {one, two})
            if (!(made.dot(old) > crease_cosine * made.norm() * old.norm())) return false;
    }
    if (!(one.dot(two) > crease_cosine * one.norm() * two.norm())) return false;
    triangles_[static_cast<std::size_t>(left)].node = {a, d, c};
    triangles_[static_cast<std::size_t>(right)].node = {d, b, c};
    around(b).erase(std::find(around(b).begin(), around(b).end(), left));
    around(a).erase(std::find(around(a).begin(), around(a).end(), right));
    around(d).push_back(left);
    around(c).push_back(right);
    return true;
}

bool SurfaceRemesh::moves_well(int node, const Eigen::Vector3d& to_m) const {
    double before = 1, after = 1;
    for (int t : around(node)) {
        std::array<Eigen::Vector3d, 3> p;
        for (std::size_t i = 0; i < 3; ++i) p[i] = corners(t)[i] == node ? to_m : at(corners(t)[i]);
        const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]), old = twice_area(t);
        if (!(normal.dot(old) > same_way * normal.norm() * old.norm())) return false;
        before = std::min(before, quality(t));
        after = std::min(after, triangle_quality(p[0], p[1], p[2]));
    }
    return after >= std::min(before, 0.5);
}

void SurfaceRemesh::move(int node) {
    if (pinned_[static_cast<std::size_t>(node)] || around(node).empty()) return;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0;
    int lines = 0, rims = 0;
    const std::vector<int> others = neighbours(node);
    for (int other : others) lines += is_line(node, other), rims += is_rim(node, other);
    if (lines > 0) {
        for (int other : others)
            if (is_line(node, other)) sum += at(other), weights += 1;
    } else {
        for (int t : around(node)) {  // centroids weighted by area over squared wanted length
            const auto& n = corners(t);
            const Eigen::Vector3d middle = (at(n[0]) + at(n[1]) + at(n[2])) / 3;
            const double size = wanted_.at(middle), weight = twice_area(t).norm() / (size * size);
            sum += weight * middle;
            weights += weight;
        }
    }
    const Eigen::Vector3d normal = outward(node);
    Eigen::Vector3d way = sum / weights - at(node);
    if (lines == 0) way -= way.dot(normal) * normal;
    double limit = 0;
    for (const double part : {0.7, 0.2}) {
        const Eigen::Vector3d to = projected(at(node) + part * way, normal, lines > 0, rims > 0, &limit);
        if (!moves_well(node, to)) continue;
        place_[static_cast<std::size_t>(node)] = to;
        limit_m_[static_cast<std::size_t>(node)] = limit;
        return;
    }
}

void SurfaceRemesh::split_long() {
    for (int sweep = 0; sweep < 40; ++sweep) {
        std::vector<std::pair<double, std::array<int, 2>>> too_long;
        for (const auto& [a, b] : sides()) {
            const double ratio = length(a, b) / wanted(a, b);
            if (ratio > longest) too_long.push_back({-length(a, b), {a, b}});
        }
        if (too_long.empty()) return;
        std::sort(too_long.begin(), too_long.end());
        // longest first, down to half of the longest: flips may remove shorter sides before the next sweep
        for (const auto& [minus, ends] : too_long) {
            if (minus > 0.5 * too_long.front().first) break;
            const auto [a, b] = ends;
            const auto [left, right] = triangles_at(a, b);
            if (left < 0 || right < 0) continue;
            const Eigen::Vector3d middle = (at(a) + at(b)) / 2;
            double limit = 0;
            Eigen::Vector3d to = projected(middle, (twice_area(left).normalized() + twice_area(right).normalized()).normalized(), is_line(a, b), is_rim(a, b), &limit);
            bool well = true;
            for (int t : {left, right})
                for (int end : {a, b}) {
                    std::array<Eigen::Vector3d, 3> p;
                    for (std::size_t i = 0; i < 3; ++i) p[i] = corners(t)[i] == end ? to : at(corners(t)[i]);
                    const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]), old = twice_area(t);
                    well = well && normal.dot(old) > same_way * normal.norm() * old.norm();
                }
            split(a, b, well ? to : middle, limit);
        }
        flip_all();
    }
}

void SurfaceRemesh::collapse_short() {
    std::vector<std::pair<double, std::array<int, 2>>> too_short;
    for (const auto& [a, b] : sides())
        if (length(a, b) < shortest * wanted(a, b)) too_short.push_back({length(a, b), {a, b}});
    std::sort(too_short.begin(), too_short.end());
    for (const auto& [l, ends] : too_short) {
        const auto [a, b] = ends;
        if (triangles_at(a, b)[0] < 0 || !(length(a, b) < shortest * wanted(a, b))) continue;
        if (!collapse(a, b)) collapse(b, a);
    }
}

void SurfaceRemesh::flip_all() {
    for (int pass = 0; pass < 4; ++pass) {
        int flipped = 0;
        for (const auto& [a, b] : sides()) flipped += triangles_at(a, b)[0] >= 0 && flip(a, b);
        if (flipped == 0) return;
    }
}

void SurfaceRemesh::remesh(int rounds) {
    for (int round = 0; round < rounds; ++round) {
        split_long();
        collapse_short();
        flip_all();
        for (int pass = 0; pass < 2; ++pass)
            for (int node = 0; node < static_cast<int>(place_.size()); ++node) move(node);
        flip_all();
    }
}

int SurfaceRemesh::insert(const Eigen::Vector3d& position_m) {
    const NearestTriangle::Place place = NearestTriangle(surface()).nearest(position_m);
    // surface() omits dead triangles: find the triangle with that number among the living ones
    int t = -1, number = 0;
    for (int k = 0; k < static_cast<int>(triangles_.size()); ++k)
        if (triangles_[static_cast<std::size_t>(k)].alive && number++ == place.triangle) t = k;
    const std::array<int, 3> n = corners(t);
    int most = 0, least = 0;
    for (int i = 1; i < 3; ++i) {
        if (place.weight[i] > place.weight[most]) most = i;
        if (place.weight[i] < place.weight[least]) least = i;
    }
    double limit = 0;
    for (int i = 0; i < 3; ++i) limit += place.weight[i] * limit_m_[static_cast<std::size_t>(n[static_cast<std::size_t>(i)])];
    int made = n[static_cast<std::size_t>(most)];
    if (lines_at(made) == 0 && moves_well(made, position_m)) {
        place_[static_cast<std::size_t>(made)] = position_m;
    } else if (place.weight[most] < 0.999) {
        const int a = n[static_cast<std::size_t>(most)], c = n[static_cast<std::size_t>(least)], b = n[static_cast<std::size_t>(3 - most - least)];
        // split the side of the two nearest nodes; a position off this side then splits the new side to the third node
        made = split(a, b, place.weight[least] < 1e-3 ? position_m : Eigen::Vector3d((at(a) + at(b)) / 2), limit);
        if (place.weight[least] >= 1e-3) made = split(made, c, position_m, limit);
    }
    pinned_[static_cast<std::size_t>(made)] = 1;
    return made;
}

void SurfaceRemesh::cut(int centre, double radius_m) {
    rim_centre_m_ = at(centre);
    rim_radius_m_ = radius_m;
    const auto off = [&](int node) {
        const double d = (at(node) - rim_centre_m_).norm() - radius_m;
        return std::abs(d) < 1e-6 * radius_m ? 0.0 : d;
    };
    std::vector<char> inside(place_.size(), 0);
    std::vector<int> next{centre};
    inside[static_cast<std::size_t>(centre)] = 1;
    while (!next.empty()) {
        const int node = next.back();
        next.pop_back();
        for (int t : around(node))
            if (Surface::is_fixed(triangles_[static_cast<std::size_t>(t)].label))
                throw MismatchError(fmt::format("the disc of radius {:.6g} m about {} overlaps a fixed part at {}", radius_m, at_place(rim_centre_m_), at_place(at(node))));
        for (int other : neighbours(node))
            if (!inside[static_cast<std::size_t>(other)] && off(other) < 0) {
                inside[static_cast<std::size_t>(other)] = 1;
                next.push_back(other);
            }
    }
    for (const auto& [a, b] : sides()) {
        if (inside[static_cast<std::size_t>(a)] == inside[static_cast<std::size_t>(b)]) continue;
        const int in = inside[static_cast<std::size_t>(a)] ? a : b, out = in == a ? b : a;
        if (off(out) <= 0) continue;  // on the rim
        // |in + w (out - in) - centre| = R
        const Eigen::Vector3d along = at(out) - at(in), from = at(in) - rim_centre_m_;
        const double A = along.squaredNorm(), B = from.dot(along), C = from.squaredNorm() - radius_m * radius_m;
        const double w = (-B + std::sqrt(std::max(0.0, B * B - A * C))) / A;
        const double limit = (1 - w) * limit_m_[static_cast<std::size_t>(in)] + w * limit_m_[static_cast<std::size_t>(out)];
        split(in, out, at(in) + w * along, limit);
        inside.push_back(0);
    }
    // the splits divided all triangles at the rim, so a triangle with a node inside is inside
    for (Triangle& t : triangles_) {
        if (!t.alive) continue;
        for (int node : t.node)
            if (inside[static_cast<std::size_t>(node)]) t.label = Surface::disc_label;
    }
    for (const auto& [a, b] : sides()) {
        const auto [left, right] = triangles_at(a, b);
        if ((triangles_[static_cast<std::size_t>(left)].label == Surface::disc_label) == (triangles_[static_cast<std::size_t>(right)].label == Surface::disc_label)) continue;
        lines_.insert(side(a, b));
        rim_.insert(side(a, b));
    }
    if (rim_.empty()) throw MismatchError(fmt::format("the disc of radius {:.6g} m about {} covers the whole surface", radius_m, at_place(rim_centre_m_)));
    // ---- one patch with one rim: each rim node has two rim sides, and N - E + T = 1
    std::map<int, int> ends;
    for (Side s : rim_) ++ends[static_cast<int>(s >> 32)], ++ends[static_cast<int>(s & 0xffffffff)];
    std::unordered_set<int> disc_nodes;
    std::unordered_set<Side> disc_sides;
    int disc_triangles = 0;
    for (const Triangle& t : triangles_) {
        if (!t.alive || t.label != Surface::disc_label) continue;
        ++disc_triangles;
        for (std::size_t i = 0; i < 3; ++i) {
            disc_nodes.insert(t.node[i]);
            disc_sides.insert(side(t.node[i], t.node[(i + 1) % 3]));
        }
    }
    const bool looped = std::all_of(ends.begin(), ends.end(), [](const auto& e) { return e.second == 2; });
    if (!looped || static_cast<long>(disc_nodes.size()) - static_cast<long>(disc_sides.size()) + disc_triangles != 1)
        throw MismatchError(fmt::format("the disc of radius {:.6g} m about {} has more than one rim: the surface is too narrow there", radius_m, at_place(rim_centre_m_)));
    pin_corners();
}

Surface SurfaceRemesh::surface() const {
    Surface s;
    std::vector<int> number(place_.size(), -1);
    int nodes = 0, count = 0;
    for (const Triangle& t : triangles_)
        if (t.alive) {
            ++count;
            for (int node : t.node)
                if (number[static_cast<std::size_t>(node)] < 0) number[static_cast<std::size_t>(node)] = nodes++;
        }
    s.nodes.resize(nodes, 3);
    for (std::size_t i = 0; i < place_.size(); ++i)
        if (number[i] >= 0) s.nodes.row(number[i]) = place_[i].transpose();
    s.triangles.resize(count, 3);
    for (const Triangle& t : triangles_)
        if (t.alive) {
            const auto row = static_cast<Eigen::Index>(s.label.size());
            for (int i = 0; i < 3; ++i) s.triangles(row, i) = number[static_cast<std::size_t>(t.node[static_cast<std::size_t>(i)])];
            s.label.push_back(t.label);
        }
    return s;
}

}  // namespace tissue
