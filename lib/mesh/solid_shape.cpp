#include "mesh/solid_shape.h"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "error.h"
#include "mesh/fixed_region.h"
#include "mesh/open_faces.h"
#include "mesh/surface.h"

namespace tissue {
namespace {

using Edge = std::array<int, 2>;
using Face = std::array<int, 3>;

constexpr int tissue_label = 10;
// Least volume over the cube of the longest edge; 0.118 for a regular tetrahedron. Positions and forces are
// interpolated in a tetrahedron, so it may be thin but not flat. gmsh leaves some of 5e-4 between two triangles of a
// curved surface that it may not divide.
constexpr double sliver = 1e-4;

std::string at(const Eigen::RowVector3d& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", p.x(), p.y(), p.z()); }

double volume_of(const NodeField& nodes, const Cells& tetrahedra, Eigen::Index t) {
    const Eigen::RowVector3d a = nodes.row(tetrahedra(t, 0)), b = nodes.row(tetrahedra(t, 1)), c = nodes.row(tetrahedra(t, 2)),
                             d = nodes.row(tetrahedra(t, 3));
    return (b - a).cross(c - a).dot(d - a) / 6;
}

Face sorted(Face face) {
    std::sort(face.begin(), face.end());
    return face;
}

Face face_of(const Cells& facets, Eigen::Index f) { return {facets(f, 0), facets(f, 1), facets(f, 2)}; }

/// Refuses a face that two tetrahedra have with the same orientation.
void refuse_overlaps(const Shape& shape, const std::string& file) {
    std::set<Face> sides;
    for (Eigen::Index t = 0; t < shape.simplices.rows(); ++t)
        for (const auto& corner : tetrahedron_faces) {
            Face face{shape.simplices(t, corner[0]), shape.simplices(t, corner[1]), shape.simplices(t, corner[2])};
            std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
            if (!sides.insert(face).second)
                throw FileError(fmt::format("{}: two tetrahedra overlap at {}", file, at(shape.nodes.row(face[0]))));
        }
}

/// Checks that the surface is one closed surface, with two facets at every edge and without a hole through it (Euler:
/// corners - edges + facets = 2).
void check_surface(const Shape& shape, const Cells& facets, const std::string& file) {
    std::map<Edge, std::vector<Eigen::Index>> sides;
    std::set<int> corners;
    for (Eigen::Index f = 0; f < facets.rows(); ++f)
        for (int k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(facets(f, k), facets(f, (k + 1) % 3));
            sides[{low, high}].push_back(f);
            corners.insert(facets(f, k));
        }
    for (const auto& [edge, on] : sides)
        if (on.size() != 2)
            throw FileError(fmt::format("{}: the surface touches itself between {} and {}", file, at(shape.nodes.row(edge[0])),
                                        at(shape.nodes.row(edge[1]))));
    std::vector<std::vector<Eigen::Index>> beside(static_cast<std::size_t>(facets.rows()));
    for (const auto& [edge, on] : sides) {
        beside[static_cast<std::size_t>(on[0])].push_back(on[1]);
        beside[static_cast<std::size_t>(on[1])].push_back(on[0]);
    }
    std::vector<bool> seen(beside.size(), false);
    std::vector<Eigen::Index> open{0};
    seen[0] = true;
    while (!open.empty()) {
        const auto f = static_cast<std::size_t>(open.back());
        open.pop_back();
        for (Eigen::Index g : beside[f]) {
            if (seen[static_cast<std::size_t>(g)]) continue;
            seen[static_cast<std::size_t>(g)] = true;
            open.push_back(g);
        }
    }
    const auto other = std::find(seen.begin(), seen.end(), false);
    if (other != seen.end())
        throw FileError(fmt::format("{}: the surface is not a single closed surface: the tissue has a cavity or a second part at {}", file,
                                    at(shape.nodes.row(facets(other - seen.begin(), 0)))));
    const long euler = static_cast<long>(corners.size()) - static_cast<long>(sides.size()) + static_cast<long>(facets.rows());
    if (euler != 2)
        throw FileError(fmt::format("{}: the surface has a hole through it, or touches itself in a point: corners - edges + facets is {}, not 2",
                                    file, euler));
}

struct Picked {
    std::vector<MshFile::Tetrahedron> tetrahedra;
    std::vector<int> region;
};

/// Each tetrahedron once, with its region: 0 base material, else 1 + index of the study's region.
Picked pick(const MshFile& mesh, const std::vector<int>& region_tags) {
    Picked picked;
    std::map<std::array<int, 4>, std::size_t> seen;
    for (const MshFile::Tetrahedron& e : mesh.tetrahedra) {
        std::array<int, 4> key{e.node[0], e.node[1], e.node[2], e.node[3]};
        std::sort(key.begin(), key.end());
        const auto tag = std::find(region_tags.begin(), region_tags.end(), e.physical);
        const int r = tag == region_tags.end() ? 0 : static_cast<int>(tag - region_tags.begin()) + 1;
        const auto [there, fresh] = seen.emplace(key, picked.tetrahedra.size());
        if (fresh) {
            picked.tetrahedra.push_back(e);
            picked.region.push_back(r);
        } else if (r > 0) {
            int& own = picked.region[there->second];
            if (own > 0 && own != r) throw FileError(fmt::format("{}: element {} is in two of the study's regions", mesh.file, e.number));
            own = r;
        }
    }
    return picked;
}

}  // namespace

Shape make_solid_shape(const MshFile& mesh, const std::vector<std::string>& fixed, const std::vector<std::string>& regions,
                       double unit_m, ShapeNotes* notes, const FixedRegion::Reader& read, const std::vector<int>& beds) {
    const std::string& file = mesh.file;
    if (mesh.tetrahedra.empty())
        throw FileError(file + ": has no tetrahedra: is its surface closed, and its volume in a physical group?");
    const FixedParts held_by = fixed_parts(fixed, file, read, unit_m, beds);
    const std::vector<int> fixed_tags = group_tags(held_by.names, mesh.triangle_names, "surface", file),
                           region_tags = group_tags(regions, mesh.tetrahedron_names, "volume", file);
    const Picked picked = pick(mesh, region_tags);

    // used nodes, numbered along the longest axis
    std::set<int> used;
    for (const MshFile::Tetrahedron& e : picked.tetrahedra) used.insert(e.node, e.node + 4);
    const std::vector<int> points(used.begin(), used.end());
    NodeField place(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const MshFile::Point& p = mesh.points[static_cast<std::size_t>(points[i])];
        place.row(static_cast<Eigen::Index>(i)) << p.x * unit_m, p.y * unit_m, p.z * unit_m;
    }
    Shape shape;
    shape.nodes.resize(place.rows(), 3);
    std::map<int, int> number;
    for (int i : order_along(place)) {
        const int next = static_cast<int>(number.size());
        shape.nodes.row(next) = place.row(i);
        number[points[static_cast<std::size_t>(i)]] = next;
    }

    ShapeNotes put_right;
    put_right.dropped = static_cast<int>(mesh.points.size() - used.size());
    shape.simplices.resize(static_cast<Eigen::Index>(picked.tetrahedra.size()), 4);
    shape.region = picked.region;
    for (std::size_t i = 0; i < picked.tetrahedra.size(); ++i) {
        const MshFile::Tetrahedron& e = picked.tetrahedra[i];
        const auto t = static_cast<Eigen::Index>(i);
        shape.simplices.row(t) << number[e.node[0]], number[e.node[1]], number[e.node[2]], number[e.node[3]];
        double longest = 0;
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < a; ++b)
                longest = std::max(longest, (shape.nodes.row(shape.simplices(t, a)) - shape.nodes.row(shape.simplices(t, b))).norm());
        const double volume = volume_of(shape.nodes, shape.simplices, t);
        if (!(std::abs(volume) > sliver * longest * longest * longest))
            throw FileError(fmt::format("{}: element {} at {} is a sliver: its volume is {:.2g} times the cube of its longest edge", file, e.number,
                                        at(shape.nodes.row(shape.simplices(t, 0))), std::abs(volume) / (longest * longest * longest)));
        if (volume < 0) {
            std::swap(shape.simplices(t, 2), shape.simplices(t, 3));
            ++put_right.turned;
        }
    }
    refuse_overlaps(shape, file);
    const Cells facets = open_faces(shape.simplices);
    check_surface(shape, facets, file);

    std::map<Face, std::size_t> fixed_faces;  // fixed faces: index of the first named part with the face
    for (const MshFile::Element& e : mesh.triangles) {
        const auto tag = std::find(fixed_tags.begin(), fixed_tags.end(), e.physical);
        if (tag == fixed_tags.end()) continue;
        Face face{};
        for (int k = 0; k < 3; ++k) {
            const auto there = number.find(e.node[k]);
            if (there == number.end()) throw FileError(fmt::format("{}: element {} of a fixed surface belongs to no tetrahedron", file, e.number));
            face[static_cast<std::size_t>(k)] = there->second;
        }
        const auto part = static_cast<std::size_t>(tag - fixed_tags.begin());
        std::size_t& first = fixed_faces.emplace(sorted(face), part).first->second;
        first = std::min(first, part);
    }
    const double border = border_m(shape.nodes);
    std::vector<bool> holds(held_by.regions.size(), false);
    for (Eigen::Index f = 0; f < facets.rows(); ++f) {
        Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
        for (int node : facets.row(f)) middle_m += shape.nodes.row(node).transpose() / 3;
        const auto named = fixed_faces.find(sorted(face_of(facets, f)));
        int bed = named == fixed_faces.end() ? -1 : held_by.bed_of_name[named->second];
        if (bed >= 0) fixed_faces.erase(named);
        for (std::size_t r = 0; r < holds.size(); ++r) {
            if (held_by.regions[r].outside_m(middle_m) > border) continue;
            holds[r] = true;
            if (bed < 0) bed = held_by.bed_of_region[r];
        }
        if (bed < 0) continue;
        shape.fixed_facets.push_back(face_of(facets, f));
        shape.bed.push_back(bed);
    }
    for (std::size_t i = 0; i < beds.size(); ++i)
        if (std::count(shape.bed.begin(), shape.bed.end(), beds[i]) == 0) throw FileError(fmt::format("{}: other fixed parts include all of '{}', so its bed has no area", file, fixed[i]));
    if (std::count(shape.bed.begin(), shape.bed.end(), 0) == static_cast<long>(shape.bed.size())) shape.bed.clear();
    for (std::size_t r = 0; r < holds.size(); ++r)
        if (!holds[r])
            throw FileError(fmt::format("{}: '{}' fixes no facet of its surface, which extends from {} to {}", file, held_by.regions[r].text(), at(shape.nodes.colwise().minCoeff()),
                                        at(shape.nodes.colwise().maxCoeff())));
    if (!fixed_faces.empty())
        throw FileError(fmt::format("{}: the fixed surface at {} is not on the tissue's surface", file, at(shape.nodes.row(fixed_faces.begin()->first[0]))));
    if (shape.fixed_facets.empty())
        throw FileError(fmt::format("{}: no part of the surface is in the fixed surfaces {}", file, fmt::join(fixed, ", ")));
    std::set<int> fixed_nodes;
    for (const Face& face : shape.fixed_facets) fixed_nodes.insert(face.begin(), face.end());
    bool free = false;
    for (Eigen::Index f = 0; f < facets.rows() && !free; ++f)
        free = !fixed_nodes.count(facets(f, 0)) && !fixed_nodes.count(facets(f, 1)) && !fixed_nodes.count(facets(f, 2));
    if (!free) throw FileError(fmt::format("{}: the fixed surfaces {} leave no part of the surface free", file, fmt::join(fixed, ", ")));
    if (notes) *notes = put_right;
    return shape;
}

std::string solid_to_msh(const Shape& shape, const std::vector<std::string>& regions) {
    const Cells facets = open_faces(shape.simplices);
    std::map<Face, int> fixed_faces;
    for (std::size_t f = 0; f < shape.fixed_facets.size(); ++f)
        fixed_faces[sorted(shape.fixed_facets[f])] = fixed_label_of(shape.bed.empty() ? 0 : shape.bed[f]);
    const std::set<int> beds(shape.bed.begin(), shape.bed.end());
    const auto named = std::count_if(beds.begin(), beds.end(), [](int bed) { return bed > 0; });
    std::string text = fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n2 {} \"fixed\"\n2 {} \"free\"\n", 3 + static_cast<std::size_t>(named) + regions.size(), Surface::fixed_label,
                                   Surface::free_label);
    for (int bed : beds)
        if (const int label = fixed_label_of(bed); bed > 0) text += fmt::format("2 {} \"{}\"\n", label, fixed_name(label));
    text += fmt::format("3 {} \"tissue\"\n", tissue_label);
    for (std::size_t r = 0; r < regions.size(); ++r) text += fmt::format("3 {} \"{}\"\n", tissue_label + 1 + static_cast<int>(r), regions[r]);
    text += fmt::format("$EndPhysicalNames\n$Nodes\n{}\n", shape.nodes.rows());
    for (Eigen::Index i = 0; i < shape.nodes.rows(); ++i)
        text += fmt::format("{} {} {} {}\n", i + 1, shape.nodes(i, 0), shape.nodes(i, 1), shape.nodes(i, 2));
    text += fmt::format("$EndNodes\n$Elements\n{}\n", facets.rows() + shape.simplices.rows());
    int number = 0;
    for (Eigen::Index f = 0; f < facets.rows(); ++f) {
        const auto there = fixed_faces.find(sorted(face_of(facets, f)));
        const int label = there == fixed_faces.end() ? Surface::free_label : there->second;
        text += fmt::format("{} 2 2 {} {} {} {} {}\n", ++number, label, label, facets(f, 0) + 1, facets(f, 1) + 1, facets(f, 2) + 1);
    }
    for (Eigen::Index t = 0; t < shape.simplices.rows(); ++t) {
        const int label = tissue_label + shape.region[static_cast<std::size_t>(t)];
        text += fmt::format("{} 4 2 {} {} {} {} {} {}\n", ++number, label, label, shape.simplices(t, 0) + 1, shape.simplices(t, 1) + 1,
                            shape.simplices(t, 2) + 1, shape.simplices(t, 3) + 1);
    }
    return text + "$EndElements\n";
}

Shape read_solid_shape(const std::string& file) {
    const MshFile mesh = read_msh(file, true);
    const auto refuse = [&] { throw FileError(file + ": is not a mesh in space of tissuectl shape"); };
    Shape shape;
    shape.nodes.resize(static_cast<Eigen::Index>(mesh.points.size()), 3);
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
        shape.nodes.row(static_cast<Eigen::Index>(i)) << mesh.points[i].x, mesh.points[i].y, mesh.points[i].z;
    shape.simplices.resize(static_cast<Eigen::Index>(mesh.tetrahedra.size()), 4);
    for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
        const MshFile::Tetrahedron& e = mesh.tetrahedra[i];
        const auto t = static_cast<Eigen::Index>(i);
        shape.simplices.row(t) << e.node[0], e.node[1], e.node[2], e.node[3];
        shape.region.push_back(std::max(e.physical, tissue_label) - tissue_label);
        if (e.physical < tissue_label || !(volume_of(shape.nodes, shape.simplices, t) > 0)) refuse();
    }
    for (const MshFile::Element& e : mesh.triangles)
        if (Surface::is_fixed(e.physical)) {
            shape.fixed_facets.push_back({e.node[0], e.node[1], e.node[2]});
            shape.bed.push_back(std::max(0, e.physical - Surface::first_bed_label + 1));
        }
    if (std::count(shape.bed.begin(), shape.bed.end(), 0) == static_cast<long>(shape.bed.size())) shape.bed.clear();
    if (mesh.tetrahedra.empty() || shape.fixed_facets.empty()) refuse();
    return shape;
}

SpringMesh solid_edge_mesh(const Shape& shape) {
    SpringMesh mesh;
    mesh.nodes = shape.nodes;
    mesh.simplices = shape.simplices;
    mesh.facets = open_faces(mesh.simplices);
    std::set<int> fixed;
    for (const Face& face : shape.fixed_facets) fixed.insert(face.begin(), face.end());
    mesh.fixed.assign(fixed.begin(), fixed.end());
    std::map<Edge, double> volume;  // sum of the tetrahedra at each edge
    mesh.node_measure = Eigen::VectorXd::Zero(mesh.node_count());
    for (Eigen::Index t = 0; t < mesh.simplices.rows(); ++t) {
        const double own = volume_of(mesh.nodes, mesh.simplices, t);
        for (int a = 0; a < 4; ++a) {
            mesh.node_measure[mesh.simplices(t, a)] += own / 4;
            for (int b = 0; b < a; ++b) {
                const auto [low, high] = std::minmax(mesh.simplices(t, a), mesh.simplices(t, b));
                volume[{low, high}] += own;
            }
        }
    }
    mesh.springs.resize(static_cast<Eigen::Index>(volume.size()), 2);
    mesh.incident_measure.resize(static_cast<Eigen::Index>(volume.size()));
    Eigen::Index s = 0;
    for (const auto& [edge, sum] : volume) {
        mesh.springs.row(s) << edge[0], edge[1];
        mesh.incident_measure[s++] = sum;
    }
    return mesh;
}

Shape solid_shape_of(const SpringMesh& mesh) {
    Shape shape{mesh.own_nodes(), mesh.simplices, std::vector<int>(static_cast<std::size_t>(mesh.simplices.rows()), 0), {}};
    const auto is_fixed = [&](int node) { return std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), node); };
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        const Face face = face_of(mesh.facets, f);
        if (std::all_of(face.begin(), face.end(), is_fixed)) shape.fixed_facets.push_back(face);
    }
    return shape;
}

}  // namespace tissue
