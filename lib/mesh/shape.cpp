#include "mesh/shape.h"

#include <Eigen/Dense>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <set>

#include "error.h"
#include "mesh/outline.h"
#include "mesh/solid_shape.h"

namespace tissue {
namespace {

using Edge = std::array<int, 2>;

constexpr int fixed_label = 1, free_label = 2, tissue_label = 10;  // the labels of fem/shape.idp

double cross(const Eigen::RowVector2d& a, const Eigen::RowVector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
}

double twice_area(const NodeField& nodes, int a, int b, int c) {
    return cross(nodes.row(b) - nodes.row(a), nodes.row(c) - nodes.row(a));
}

std::string at(const Eigen::RowVector2d& p) {
    return fmt::format("({:.6g}, {:.6g}) m", p.x(), p.y());
}

/// The boundary: edges of one triangle only, counter-clockwise. Result: next node of each boundary node.
std::map<int, int> boundary_of(const Shape& shape, const std::string& file) {
    std::map<Edge, int> sides;  // directed edge -> triangle to its left
    for (int t = 0; t < shape.simplices.rows(); ++t)
        for (int i = 0; i < 3; ++i) {
            const Edge edge{shape.simplices(t, i), shape.simplices(t, (i + 1) % 3)};
            if (!sides.emplace(edge, t).second)
                throw FileError(fmt::format("{}: two triangles overlap at the edge from {} to {}", file,
                                            at(shape.nodes.row(edge[0])), at(shape.nodes.row(edge[1]))));
        }
    std::map<int, int> next;
    for (const auto& [edge, t] : sides)
        if (!sides.count({edge[1], edge[0]}) && !next.emplace(edge[0], edge[1]).second)
            throw FileError(fmt::format("{}: the outline touches itself at {}", file, at(shape.nodes.row(edge[0]))));
    return next;
}

/// The boundary as one loop that starts at its lowest node number.
std::vector<int> loop_of(const Shape& shape, const std::string& file) {
    const std::map<int, int> next = boundary_of(shape, file);
    std::vector<int> loop;
    for (int node = next.begin()->first; loop.empty() || node != loop.front(); node = next.at(node)) loop.push_back(node);
    if (loop.size() != next.size()) {
        const std::set<int> on(loop.begin(), loop.end());
        const auto other = std::find_if(next.begin(), next.end(), [&](const auto& e) { return !on.count(e.first); });
        throw FileError(fmt::format("{}: the outline is not one closed loop: the tissue has a hole or a second part at {}",
                                    file, at(shape.nodes.row(other->first))));
    }
    return loop;
}

void refuse_crossings(const Shape& shape, const std::vector<int>& loop, const std::string& file) {
    const std::size_t n = loop.size();
    const auto point = [&](std::size_t i) -> Eigen::RowVector2d { return shape.nodes.row(loop[i % n]); };
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 2; j < n; ++j) {
            if (i == 0 && j + 1 == n) continue;
            const Eigen::RowVector2d a = point(i), b = point(i + 1), c = point(j), d = point(j + 1);
            if (cross(b - a, c - a) * cross(b - a, d - a) < 0 && cross(d - c, a - c) * cross(d - c, b - c) < 0)
                throw FileError(fmt::format("{}: the outline crosses itself between {} and {}", file, at(a), at(b)));
        }
}

}  // namespace

std::vector<int> group_tags(const std::vector<std::string>& wanted, const std::map<int, std::string>& names,
                            const std::string& what, const std::string& file) {
    std::vector<int> tags;
    for (const std::string& name : wanted) {
        const auto there = std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.second == name; });
        std::vector<std::string> known;
        for (const auto& [tag, n] : names) known.push_back(n);
        if (there == names.end())
            throw FileError(fmt::format("{}: has no physical {} '{}'; it has: {}", file, what, name,
                                        known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))));
        tags.push_back(there->first);
    }
    return tags;
}

std::vector<int> order_along(const NodeField& places) {
    const NodeField about = places.rowwise() - places.colwise().mean();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(about.transpose() * about);
    NodeField along = about * axes.eigenvectors().rowwise().reverse();  // the longest axis first
    for (Eigen::Index d = 0; d < along.cols(); ++d) {
        const Eigen::VectorXd axis = axes.eigenvectors().col(along.cols() - 1 - d);
        double sign = 0;
        for (Eigen::Index k = 0; k < axis.size(); ++k) sign += std::pow(1e-3, k) * axis[k];
        if (sign < 0) along.col(d) *= -1;
    }
    std::vector<int> order(static_cast<std::size_t>(places.rows()));
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
        return std::lexicographical_compare(along.row(a).begin(), along.row(a).end(), along.row(b).begin(), along.row(b).end());
    });
    return order;
}

Shape make_shape(const MshFile& mesh, const std::vector<std::string>& fixed, const std::vector<std::string>& regions,
                 double unit_m, ShapeNotes* notes) {
    const std::string& file = mesh.file;
    if (mesh.triangles.empty()) throw FileError(file + ": has no triangles: is its outline closed, and its surface in a physical group?");
    const std::vector<int> fixed_tags = group_tags(fixed, mesh.line_names, "curve", file),
                           region_tags = group_tags(regions, mesh.triangle_names, "surface", file);

    // an element is listed once for every group that it is in; a named region has priority
    std::map<std::array<int, 3>, std::size_t> seen;
    std::vector<MshFile::Element> triangles;
    std::vector<int> region;
    for (const MshFile::Element& e : mesh.triangles) {
        std::array<int, 3> key{e.node[0], e.node[1], e.node[2]};
        std::sort(key.begin(), key.end());
        const auto tag = std::find(region_tags.begin(), region_tags.end(), e.physical);
        const int r = tag == region_tags.end() ? 0 : static_cast<int>(tag - region_tags.begin()) + 1;
        const auto [there, fresh] = seen.emplace(key, triangles.size());
        if (fresh) {
            triangles.push_back(e);
            region.push_back(r);
        } else if (r > 0) {
            if (region[there->second] > 0 && region[there->second] != r)
                throw FileError(fmt::format("{}: element {} is in two of the study's regions", file, e.number));
            region[there->second] = r;
        }
    }

    // used nodes, numbered along the longest axis
    std::set<int> used;
    for (const MshFile::Element& e : triangles) used.insert(e.node, e.node + 3);
    std::vector<int> order(used.begin(), used.end());
    Eigen::MatrixX2d place(static_cast<Eigen::Index>(order.size()), 2);
    for (std::size_t i = 0; i < order.size(); ++i) {
        const MshFile::Point& p = mesh.points[static_cast<std::size_t>(order[i])];
        place.row(static_cast<Eigen::Index>(i)) << p.x * unit_m, p.y * unit_m;
    }
    const double size = (place.colwise().maxCoeff() - place.colwise().minCoeff()).maxCoeff();
    for (int i : order) {
        const MshFile::Point& p = mesh.points[static_cast<std::size_t>(i)];
        if (!(std::abs(p.z * unit_m) <= 1e-9 * size))
            throw FileError(fmt::format("{}: is not in the plane: a node at {} has z = {:.6g} m", file,
                                        at({p.x * unit_m, p.y * unit_m}), p.z * unit_m));
    }
    const Eigen::MatrixX2d about = place.rowwise() - place.colwise().mean();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(about.transpose() * about);
    Eigen::Vector2d axis = axes.eigenvectors().col(1);
    if (axis.x() + 1e-3 * axis.y() < 0) axis = -axis;
    const Eigen::VectorXd along = about * axis, across = about * Eigen::Vector2d(-axis.y(), axis.x());
    std::vector<int> sorted(order.size());
    std::iota(sorted.begin(), sorted.end(), 0);
    std::sort(sorted.begin(), sorted.end(), [&](int a, int b) {
        return std::pair(along[a], across[a]) < std::pair(along[b], across[b]);
    });
    Shape shape;
    shape.nodes.resize(static_cast<Eigen::Index>(order.size()), 2);
    std::map<int, int> number;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        shape.nodes.row(static_cast<Eigen::Index>(i)) = place.row(sorted[i]);
        number[order[static_cast<std::size_t>(sorted[i])]] = static_cast<int>(i);
    }

    ShapeNotes put_right;
    put_right.dropped = static_cast<int>(mesh.points.size() - used.size());
    shape.simplices.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    shape.region = region;
    double area = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const MshFile::Element& e = triangles[t];
        int a = number[e.node[0]], b = number[e.node[1]], c = number[e.node[2]];
        const double twice = twice_area(shape.nodes, a, b, c);
        const double longest = std::max({(shape.nodes.row(a) - shape.nodes.row(b)).norm(),
                                         (shape.nodes.row(b) - shape.nodes.row(c)).norm(),
                                         (shape.nodes.row(c) - shape.nodes.row(a)).norm()});
        if (!(std::abs(twice) > 1e-6 * longest * longest))
            throw FileError(fmt::format("{}: element {} at {} has no area", file, e.number, at(shape.nodes.row(a))));
        if (twice < 0) {
            std::swap(b, c);
            ++put_right.turned;
        }
        shape.simplices.row(static_cast<Eigen::Index>(t)) << a, b, c;
        area += std::abs(twice) / 2;
    }

    const std::vector<int> loop = loop_of(shape, file);
    refuse_crossings(shape, loop, file);
    double enclosed = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
        enclosed += cross(shape.nodes.row(loop[i]), shape.nodes.row(loop[(i + 1) % loop.size()])) / 2;
    if (!(std::abs(enclosed - area) <= 1e-9 * area))
        throw FileError(fmt::format("{}: the mesh overlaps itself: its triangles cover {:.6g} m2, its outline encloses {:.6g} m2",
                                    file, area, enclosed));

    std::set<Edge> fixed_edges_left;
    for (const MshFile::Element& e : mesh.lines)
        if (std::find(fixed_tags.begin(), fixed_tags.end(), e.physical) != fixed_tags.end()) {
            const auto a = number.find(e.node[0]), b = number.find(e.node[1]);
            if (a == number.end() || b == number.end())
                throw FileError(fmt::format("{}: element {} of a fixed curve belongs to no triangle", file, e.number));
            fixed_edges_left.insert({std::min(a->second, b->second), std::max(a->second, b->second)});
        }
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Edge edge{loop[i], loop[(i + 1) % loop.size()]};
        if (fixed_edges_left.erase({std::min(edge[0], edge[1]), std::max(edge[0], edge[1])})) shape.fixed_edges.push_back(edge);
    }
    if (!fixed_edges_left.empty())
        throw FileError(fmt::format("{}: the fixed curve at {} is not on the outline", file,
                                    at(shape.nodes.row((*fixed_edges_left.begin())[0]))));
    if (shape.fixed_edges.empty())
        throw FileError(fmt::format("{}: no part of the outline is in the fixed curves {}", file, fmt::join(fixed, ", ")));
    try {
        Outline outline(edge_mesh(shape));
    } catch (const MismatchError& e) {
        throw FileError(file + ": " + e.what());
    }
    if (notes) *notes = put_right;
    return shape;
}

std::string to_msh(const Shape& shape, const std::vector<std::string>& regions) {
    if (shape.is_solid()) return solid_to_msh(shape, regions);
    const std::vector<int> loop = loop_of(shape, "the shape");
    const std::set<Edge> fixed_edges_left(shape.fixed_edges.begin(), shape.fixed_edges.end());
    std::string text = fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n1 {} \"fixed\"\n1 {} \"free\"\n2 {} \"tissue\"\n",
                                   3 + regions.size(), fixed_label, free_label, tissue_label);
    for (std::size_t r = 0; r < regions.size(); ++r)
        text += fmt::format("2 {} \"{}\"\n", tissue_label + 1 + static_cast<int>(r), regions[r]);
    text += fmt::format("$EndPhysicalNames\n$Nodes\n{}\n", shape.nodes.rows());
    for (Eigen::Index i = 0; i < shape.nodes.rows(); ++i)
        text += fmt::format("{} {} {} 0\n", i + 1, shape.nodes(i, 0), shape.nodes(i, 1));
    text += fmt::format("$EndNodes\n$Elements\n{}\n", static_cast<Eigen::Index>(loop.size()) + shape.simplices.rows());
    int number = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Edge edge{loop[i], loop[(i + 1) % loop.size()]};
        const int label = fixed_edges_left.count(edge) ? fixed_label : free_label;
        text += fmt::format("{} 1 2 {} {} {} {}\n", ++number, label, label, edge[0] + 1, edge[1] + 1);
    }
    for (Eigen::Index t = 0; t < shape.simplices.rows(); ++t) {
        const int label = tissue_label + shape.region[static_cast<std::size_t>(t)];
        text += fmt::format("{} 2 2 {} {} {} {} {}\n", ++number, label, label, shape.simplices(t, 0) + 1,
                            shape.simplices(t, 1) + 1, shape.simplices(t, 2) + 1);
    }
    return text + "$EndElements\n";
}

Shape read_shape(const std::string& file) {
    const MshFile mesh = read_msh(file);
    Shape shape;
    shape.nodes.resize(static_cast<Eigen::Index>(mesh.points.size()), 2);
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
        shape.nodes.row(static_cast<Eigen::Index>(i)) << mesh.points[i].x, mesh.points[i].y;
    shape.simplices.resize(static_cast<Eigen::Index>(mesh.triangles.size()), 3);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const MshFile::Element& e = mesh.triangles[t];
        shape.simplices.row(static_cast<Eigen::Index>(t)) << e.node[0], e.node[1], e.node[2];
        shape.region.push_back(std::max(e.physical, tissue_label) - tissue_label);
        if (e.physical < tissue_label || twice_area(shape.nodes, e.node[0], e.node[1], e.node[2]) <= 0)
            throw FileError(file + ": is not a mesh of tissuectl shape");
    }
    for (const MshFile::Element& e : mesh.lines)
        if (e.physical == fixed_label) shape.fixed_edges.push_back({e.node[0], e.node[1]});
    if (mesh.triangles.empty() || shape.fixed_edges.empty())
        throw FileError(file + ": is not a mesh of tissuectl shape");
    return shape;
}

SpringMesh edge_mesh(const Shape& shape) {
    if (shape.is_solid()) return solid_edge_mesh(shape);
    SpringMesh mesh;
    mesh.topology = "edges";
    mesh.nodes = shape.nodes;
    mesh.simplices = shape.simplices;
    mesh.facets = loop_facets(loop_of(shape, "the shape"));
    std::set<int> fixed;
    for (const Edge& edge : shape.fixed_edges) fixed.insert(edge.begin(), edge.end());
    mesh.fixed.assign(fixed.begin(), fixed.end());
    std::map<Edge, double> area;  // sum of the triangles at each edge
    mesh.node_measure = Eigen::VectorXd::Zero(mesh.node_count());
    for (Eigen::Index t = 0; t < mesh.simplices.rows(); ++t) {
        const int a = mesh.simplices(t, 0), b = mesh.simplices(t, 1), c = mesh.simplices(t, 2);
        const double own = twice_area(mesh.nodes, a, b, c) / 2;
        for (const auto& [i, j] : {std::pair(a, b), {b, c}, {c, a}}) area[{std::min(i, j), std::max(i, j)}] += own;
        for (int corner : {a, b, c}) mesh.node_measure[corner] += own / 3;
    }
    mesh.springs.resize(static_cast<Eigen::Index>(area.size()), 2);
    mesh.incident_measure.resize(static_cast<Eigen::Index>(area.size()));
    Eigen::Index s = 0;
    for (const auto& [edge, sum] : area) {
        mesh.springs.row(s) << edge[0], edge[1];
        mesh.incident_measure[s++] = sum;
    }
    return mesh;
}

Shape shape_of(const SpringMesh& mesh) {
    if (mesh.is_solid()) return solid_shape_of(mesh);
    Shape shape{mesh.nodes, mesh.simplices, std::vector<int>(static_cast<std::size_t>(mesh.simplices.rows()), 0), {}};
    const auto is_fixed = [&](int node) { return std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), node); };
    for (Eigen::Index b = 0; b < mesh.facets.rows(); ++b) {
        const Edge edge{mesh.facets(b, 0), mesh.facets(b, 1)};
        if (is_fixed(edge[0]) && is_fixed(edge[1])) shape.fixed_edges.push_back(edge);
    }
    return shape;
}

}  // namespace tissue
