#include "springs/rest_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "error.h"
#include "mesh/topology.h"

namespace tissue {

RestPlaces::RestPlaces(const SpringMesh& mesh) : mesh_(mesh) {
    const Outline outline(mesh);
    const auto add = [&](std::vector<Segment>& list, int i, int j) {
        const Eigen::Vector2d from = mesh.nodes.row(i), to = mesh.nodes.row(j);
        list.push_back({{i, j}, from, to - from});
    };
    for (std::size_t i = 0; i + 1 < outline.nodes().size(); ++i) add(free_, outline.nodes()[i], outline.nodes()[i + 1]);
    const auto is_held = [&](int node) { return std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), node); };
    for (std::size_t b = 0; b < mesh.boundary.size(); ++b) {
        const int i = mesh.boundary[b], j = mesh.boundary[(b + 1) % mesh.boundary.size()];
        if (is_held(i) && is_held(j)) add(held_, i, j);
    }
    spacing_m_ = outline.length() / static_cast<double>(free_.size());
    const Eigen::Vector2d low = mesh.nodes.colwise().minCoeff(), high = mesh.nodes.colwise().maxCoeff();
    centre_m_ = (low + high) / 2;
    half_size_m_ = (high - low) / 2;
}

RestPlaces::Nearest RestPlaces::nearest(const std::vector<Segment>& segments, const Eigen::Vector2d& point) {
    Nearest result{std::numeric_limits<double>::infinity(), Eigen::Matrix2d::Zero()};
    int equal = 0;
    for (const Segment& s : segments) {
        const double w = std::clamp((point - s.from).dot(s.along) / s.along.squaredNorm(), 0.0, 1.0);
        const double distance = (point - s.from - w * s.along).norm();
        if (distance > result.distance_m + 1e-6 * s.along.norm()) continue;
        if (distance < result.distance_m - 1e-6 * s.along.norm()) {
            equal = 0;
            result.direction.setZero();
        }
        result.distance_m = std::min(distance, result.distance_m);
        result.direction += s.along * s.along.transpose() / s.along.squaredNorm();
        ++equal;
    }
    if (equal > 0) result.direction /= equal;
    return result;
}

Eigen::Vector2d RestPlaces::middle(const Cells& nodes, Eigen::Index e) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (Eigen::Index k = 0; k < nodes.cols(); ++k) sum += mesh_.nodes.row(nodes(e, k));
    return sum / static_cast<double>(nodes.cols());
}

double RestPlaces::squared_cosine(const Cells& nodes, Eigen::Index e, const Eigen::Matrix2d& direction) const {
    const Eigen::Vector2d axis = (mesh_.nodes.row(nodes(e, 1)) - mesh_.nodes.row(nodes(e, 0))).normalized();
    return axis.dot(direction * axis);
}

Eigen::VectorXd RestPlaces::factor(const std::string& name, const Cells& nodes) const {
    const Eigen::Index count = nodes.rows();
    const bool springs = nodes.cols() == 2, lattice = on_lattice(mesh_);
    Eigen::VectorXd value(count);
    const auto each = [&](const auto& at) {
        for (Eigen::Index e = 0; e < count; ++e) value[e] = at(e);
        return value;
    };
    const auto has = [&](Eigen::Index e, int node) {
        for (Eigen::Index k = 0; k < nodes.cols(); ++k)
            if (nodes(e, k) == node) return true;
        return false;
    };
    const auto scaled = [&](Eigen::Index e, int axis) { return (middle(nodes, e)[axis] - centre_m_[axis]) / half_size_m_[axis]; };

    if (name == "all") return Eigen::VectorXd::Ones(count);
    if (name == "surface")
        return each([&](Eigen::Index e) {
            return std::any_of(free_.begin(), free_.end(), [&](const Segment& s) {
                       return nodes.cols() == 1 ? has(e, s.node[0]) || has(e, s.node[1]) : has(e, s.node[0]) && has(e, s.node[1]);
                   }) ? 1.0 : 0.0;
        });
    if (name == "layer") return each([&](Eigen::Index e) { return std::exp(-nearest(free_, middle(nodes, e)).distance_m / spacing_m_); });
    if (name == "held")
        return each([&](Eigen::Index e) {
            Eigen::Index held = 0;
            for (Eigen::Index k = 0; k < nodes.cols(); ++k)
                held += std::binary_search(mesh_.fixed.begin(), mesh_.fixed.end(), nodes(e, k));
            return held > 0 && held < nodes.cols() ? 1.0 : 0.0;
        });
    if ((name[0] == 'x' || name[0] == 'y') && name.size() <= 2) {
        const int axis = name[0] - 'x', power = name.size() == 1 ? 1 : name[1] - '0';
        const bool even = power == 2 || power == 4;  // a tissue that mirrors itself about x must stay so
        if (even || (axis == 1 && (power == 1 || power == 3)))
            return each([&](Eigen::Index e) { return std::pow(scaled(e, axis), power); });
    }
    if (springs) {
        if (name == "along") return each([&](Eigen::Index e) { return squared_cosine(nodes, e, nearest(free_, middle(nodes, e)).direction); });
        if (name == "across")
            return each([&](Eigen::Index e) { return 1 - squared_cosine(nodes, e, nearest(free_, middle(nodes, e)).direction); });
        if (name == "upright")
            return each([&](Eigen::Index e) { return 1 - squared_cosine(nodes, e, nearest(held_, middle(nodes, e)).direction); });
        if (lattice && (name == "horizontal" || name == "vertical" || name == "diagonal"))
            return each([&](Eigen::Index e) {
                const Eigen::RowVector2d span = (mesh_.nodes.row(nodes(e, 1)) - mesh_.nodes.row(nodes(e, 0))).cwiseAbs();
                const double small = 1e-9 * span.norm();
                const char* family = span[1] < small ? "horizontal" : span[0] < small ? "vertical" : "diagonal";
                return name == family ? 1.0 : 0.0;
            });
    }
    throw MismatchError(fmt::format("factor '{}' is not possible here; allowed: all, surface, layer, held, x2, x4, y, y2, y3, y4{}{}", name,
                                    springs ? ", along, across, upright" : "",
                                    springs && lattice ? ", horizontal, vertical, diagonal" : ""));
}

}  // namespace tissue
