#include "mesh/surface.h"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "error.h"
#include "mesh/facet.h"
#include "mesh/nearest_triangle.h"
#include "mesh/fixed_region.h"

namespace tissue {
namespace {

using Edge = std::pair<int, int>;
using Face = std::array<int, 3>;

std::string at(const Eigen::Vector3d& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", p.x(), p.y(), p.z()); }

std::string extent(const NodeField& nodes) { return at(nodes.colwise().minCoeff().transpose()) + " to " + at(nodes.colwise().maxCoeff().transpose()); }

Face sorted(Face face) {
    std::sort(face.begin(), face.end());
    return face;
}

/// Faces that belong to one tetrahedron only, normals out.
std::vector<Face> outer_faces(const MshFile& mesh, const std::string& file) {
    std::map<Face, std::pair<Face, int>> seen;  // sorted nodes -> face, number of tetrahedra
    for (const MshFile::Tetrahedron& e : mesh.tetrahedra) {
        const auto place = [&](int i) {
            const MshFile::Point& p = mesh.points[static_cast<std::size_t>(e.node[i])];
            return Eigen::Vector3d(p.x, p.y, p.z);
        };
        const double volume = (place(1) - place(0)).cross(place(2) - place(0)).dot(place(3) - place(0));
        if (volume == 0) throw FileError(fmt::format("{}: tetrahedron {} has no volume", file, e.number));
        for (const auto& [i, j, k] : {std::array<int, 3>{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}) {
            Face face{e.node[i], e.node[j], e.node[k]};
            if (volume < 0) std::swap(face[1], face[2]);
            auto& there = seen.emplace(sorted(face), std::pair(face, 0)).first->second;
            if (++there.second > 2) throw FileError(fmt::format("{}: tetrahedron {} overlaps another", file, e.number));
        }
    }
    std::vector<Face> faces;
    for (const auto& [key, face] : seen)
        if (face.second == 1) faces.push_back(face.first);
    return faces;
}

/// The neighbour across each side of each triangle: (triangle, whether it runs the side in the opposite direction, as
/// it does if both are oriented alike).
std::vector<std::array<std::pair<int, bool>, 3>> neighbours(const Surface& s, const std::string& file) {
    std::map<Edge, std::vector<std::pair<int, int>>> sides;
    for (int t = 0; t < s.triangles.rows(); ++t)
        for (int i = 0; i < 3; ++i) {
            const int a = s.triangles(t, i), b = s.triangles(t, (i + 1) % 3);
            sides[{std::min(a, b), std::max(a, b)}].emplace_back(t, i);
        }
    std::vector<std::array<std::pair<int, bool>, 3>> across(static_cast<std::size_t>(s.triangles.rows()));
    for (const auto& [edge, here] : sides) {
        if (here.size() != 2)
            throw FileError(fmt::format("{}: the surface {} at {}", file, here.size() == 1 ? "is not closed: it has a border" : "touches itself",
                                        at((s.nodes.row(edge.first) + s.nodes.row(edge.second)) / 2)));
        const bool opposite = s.triangles(here[0].first, here[0].second) != s.triangles(here[1].first, here[1].second);
        for (int k = 0; k < 2; ++k)
            across[static_cast<std::size_t>(here[static_cast<std::size_t>(k)].first)][static_cast<std::size_t>(here[static_cast<std::size_t>(k)].second)] = {here[static_cast<std::size_t>(1 - k)].first, opposite};
    }
    return across;
}

double enclosed_volume(const Surface& s) {
    double six = 0;
    const Eigen::RowVector3d origin = s.nodes.row(0);
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
        const Eigen::RowVector3d a = s.nodes.row(s.triangles(t, 0)) - origin, b = s.nodes.row(s.triangles(t, 1)) - origin,
                                 c = s.nodes.row(s.triangles(t, 2)) - origin;
        six += a.cross(b).dot(c);
    }
    return six / 6;
}

/// Turns triangles so that all normals point out, and checks that the surface is one closed piece without holes through
/// it.
void close(Surface& s, const std::string& file) {
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
        if (!(facet_measure(s.nodes, s.triangles, t) > 0))
            throw FileError(fmt::format("{}: a triangle of the surface has no area at {}", file, at(s.nodes.row(s.triangles(t, 0)))));
    const auto across = neighbours(s, file);
    std::vector<char> seen(across.size(), 0);
    std::vector<int> next{0};
    seen[0] = 1;
    std::size_t count = 1;
    std::vector<char> turned(across.size(), 0);
    while (!next.empty()) {
        const int t = next.back();
        next.pop_back();
        for (const auto& [other, opposite] : across[static_cast<std::size_t>(t)]) {
            const char turn = opposite ? turned[static_cast<std::size_t>(t)] : !turned[static_cast<std::size_t>(t)];
            if (seen[static_cast<std::size_t>(other)]) {
                if (turned[static_cast<std::size_t>(other)] != turn)
                    throw FileError(fmt::format("{}: the surface has only one side, at {}", file, at(s.nodes.row(s.triangles(other, 0)))));
                continue;
            }
            seen[static_cast<std::size_t>(other)] = 1;
            turned[static_cast<std::size_t>(other)] = turn;
            next.push_back(other);
            ++count;
        }
    }
    if (count < across.size()) {
        const auto other = static_cast<Eigen::Index>(std::find(seen.begin(), seen.end(), 0) - seen.begin());
        throw FileError(fmt::format("{}: the surface has more than one part: a second part or a cavity at {}", file, at(s.nodes.row(s.triangles(other, 0)))));
    }
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
        if (turned[static_cast<std::size_t>(t)]) std::swap(s.triangles(t, 1), s.triangles(t, 2));
    const double volume = enclosed_volume(s);
    if (volume == 0) throw FileError(file + ": the surface encloses no volume");
    if (volume < 0)
        for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) std::swap(s.triangles(t, 1), s.triangles(t, 2));
    // Euler: N - E + T = 2 for a sphere, with E = 3 T / 2
    const Eigen::Index euler = s.nodes.rows() - s.triangles.rows() / 2;
    if (euler != 2)
        throw FileError(euler < 2 ? fmt::format("{}: the tissue has {} holes through it; a shape must have none", file, (2 - euler) / 2)
                                  : file + ": the surface touches itself at a point");
}

/// Part of each triangle; parts are bounded by creases and numbered from the largest.
std::vector<int> parts_between_creases(const Surface& s, const std::string& file) {
    const auto across = neighbours(s, file);
    std::vector<int> part(across.size(), -1);
    std::vector<double> area;
    for (std::size_t first = 0; first < part.size(); ++first) {
        if (part[first] >= 0) continue;
        std::vector<int> next{static_cast<int>(first)};
        part[first] = static_cast<int>(area.size());
        area.push_back(0);
        while (!next.empty()) {
            const int t = next.back();
            next.pop_back();
            area.back() += facet_measure(s.nodes, s.triangles, t);
            for (const auto& [other, opposite] : across[static_cast<std::size_t>(t)]) {
                if (part[static_cast<std::size_t>(other)] >= 0) continue;
                if (facet_normal(s.nodes, s.triangles, t).dot(facet_normal(s.nodes, s.triangles, other)) < crease_cosine) continue;
                part[static_cast<std::size_t>(other)] = part[first];
                next.push_back(other);
            }
        }
    }
    std::vector<std::size_t> order(area.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return area[a] > area[b]; });
    std::vector<int> rank(area.size());
    for (std::size_t k = 0; k < order.size(); ++k) rank[order[k]] = static_cast<int>(k);
    for (int& p : part) p = rank[static_cast<std::size_t>(p)];
    return part;
}

bool held_by(Surface& s, const FixedRegion& region, const std::string& file, int label) try {
    return hold(s, region, label);
} catch (const MismatchError& e) {
    throw FileError(file + ": " + e.what());
}

}  // namespace

namespace {

/// A closed surface, all of it free, and the file's nodes of each triangle.
struct Closed {
    Surface surface;
    std::vector<Face> faces;
};
Closed closed(const MshFile& mesh, double unit_m) {
    const std::string& file = mesh.file;
    std::vector<Face> faces;
    if (!mesh.tetrahedra.empty()) {
        faces = outer_faces(mesh, file);
    } else {
        for (const MshFile::Element& e : mesh.triangles) faces.push_back({e.node[0], e.node[1], e.node[2]});
        std::vector<Face> keys;  // an element in two groups is listed twice
        for (const Face& f : faces) keys.push_back(sorted(f));
        std::sort(keys.begin(), keys.end());
        if (std::adjacent_find(keys.begin(), keys.end()) != keys.end()) {
            std::map<Face, Face> once;
            for (const Face& f : faces) once.emplace(sorted(f), f);
            faces.clear();
            for (const auto& [key, f] : once) faces.push_back(f);
        }
    }
    if (faces.empty()) throw FileError(file + ": has neither tetrahedra nor triangles");

    Surface s;
    std::vector<int> place(mesh.points.size(), -1);
    std::vector<int> used;
    s.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t t = 0; t < faces.size(); ++t)
        for (int i = 0; i < 3; ++i) {
            int& there = place[static_cast<std::size_t>(faces[t][static_cast<std::size_t>(i)])];
            if (there < 0) {
                there = static_cast<int>(used.size());
                used.push_back(faces[t][static_cast<std::size_t>(i)]);
            }
            s.triangles(static_cast<Eigen::Index>(t), i) = there;
        }
    s.nodes.resize(static_cast<Eigen::Index>(used.size()), 3);
    for (std::size_t i = 0; i < used.size(); ++i) {
        const MshFile::Point& p = mesh.points[static_cast<std::size_t>(used[i])];
        s.nodes.row(static_cast<Eigen::Index>(i)) << unit_m * p.x, unit_m * p.y, unit_m * p.z;
    }
    close(s, file);
    s.label.assign(faces.size(), Surface::free_label);
    return {s, faces};
}

}  // namespace

Surface closed_surface(const MshFile& mesh, double unit_m) { return closed(mesh, unit_m).surface; }

std::string fixed_name(int label) { return label == Surface::fixed_label ? "fixed" : fmt::format("bed-{}", label - Surface::first_bed_label + 1); }

Surface make_surface(const MshFile& mesh, const std::vector<std::string>& held, double unit_m, const FixedRegion::Reader& read, const std::vector<int>& beds) {
    const FixedParts fixed_by_part = fixed_parts(held, mesh.file, read, unit_m, beds);
    const std::vector<std::string>& fixed = fixed_by_part.names;
    const std::string& file = mesh.file;
    auto [s, faces] = closed(mesh, unit_m);
    std::vector<std::string> known;
    std::vector<std::size_t> first(faces.size(), fixed.size());  // index of each triangle's first part of `fixed`
    const auto hold_group = [&, &s = s](const std::string& name, const std::vector<std::size_t>& triangles) {
        const auto part = static_cast<std::size_t>(std::find(fixed.begin(), fixed.end(), name) - fixed.begin());
        for (std::size_t t : triangles) {
            if (part >= first[t]) continue;
            first[t] = part;
            s.label[t] = fixed_label_of(fixed_by_part.bed_of_name[part]);
        }
        known.push_back(name);
    };
    std::map<Face, std::size_t> number;
    for (std::size_t t = 0; t < faces.size(); ++t) number[sorted(faces[t])] = t;
    if (!mesh.triangle_names.empty()) {
        for (const auto& [tag, name] : mesh.triangle_names) {
            std::vector<std::size_t> group;
            std::size_t all = 0;
            for (const MshFile::Element& e : mesh.triangles) {
                if (e.physical != tag) continue;
                ++all;
                const auto there = number.find(sorted({e.node[0], e.node[1], e.node[2]}));
                if (there != number.end()) group.push_back(there->second);
            }
            const bool wanted = std::find(fixed.begin(), fixed.end(), name) != fixed.end();
            if (wanted && group.size() < all) throw FileError(fmt::format("{}: '{}', which is fixed, has triangles that are not on the surface", file, name));
            if (wanted && all == 0) throw FileError(fmt::format("{}: '{}', which is fixed, has no triangles", file, name));
            hold_group(name, group);
        }
    } else {
        const std::vector<int> part = parts_between_creases(s, file);
        const int parts = *std::max_element(part.begin(), part.end()) + 1;
        for (int k = 0; k < parts; ++k) {
            std::vector<std::size_t> group;
            for (std::size_t t = 0; t < part.size(); ++t)
                if (part[t] == k) group.push_back(t);
            hold_group(fmt::format("surface-{}", k + 1), group);
        }
    }
    for (const std::string& name : fixed)
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            if (known.size() > 12) known.assign({known[0], known[1], "...", known.back()});
            throw FileError(fmt::format("{}: has no surface '{}' to fix; its surfaces: {}", file, name, fmt::join(known, ", ")));
        }
    for (std::size_t k = 0; k < fixed_by_part.regions.size(); ++k)
        if (const FixedRegion& region = fixed_by_part.regions[k]; !held_by(s, region, file, fixed_label_of(fixed_by_part.bed_of_region[k])))
            throw FileError(fmt::format("{}: '{}' fixes no part of its surface, which extends from {}", file, region.text(), extent(s.nodes)));
    if (held.empty()) throw FileError(file + ": no part of its surface is fixed");
    for (std::size_t i = 0; i < beds.size(); ++i)
        if (std::count(s.label.begin(), s.label.end(), fixed_label_of(beds[i])) == 0) throw FileError(fmt::format("{}: other fixed parts include all of '{}', so its bed has no area", file, held[i]));
    if (std::count(s.label.begin(), s.label.end(), Surface::free_label) == 0)
        throw FileError(fmt::format("{}: all of the surface is fixed: it extends from {}", file, extent(s.nodes)));
    return s;
}

Enclosed enclosed_by(const Surface& s) {
    const Eigen::Vector3d from = s.corner(0, 0);  // sum over tetrahedra from this point to each triangle
    Enclosed sum{0, Eigen::Vector3d::Zero()};
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
        const Eigen::Vector3d a = s.corner(t, 0) - from, b = s.corner(t, 1) - from, c = s.corner(t, 2) - from;
        const double volume_m3 = a.cross(b).dot(c) / 6;
        sum.volume_m3 += volume_m3;
        sum.centre_m += volume_m3 * (a + b + c) / 4;
    }
    sum.centre_m = from + sum.centre_m / sum.volume_m3;
    return sum;
}

double fixed_area_m2(const Surface& s) {
    double area = 0;
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
        if (Surface::is_fixed(s.label[static_cast<std::size_t>(t)])) area += facet_measure(s.nodes, s.triangles, t);
    return area;
}

void check_fixed_area(const Surface& before, const Surface& divided) {
    const auto held = [](const Surface& s, Eigen::Index t) { return Surface::is_fixed(s.label[static_cast<std::size_t>(t)]); };
    // sets of connected nodes of fixed triangles
    boost::disjoint_sets_with_storage<> part(static_cast<std::size_t>(before.nodes.rows()));
    for (Eigen::Index t = 0; t < before.triangles.rows(); ++t)
        for (int i = 1; i < 3 && held(before, t); ++i) part.union_set(static_cast<std::size_t>(before.triangles(t, 0)), static_cast<std::size_t>(before.triangles(t, i)));
    const auto part_of = [&](Eigen::Index t) { return part.find_set(static_cast<std::size_t>(before.triangles(t, 0))); };
    std::map<std::size_t, double> had, has;
    for (Eigen::Index t = 0; t < before.triangles.rows(); ++t)
        if (held(before, t)) had[part_of(t)] += facet_measure(before.nodes, before.triangles, t);
    const NearestTriangle nearest(before);
    for (Eigen::Index t = 0; t < divided.triangles.rows(); ++t)
        if (held(divided, t))
            if (const Eigen::Index there = nearest.nearest((divided.corner(t, 0) + divided.corner(t, 1) + divided.corner(t, 2)) / 3).triangle; held(before, there)) has[part_of(there)] += facet_measure(divided.nodes, divided.triangles, t);
    for (const auto& [number, area] : had)
        if (has[number] < 0.9 * area)
            throw MismatchError(fmt::format("of {:.3g} mm2 of fixed surface at {} only {:.3g} mm2 remain after remeshing: edges are too long for this fixed part", 1e6 * area, at(before.nodes.row(static_cast<Eigen::Index>(number))),
                                            1e6 * has[number]));
}

std::string to_msh(const Surface& outer, const Surface* inner) {
    constexpr int inner_label = 4;  // number of gmsh's geometric entity; in no physical group
    Surface s = outer;
    if (inner != nullptr) {
        s.nodes.conservativeResize(outer.nodes.rows() + inner->nodes.rows(), 3);
        s.nodes.bottomRows(inner->nodes.rows()) = inner->nodes;
        s.triangles.conservativeResize(outer.triangles.rows() + inner->triangles.rows(), 3);
        s.triangles.bottomRows(inner->triangles.rows()) = inner->triangles.array() + static_cast<int>(outer.nodes.rows());
        s.label.resize(static_cast<std::size_t>(s.triangles.rows()), inner_label);
    }
    const std::set<int> labels(outer.label.begin(), outer.label.end());
    const auto beds = std::count_if(labels.begin(), labels.end(), [](int label) { return label >= Surface::first_bed_label; });
    std::string text = fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n2 {} \"fixed\"\n2 {} \"free\"\n2 {} \"disc\"\n", 3 + beds, Surface::fixed_label, Surface::free_label,
                                   Surface::disc_label);
    for (int label : labels)
        if (label >= Surface::first_bed_label) text += fmt::format("2 {} \"{}\"\n", label, fixed_name(label));
    text += fmt::format("$EndPhysicalNames\n$Nodes\n{}\n", s.nodes.rows());
    for (Eigen::Index i = 0; i < s.nodes.rows(); ++i) text += fmt::format("{} {} {} {}\n", i + 1, s.nodes(i, 0), s.nodes(i, 1), s.nodes(i, 2));
    text += fmt::format("$EndNodes\n$Elements\n{}\n", s.triangles.rows());
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
        const int label = s.label[static_cast<std::size_t>(t)];
        text += fmt::format("{} 2 2 {} {} {} {} {}\n", t + 1, label == inner_label ? 0 : label, label, s.triangles(t, 0) + 1, s.triangles(t, 1) + 1, s.triangles(t, 2) + 1);
    }
    return text + "$EndElements\n";
}

double triangle_quality(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const double squares = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
    return squares > 0 ? 2 * std::sqrt(3.0) * (b - a).cross(c - a).norm() / squares : 0;
}

}  // namespace tissue
