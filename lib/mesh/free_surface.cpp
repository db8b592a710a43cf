#include "mesh/free_surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "mesh/facet.h"

namespace tissue {
namespace {

constexpr double crease = 0.70710678118654752;  // cos 45: the surface counts as curved where it turns by less
constexpr double same_side = 0.5;               // cos 60

Cells chosen(const Cells& facets, const std::vector<Eigen::Index>& rows) {
    Cells result(static_cast<Eigen::Index>(rows.size()), facets.cols());
    for (std::size_t r = 0; r < rows.size(); ++r) result.row(static_cast<Eigen::Index>(r)) = facets.row(rows[r]);
    return result;
}

}  // namespace

FreeSurface::FreeSurface(const SpringMesh& mesh) : rest_(mesh.nodes), around_(static_cast<std::size_t>(mesh.node_count())) {
    std::vector<Eigen::Index> free, fixed;
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        const auto row = mesh.facets.row(f);
        const bool all_fixed = std::all_of(row.begin(), row.end(), [&](int node) {
            return std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), node);
        });
        free_of_.push_back(all_fixed ? -1 : static_cast<Eigen::Index>(free.size()));
        (all_fixed ? fixed : free).push_back(f);
    }
    facet_of_ = free;
    facets_ = chosen(mesh.facets, free);
    fixed_facets_of_surface_ = chosen(mesh.facets, fixed);
    measure_.resize(facets_.rows());
    for (Eigen::Index f = 0; f < facets_.rows(); ++f) {
        measure_[f] = facet_measure(rest_, facets_, f);
        inward_.push_back(-facet_normal(rest_, facets_, f));
        for (int node : facets_.row(f)) around_[static_cast<std::size_t>(node)].push_back(f);
    }
    if (mesh.is_solid()) {
        std::map<std::array<int, 2>, std::vector<Eigen::Index>> sides;
        for (Eigen::Index f = 0; f < facets_.rows(); ++f)
            for (int k = 0; k < 3; ++k) {
                const auto [low, high] = std::minmax(facets_(f, k), facets_(f, (k + 1) % 3));
                sides[{low, high}].push_back(f);
            }
        std::vector<std::array<int, 2>> ends;
        for (const auto& [edge, on] : sides)
            if (on.size() != 2 || inward_[static_cast<std::size_t>(on[0])].dot(inward_[static_cast<std::size_t>(on[1])]) < crease) ends.push_back(edge);
        ends_.resize(static_cast<Eigen::Index>(ends.size()), 2);
        for (std::size_t e = 0; e < ends.size(); ++e) ends_.row(static_cast<Eigen::Index>(e)) << ends[e][0], ends[e][1];
    }
    // a square of side h has two triangles of area h^2 / 2
    spacing_m_ = mesh.is_solid() ? std::sqrt(2 * measure_.mean()) : measure_.mean();
    for (int node = 0; node < mesh.node_count(); ++node) {
        const std::vector<Eigen::Index>& here = around_[static_cast<std::size_t>(node)];
        if (here.empty()) continue;
        nodes_.push_back(node);
        bool turns = std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), node);
        for (Eigen::Index f : here)
            for (Eigen::Index g : here)
                turns |= inward_[static_cast<std::size_t>(f)].dot(inward_[static_cast<std::size_t>(g)]) < crease;
        if (turns) creases_.push_back(node);
    }
    for (const std::vector<Eigen::Index>& here : around_) {
        Point sum = Point::Zero(rest_.cols());
        for (Eigen::Index f : here) sum += measure_[f] * inward_[static_cast<std::size_t>(f)];
        facing_.push_back(sum.normalized());
    }
    for (Eigen::Index f = 0; f < facets_.rows(); ++f)
        for (int node : facets_.row(f)) corner_inward_.push_back(node_inward(node, inward_[static_cast<std::size_t>(f)]));
    join_facets();
}

/// Finds the neighbours of each free facet: across the ends of a segment or the edges of a triangle.
void FreeSurface::join_facets() {
    const Eigen::Index corners = facets_.cols();
    std::map<std::array<int, 2>, std::vector<Eigen::Index>> sides;  // free facets at each end or edge
    const auto side = [&](Eigen::Index f, Eigen::Index k) {
        const int from = facets_(f, k), to = corners == 2 ? from : facets_(f, (k + 1) % corners);
        return std::array<int, 2>{std::min(from, to), std::max(from, to)};
    };
    for (Eigen::Index f = 0; f < facets_.rows(); ++f)
        for (Eigen::Index k = 0; k < corners; ++k) sides[side(f, k)].push_back(f);
    for (Eigen::Index f = 0; f < facets_.rows(); ++f)
        for (Eigen::Index k = 0; k < corners; ++k) {
            const std::vector<Eigen::Index>& on = sides[side(f, k)];
            beside_.push_back(on.size() != 2 ? -1 : on[0] == f ? on[1] : on[0]);
        }
}

Point FreeSurface::node_inward(int node, const Point& facet_inward) const {
    Point sum = Point::Zero(rest_.cols());
    for (Eigen::Index f : around_[static_cast<std::size_t>(node)]) {
        const Point& inward = inward_[static_cast<std::size_t>(f)];
        if (inward.dot(facet_inward) >= crease) sum += measure_[f] * inward;
    }
    return sum.normalized();
}

FreeSurface::Place FreeSurface::nearest(const Point& position_m) const {
    Place place{0, {}, {}, std::numeric_limits<double>::infinity()};
    FacetPoint best{};
    for (Eigen::Index f = 0; f < facets_.rows(); ++f) {
        const FacetPoint here = nearest_on_facet(rest_, facets_, f, position_m);
        if (!(here.distance_m < place.distance_m)) continue;
        place.facet = f;
        place.distance_m = here.distance_m;
        best = here;
    }
    const double distance_m = place.distance_m;
    place = this->place(place.facet, best.weight);
    place.distance_m = distance_m;
    return place;
}

FreeSurface::Place FreeSurface::place(Eigen::Index facet, const Eigen::Vector3d& weight) const noexcept {
    Place place{facet, Point::Zero(rest_.cols()), Point::Zero(rest_.cols()), 0};
    for (Eigen::Index k = 0; k < facets_.cols(); ++k) {
        place.point_m += weight[k] * rest_.row(facets_(facet, k)).transpose();
        place.inward += weight[k] * corner_inward_[static_cast<std::size_t>(facets_.cols() * facet + k)];
    }
    place.inward.normalize();
    return place;
}

FreeSurface::Walk FreeSurface::walk(int facet, const Eigen::Vector3d& weight, const Point& along_m) const noexcept {
    constexpr int most_facets = 1000;
    constexpr double on_border = 1e-12;  // a smaller fraction of the path is rounding error
    Walk walk{facet, weight, along_m, 0, false};
    Eigen::Index f = free_of_[static_cast<std::size_t>(facet)];
    if (f < 0) {
        walk.at_border = true;
        return walk;
    }
    const Eigen::Index D = rest_.cols(), corners = facets_.cols();
    const auto in_space = [&](const auto& p) {
        Eigen::Vector3d v = Eigen::Vector3d::Zero();
        for (Eigen::Index axis = 0; axis < D; ++axis) v[axis] = p[axis];
        return v;
    };
    const auto corner = [&](Eigen::Index g, Eigen::Index k) { return in_space(rest_.row(facets_(g, k % corners))); };
    const auto inward = [&](Eigen::Index g) { return in_space(inward_[static_cast<std::size_t>(g)]); };
    Eigen::Vector3d way = in_space(along_m), w = weight;
    way -= way.dot(inward(f)) * inward(f);
    const double whole_m = way.norm();
    double left = 1;  // fraction of the path not walked yet
    for (int step = 0; step < most_facets && whole_m > 0 && left > on_border; ++step) {
        // change of the weights along the whole path
        Eigen::Vector3d change = Eigen::Vector3d::Zero();
        const Eigen::Vector3d a = corner(f, 1) - corner(f, 0);
        if (corners == 2) {
            change[1] = way.dot(a) / a.squaredNorm();
        } else {
            const Eigen::Vector3d b = corner(f, 2) - corner(f, 0);
            const double aa = a.dot(a), ab = a.dot(b), bb = b.dot(b), wa = way.dot(a), wb = way.dot(b), squared = aa * bb - ab * ab;
            change[1] = (bb * wa - ab * wb) / squared;
            change[2] = (aa * wb - ab * wa) / squared;
        }
        change[0] = -change[1] - change[2];
        double part = left;
        Eigen::Index out = -1;  // the node whose weight is first to reach 0
        for (Eigen::Index k = 0; k < corners; ++k)
            if (change[k] < 0 && w[k] < -change[k] * part) {
                part = std::max(0.0, w[k] / -change[k]);
                out = k;
            }
        w += part * change;
        w = w.cwiseMax(0.0);
        w /= w.sum();
        left -= part;
        if (out < 0) break;
        w[out] = 0;
        w /= w.sum();
        // cross the end or edge without that node
        const Eigen::Index side = (out + 1) % corners, next = beside_[static_cast<std::size_t>(corners * f + side)];
        if (next < 0) {
            walk.at_border = true;
            break;
        }
        Eigen::Vector3d w_next = Eigen::Vector3d::Zero(), edge = Eigen::Vector3d::Zero();
        Eigen::Index apart = 0;
        for (Eigen::Index k = 0; k < corners; ++k) {
            bool shared = false;
            for (Eigen::Index l = 0; l < corners; ++l)
                if (l != out && facets_(f, l) == facets_(next, k)) {
                    w_next[k] = w[l];
                    shared = true;
                }
            if (!shared) apart = k;
        }
        const Eigen::Vector3d hinge = corner(f, side);
        if (corners == 3) edge = (corner(f, side + 1) - hinge).normalized();
        const auto across = [&](const Eigen::Vector3d& to) {
            const Eigen::Vector3d ray = to - hinge;
            return Eigen::Vector3d((ray - ray.dot(edge) * edge).normalized());
        };
        const Eigen::Vector3d into = across(corner(next, apart)), from = -across(corner(f, out));
        way = way.dot(edge) * edge + way.dot(from) * into;
        f = next;
        w = w_next;
    }
    walk.facet = static_cast<int>(facet_of_[static_cast<std::size_t>(f)]);
    walk.weight = w;
    walk.along_m = way.head(D);
    walk.walked_m = (1 - std::max(left, 0.0)) * whole_m;
    return walk;
}

Point FreeSurface::at(Eigen::Index facet, const Eigen::Vector3d& weight) const {
    Point point = Point::Zero(rest_.cols());
    for (Eigen::Index k = 0; k < facets_.cols(); ++k) point += weight[k] * rest_.row(facets_(facet, k)).transpose();
    return point;
}

double FreeSurface::clearance_m(const Point& position_m) const {
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index e = 0; e < ends_.rows(); ++e) least = std::min(least, nearest_on_facet(rest_, ends_, e, position_m).distance_m);
    return least;
}

double FreeSurface::thickness_m(const Point& position_m, const Point& inward) const {
    constexpr double rounding = 1e-9;  // tolerance of weights, so that no ray passes between two facets
    double least = std::numeric_limits<double>::infinity();
    const Eigen::Vector3d from = position_m, along = inward;
    for (const Cells* facets : {&facets_, &fixed_facets_of_surface_})
        for (Eigen::Index f = 0; f < facets->rows(); ++f) {
            const Eigen::Vector3d a = rest_.row((*facets)(f, 0)), b = rest_.row((*facets)(f, 1)), c = rest_.row((*facets)(f, 2));
            Eigen::Matrix3d sides;  // from + t along = a + v (b - a) + w (c - a)
            sides << b - a, c - a, -along;
            const double determinant = sides.determinant();
            if (determinant > -1e-12 * (b - a).norm() * (c - a).norm()) continue;  // the ray enters here or is parallel
            const Eigen::Vector3d at = sides.inverse() * (from - a);
            if (at[0] >= -rounding && at[1] >= -rounding && at[0] + at[1] <= 1 + rounding && at[2] > 0) least = std::min(least, at[2]);
        }
    return least;
}

std::vector<Point> FreeSurface::points(int parts) const {
    std::vector<Point> middles;
    for (Eigen::Index f = 0; f < facets_.rows(); ++f)
        for (int i = 0; i < parts; ++i)
            for (int j = 0; i + j < parts; ++j)
                for (const double third : {1.0 / 3, 2.0 / 3}) {  // centroid of the upright or inverted triangle
                    const double a = (i + third) / parts, b = (j + third) / parts;
                    if (a + b < 1) middles.push_back(at(f, {1 - a - b, a, b}));
                }
    return middles;
}

double FreeSurface::to_crease_m(const Point& position_m) const noexcept {
    double least2 = std::numeric_limits<double>::infinity();
    for (int node : creases_) least2 = std::min(least2, (rest_.row(node).transpose() - position_m).squaredNorm());
    return std::sqrt(least2);
}

bool FreeSurface::faces(int node, const Point& inward) const noexcept {
    return facing_[static_cast<std::size_t>(node)].dot(inward) >= same_side;
}

std::vector<int> compared_nodes(const SpringMesh& mesh) {
    if (mesh.is_solid()) return FreeSurface(mesh).nodes();
    std::vector<int> all(static_cast<std::size_t>(mesh.node_count()));
    std::iota(all.begin(), all.end(), 0);
    return all;
}

}  // namespace tissue
