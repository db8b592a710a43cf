#include "springs/rest_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "error.h"
#include "mesh/facet.h"
#include "mesh/topology.h"

namespace tissue {

RestPlaces::RestPlaces(const SpringMesh& mesh) : mesh_(mesh) {
    const FreeSurface surface(mesh);
    free_ = surface.facets();
    fixed_ = surface.fixed_facets_of_surface();
    spacing_m_ = surface.spacing_m();
    const Eigen::VectorXd low = mesh.own_nodes().colwise().minCoeff().transpose(), high = mesh.own_nodes().colwise().maxCoeff().transpose();
    centre_m_ = (low + high) / 2;
    half_size_m_ = (high - low) / 2;
}

RestPlaces::Nearest RestPlaces::nearest(const Cells& facets, const Point& point) const {
    const Eigen::Index D = mesh_.dimension();
    Nearest result{std::numeric_limits<double>::infinity(), Eigen::MatrixXd::Zero(D, D)};
    int equal = 0;
    const double same = 1e-6 * spacing_m_;
    for (Eigen::Index f = 0; f < facets.rows(); ++f) {
        const double distance = nearest_on_facet(mesh_.nodes, facets, f, point).distance_m;
        if (distance > result.distance_m + same) continue;
        if (distance < result.distance_m - same) {
            equal = 0;
            result.along.setZero();
        }
        result.distance_m = std::min(distance, result.distance_m);
        const Point normal = facet_normal(mesh_.nodes, facets, f);
        result.along += Eigen::MatrixXd::Identity(D, D) - normal * normal.transpose();
        ++equal;
    }
    if (equal > 0) result.along /= equal;
    return result;
}

const std::vector<RestPlaces::Nearest>& RestPlaces::nearest_free(const Cells& nodes) const {
    std::vector<Nearest>& list = known_[nodes.cols()];
    if (list.size() != static_cast<std::size_t>(nodes.rows())) {
        list.clear();
        for (Eigen::Index e = 0; e < nodes.rows(); ++e) list.push_back(nearest(free_, middle(nodes, e)));
    }
    return list;
}

Point RestPlaces::middle(const Cells& nodes, Eigen::Index e) const {
    Point sum = Point::Zero(mesh_.dimension());
    for (Eigen::Index k = 0; k < nodes.cols(); ++k) sum += mesh_.nodes.row(nodes(e, k)).transpose();
    return sum / static_cast<double>(nodes.cols());
}

double RestPlaces::squared_cosine(const Cells& nodes, Eigen::Index e, const Eigen::MatrixXd& projector) const {
    const Point axis = (mesh_.nodes.row(nodes(e, 1)) - mesh_.nodes.row(nodes(e, 0))).transpose().normalized();
    return axis.dot(projector * axis);
}

int RestPlaces::axes_of(const Cells& nodes, Eigen::Index e, int& first) const {
    const Point span = (mesh_.nodes.row(nodes(e, 1)) - mesh_.nodes.row(nodes(e, 0))).transpose().cwiseAbs();
    int count = 0;
    for (Eigen::Index d = span.size() - 1; d >= 0; --d)
        if (span[d] > 1e-9 * span.norm()) {
            ++count;
            first = static_cast<int>(d);
        }
    return count;
}

Eigen::VectorXd RestPlaces::factor(const std::string& name, const Cells& nodes) const {
    const Eigen::Index count = nodes.rows();
    const bool springs = nodes.cols() == 2, cells = has_cells(mesh_);
    // the nodes of its lattice are neither on the surface nor fixed
    const bool solid = mesh_.is_solid();
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
    if (name == "surface" && !solid)
        return each([&](Eigen::Index e) {
            for (Eigen::Index f = 0; f < free_.rows(); ++f) {
                Eigen::Index shared = 0;
                for (int node : free_.row(f)) shared += has(e, node);
                if (shared >= std::min(nodes.cols(), free_.cols())) return 1.0;
            }
            return 0.0;
        });
    if (name == "layer") return each([&](Eigen::Index e) { return std::exp(-nearest_free(nodes)[static_cast<std::size_t>(e)].distance_m / spacing_m_); });
    if (name == "held" && !solid)
        return each([&](Eigen::Index e) {
            Eigen::Index fixed_count = 0;
            for (Eigen::Index k = 0; k < nodes.cols(); ++k)
                fixed_count += std::binary_search(mesh_.fixed.begin(), mesh_.fixed.end(), nodes(e, k));
            return fixed_count > 0 && fixed_count < nodes.cols() ? 1.0 : 0.0;
        });
    const int up = mesh_.dimension() - 1;
    if (name[0] >= 'x' && name[0] <= 'x' + up && name.size() <= 2) {
        const int axis = name[0] - 'x', power = name.size() == 1 ? 1 : name[1] - '0';
        // odd powers of a horizontal axis would break a tissue's mirror symmetry
        const bool even = power == 2 || power == 4;
        if (even || (axis == up && (power == 1 || power == 3)))
            return each([&](Eigen::Index e) { return std::pow(scaled(e, axis), power); });
    }
    // Layers of a solid: from its highest and its lowest point, and from its side walls, which are neither.
    const auto height_m = [&](Eigen::Index e) { return middle(nodes, e)[up] - (centre_m_[up] - half_size_m_[up]); };
    if (solid && name == "top")
        return each([&](Eigen::Index e) { return std::exp(-(2 * half_size_m_[up] - height_m(e)) / spacing_m_); });
    if (solid && name == "bottom") return each([&](Eigen::Index e) { return std::exp(-height_m(e) / spacing_m_); });
    if (solid && name == "wall" && is_box(mesh_))
        return each([&](Eigen::Index e) {
            double least = std::numeric_limits<double>::infinity();
            for (int d = 0; d < up; ++d) least = std::min(least, half_size_m_[d] - std::abs(middle(nodes, e)[d] - centre_m_[d]));
            return std::exp(-least / spacing_m_);
        });
    if (springs) {
        if (name == "along") return each([&](Eigen::Index e) { return squared_cosine(nodes, e, nearest_free(nodes)[static_cast<std::size_t>(e)].along); });
        if (name == "across")
            return each([&](Eigen::Index e) { return 1 - squared_cosine(nodes, e, nearest_free(nodes)[static_cast<std::size_t>(e)].along); });
        if (name == "upright")
            return each([&](Eigen::Index e) { return 1 - squared_cosine(nodes, e, nearest(fixed_, middle(nodes, e)).along); });
        const bool diagonals = solid ? name == "face" || name == "body" : name == "diagonal";
        if (cells && (name == "horizontal" || name == "vertical" || diagonals))
            return each([&](Eigen::Index e) {
                int axis = 0;
                const int axes = axes_of(nodes, e, axis);
                const char* family = axes == 3 ? "body" : axes == 2 ? (up == 2 ? "face" : "diagonal") : axis == up ? "vertical" : "horizontal";
                return name == family ? 1.0 : 0.0;
            });
    }
    throw MismatchError(fmt::format("factor '{}' is not possible here; allowed: all, layer, {}{}{}{}{}", name, solid ? "" : "surface, held, ",
                                    up < 2 ? "" : is_box(mesh_) ? "top, bottom, wall, nodule, " : "top, bottom, nodule, ",
                                    up == 2 ? "x2, x4, y2, y4, z, z2, z3, z4" : "x2, x4, y, y2, y3, y4",
                                    springs ? ", along, across, upright" : "",
                                    !springs || !cells ? "" : up == 2 ? ", horizontal, vertical, face, body" : ", horizontal, vertical, diagonal"));
}

}  // namespace tissue
