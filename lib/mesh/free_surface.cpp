#include "mesh/free_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "mesh/facet.h"

namespace tissue {
namespace {

constexpr double crease = 0.70710678118654752;  // cos 45: where it turns by less it is taken as curved
constexpr double same_side = 0.5;               // cos 60

Cells chosen(const Cells& facets, const std::vector<Eigen::Index>& rows) {
    Cells result(static_cast<Eigen::Index>(rows.size()), facets.cols());
    for (std::size_t r = 0; r < rows.size(); ++r) result.row(static_cast<Eigen::Index>(r)) = facets.row(rows[r]);
    return result;
}

}  // namespace

FreeSurface::FreeSurface(const SpringMesh& mesh) : rest_(mesh.nodes), around_(static_cast<std::size_t>(mesh.node_count())) {
    std::vector<Eigen::Index> free, held;
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        const auto row = mesh.facets.row(f);
        const bool all_held = std::all_of(row.begin(), row.end(), [&](int node) {
            return std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), node);
        });
        (all_held ? held : free).push_back(f);
    }
    facets_ = chosen(mesh.facets, free);
    held_facets_ = chosen(mesh.facets, held);
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
    // squares of a side h divide into two triangles of h^2 / 2
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
    place.point_m = place.inward = Point::Zero(rest_.cols());
    for (Eigen::Index k = 0; k < facets_.cols(); ++k) {
        const int node = facets_(place.facet, k);
        place.point_m += best.weight[k] * rest_.row(node).transpose();
        place.inward += best.weight[k] * node_inward(node, inward_[static_cast<std::size_t>(place.facet)]);
    }
    place.inward.normalize();
    return place;
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

std::vector<Point> FreeSurface::points(int parts) const {
    std::vector<Point> middles;
    for (Eigen::Index f = 0; f < facets_.rows(); ++f)
        for (int i = 0; i < parts; ++i)
            for (int j = 0; i + j < parts; ++j)
                for (const double third : {1.0 / 3, 2.0 / 3}) {  // of a part that points as its facet does, and of one that does not
                    const double a = (i + third) / parts, b = (j + third) / parts;
                    if (a + b < 1) middles.push_back(at(f, {1 - a - b, a, b}));
                }
    return middles;
}

double FreeSurface::to_crease_m(const Point& position_m) const {
    double least = std::numeric_limits<double>::infinity();
    for (int node : creases_) least = std::min(least, (rest_.row(node).transpose() - position_m).norm());
    return least;
}

bool FreeSurface::faces(int node, const Point& inward) const {
    Point sum = Point::Zero(rest_.cols());
    for (Eigen::Index f : around_[static_cast<std::size_t>(node)]) sum += measure_[f] * inward_[static_cast<std::size_t>(f)];
    return sum.normalized().dot(inward) >= same_side;
}

std::vector<int> seen_nodes(const SpringMesh& mesh) {
    if (mesh.is_solid()) return FreeSurface(mesh).nodes();
    std::vector<int> all(static_cast<std::size_t>(mesh.node_count()));
    std::iota(all.begin(), all.end(), 0);
    return all;
}

}  // namespace tissue
