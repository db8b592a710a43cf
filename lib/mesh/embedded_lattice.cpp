#include "mesh/embedded_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "error.h"
#include "mesh/cube_search.h"
#include "mesh/open_faces.h"

namespace tissue {
namespace {

constexpr int parts = 6;  // of a cube along each axis
constexpr double least_fraction = 0.02, least_mass = 0.02;
constexpr int most_cubes = 100'000;
constexpr double most_in_all = 200'000;  // cubes of the bounding box: the parts of all are in memory at once

using Triple = std::array<int, 3>;

/// Position of the lattice: node (0, 0, 0) [m], number of cubes along each axis, and edge h of a cube [m].
struct Frame {
    Eigen::Vector3d origin_m;
    Triple cubes;
    double h;
    Eigen::Vector3d local(const Eigen::Vector3d& place_m) const { return (place_m - origin_m) / h; }
};

/// shift: in cube edges along each axis, 0 to 1.
Frame frame_of(const Shape& shape, double h, const Eigen::Vector3d& shift) {
    Frame frame{{}, {}, h};
    double all = 1;
    for (int d = 0; d < 3; ++d) {
        const double low = shape.nodes.col(d).minCoeff(), high = shape.nodes.col(d).maxCoeff(), slack = 1e-9 * (high - low);
        double first = std::numeric_limits<double>::infinity(), last = -first;
        for (const auto& facet : shape.fixed_facets)
            for (int node : facet) {
                first = std::min(first, shape.nodes(node, d));
                last = std::max(last, shape.nodes(node, d));
            }
        if (first <= last && last - first < 1e-6 * (high - low)) {  // there is a fixed surface, and it is a plane
            const double below = std::ceil((first - low - slack) / h);
            frame.origin_m[d] = first - h * below;
        } else {
            frame.origin_m[d] = (low + high) / 2 - h * std::ceil((high - low - slack) / h) / 2;
        }
        if (shift[d] > 0) frame.origin_m[d] -= h * (1 - shift[d]);
        const double along = std::max(1.0, std::ceil((high - slack - frame.origin_m[d]) / h));
        all *= along;
        if (!(all <= most_in_all)) throw MismatchError(fmt::format("a lattice of {:g} mm over this solid has at least {:.3g} cubes; at most {:g} are possible, empty ones included", 1e3 * h, all, most_in_all));
        frame.cubes[static_cast<std::size_t>(d)] = static_cast<int>(along);
    }
    return frame;
}

/// Tissue fraction of part (i, j, k) in the grid of all cubes' parts.
class Fill {
   public:
    Fill(const Shape& shape, const Frame& frame) : size_{parts * frame.cubes[0], parts * frame.cubes[1], parts * frame.cubes[2]} {
        fill_.assign(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(size_[2]), 0);
        // of each line with the surface: height in parts, and 1 into the solid or -1 out of it
        std::vector<std::vector<std::pair<double, int>>> crossings(static_cast<std::size_t>(size_[0] * size_[1]));
        // lines slightly off the parts' centres, so that no line meets an edge of a mesh with round coordinates
        const Eigen::Vector2d off = Eigen::Vector2d(0.5, 0.5) + 1e-6 * Eigen::Vector2d(1.234567, 0.765432);
        const Cells facets = open_faces(shape.simplices);
        for (Eigen::Index f = 0; f < facets.rows(); ++f) {
            Eigen::Matrix3d at;
            for (int c = 0; c < 3; ++c) at.col(c) = parts * frame.local(shape.nodes.row(facets(f, c)).transpose());
            const Eigen::Vector2d a = at.col(0).head<2>(), ab = at.col(1).head<2>() - a, ac = at.col(2).head<2>() - a;
            const double twice = ab.x() * ac.y() - ab.y() * ac.x();
            if (twice == 0) continue;
            Triple from{}, to{};
            for (int d = 0; d < 2; ++d) {
                from[static_cast<std::size_t>(d)] = std::max(0, static_cast<int>(std::floor(at.row(d).minCoeff() - off[d])));
                to[static_cast<std::size_t>(d)] = std::min(size_[static_cast<std::size_t>(d)] - 1, static_cast<int>(std::ceil(at.row(d).maxCoeff() - off[d])));
            }
            for (int j = from[1]; j <= to[1]; ++j)
                for (int i = from[0]; i <= to[0]; ++i) {
                    const Eigen::Vector2d p = Eigen::Vector2d(i, j) + off - a;
                    const double s = (p.x() * ac.y() - p.y() * ac.x()) / twice, t = (ab.x() * p.y() - ab.y() * p.x()) / twice;
                    if (s < 0 || t < 0 || s + t > 1) continue;
                    crossings[static_cast<std::size_t>(j * size_[0] + i)].emplace_back(at(2, 0) + s * (at(2, 1) - at(2, 0)) + t * (at(2, 2) - at(2, 0)), twice < 0 ? 1 : -1);
                }
        }
        for (int j = 0; j < size_[1]; ++j)
            for (int i = 0; i < size_[0]; ++i) {
                auto& line = crossings[static_cast<std::size_t>(j * size_[0] + i)];
                std::sort(line.begin(), line.end());
                int depth = 0;
                for (std::size_t c = 0; c + 1 < line.size(); ++c) {
                    depth += line[c].second;
                    if (depth > 0) add(i, j, line[c].first, line[c + 1].first);
                }
            }
    }

    double at(int i, int j, int k) const { return fill_[index(i, j, k)]; }

   private:
    std::size_t index(int i, int j, int k) const { return static_cast<std::size_t>((k * size_[1] + j) * size_[0] + i); }
    void add(int i, int j, double low, double high) {
        const int last = std::min(size_[2] - 1, static_cast<int>(std::floor(high)));
        for (int k = std::max(0, static_cast<int>(std::floor(low))); k <= last; ++k)
            fill_[index(i, j, k)] += std::max(0.0, std::min(high, k + 1.0) - std::max(low, 1.0 * k));
    }

    Triple size_;
    std::vector<double> fill_;
};

/// The tissue in one cube: fraction of the volume, H of each corner, centroid from corner 0 in edges.
struct Part {
    double fraction = 0;
    Eigen::Matrix<double, 1, 8> hat = Eigen::Matrix<double, 1, 8>::Zero();  ///< H_n
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
};

Part part_of(const Fill& fill, const Triple& cube) {
    Part part;
    for (int k = 0; k < parts; ++k)
        for (int j = 0; j < parts; ++j)
            for (int i = 0; i < parts; ++i) {
                const double own = fill.at(parts * cube[0] + i, parts * cube[1] + j, parts * cube[2] + k) / (parts * parts * parts);
                const Eigen::Vector3d middle = (Eigen::Vector3d(i, j, k).array() + 0.5) / parts;
                part.fraction += own;
                part.hat += own * cube_weights(middle);
                part.centroid += own * middle;
            }
    if (part.fraction > 0) part.centroid /= part.fraction;
    return part;
}

/// Number of connected sets of cubes. Cubes that share a corner are connected.
int pieces(const Cells& cubes) {
    std::map<int, int> parent;
    const auto root = [&](int node) {
        while (parent.at(node) != node) node = parent.at(node) = parent.at(parent.at(node));
        return node;
    };
    for (int node : cubes.reshaped()) parent.emplace(node, node);
    int count = static_cast<int>(parent.size());
    for (Eigen::Index c = 0; c < cubes.rows(); ++c)
        for (int k = 1; k < 8; ++k) {
            const int a = root(cubes(c, 0)), b = root(cubes(c, k));
            if (a != b) parent[a] = b, --count;
        }
    return count;
}

}  // namespace

double spring_share(int axes) { return axes == 2 ? 1.0 / 6 : 1.0 / 4; }

SpringMesh embedded_lattice(const Shape& shape, double spacing_m) { return shifted_lattice(shape, spacing_m, Eigen::Vector3d::Zero()); }

SpringMesh shifted_lattice(const Shape& shape, double spacing_m, const Eigen::Vector3d& shift) {
    if (!(spacing_m > 0)) throw MismatchError("an embedded lattice needs a spacing > 0");
    const Frame frame = frame_of(shape, spacing_m, shift);
    const Fill fill(shape, frame);

    std::vector<Triple> cubes;
    std::vector<Part> part;
    for (int z = 0; z < frame.cubes[2]; ++z)
        for (int y = 0; y < frame.cubes[1]; ++y)
            for (int x = 0; x < frame.cubes[0]; ++x) {
                const Part here = part_of(fill, {x, y, z});
                if (!(here.fraction > least_fraction)) continue;
                cubes.push_back({x, y, z});
                part.push_back(here);
            }
    if (cubes.empty() || cubes.size() > most_cubes)
        throw MismatchError(fmt::format("a lattice of {:g} mm has {} cubes with tissue; 1 to {} are possible", 1e3 * spacing_m, cubes.size(), most_cubes));

    // lattice nodes follow the solid's, x fastest, so that consecutive cubes and springs have consecutive nodes
    const int K = static_cast<int>(shape.nodes.rows());
    // lattice coordinates z, y, x of a cube's corner k
    const auto corner = [](const Triple& cube, int k) { return Triple{cube[2] + (k >> 2), cube[1] + (k >> 1 & 1), cube[0] + (k & 1)}; };
    std::map<Triple, int> number;
    for (const Triple& cube : cubes)
        for (int k = 0; k < 8; ++k) number[corner(cube, k)] = 0;
    int next = K;
    for (auto& [place, node] : number) node = next++;

    SpringMesh mesh;
    mesh.topology = "embedded";
    mesh.nodes.resize(next, 3);
    mesh.nodes.topRows(K) = shape.nodes;
    for (const auto& [place, node] : number)
        mesh.nodes.row(node) = (frame.origin_m + spacing_m * Eigen::Vector3d(place[2], place[1], place[0])).transpose();
    mesh.simplices = shape.simplices;
    mesh.facets = open_faces(shape.simplices);
    std::set<int> fixed_nodes;
    for (const auto& facet : shape.fixed_facets) fixed_nodes.insert(facet.begin(), facet.end());
    mesh.fixed.assign(fixed_nodes.begin(), fixed_nodes.end());

    Embedding& embedding = mesh.embedding;
    embedding.spacing_m = spacing_m;
    const auto C = static_cast<Eigen::Index>(cubes.size());
    embedding.cubes.resize(C, 8);
    embedding.fraction.resize(C);
    embedding.centroid.resize(C, 3);
    const double volume = spacing_m * spacing_m * spacing_m;
    mesh.node_measure = Eigen::VectorXd::Zero(next);
    std::map<std::pair<int, int>, double> springs;
    for (Eigen::Index c = 0; c < C; ++c) {
        const Part& own = part[static_cast<std::size_t>(c)];
        for (int k = 0; k < 8; ++k) embedding.cubes(c, k) = number.at(corner(cubes[static_cast<std::size_t>(c)], k));
        embedding.fraction[c] = own.fraction;
        embedding.centroid.row(c) = own.centroid.transpose();
        for (int i = 0; i < 8; ++i) {
            mesh.node_measure[embedding.cubes(c, i)] += own.fraction * volume / 8;
            for (int j = i + 1; j < 8; ++j) {
                const int across = i ^ j, axes = __builtin_popcount(static_cast<unsigned>(across));
                double counted = 0;  // sum of H over the edge, face or cube that the spring spans
                for (int k = 0; k < 8; ++k) counted += ((k ^ i) & ~across) == 0 ? own.hat[k] : 0;
                springs[std::minmax(embedding.cubes(c, i), embedding.cubes(c, j))] += spring_share(axes) * (8 >> axes) * counted * volume;
            }
        }
    }
    for (int node = K; node < next; ++node) mesh.node_measure[node] = std::max(mesh.node_measure[node], least_mass * volume);
    mesh.springs.resize(static_cast<Eigen::Index>(springs.size()), 2);
    mesh.incident_measure.resize(static_cast<Eigen::Index>(springs.size()));
    Eigen::Index s = 0;
    for (const auto& [ends, measure] : springs) {
        mesh.springs.row(s) << ends.first, ends.second;
        mesh.incident_measure[s++] = measure;
    }

    embedding.corner.resize(K, 8);
    embedding.weight.resize(K, 8);
    const CubeSearch search(mesh.nodes, embedding.cubes, spacing_m);
    for (int i = 0; i < K; ++i) {
        const CubeSearch::Found found = search.at(shape.nodes.row(i).transpose());
        if (found.cube < 0 || found.away >= 1)
            throw MismatchError(fmt::format("a lattice of {:g} mm is too coarse for this solid: a part of it is far from every cube with tissue", 1e3 * spacing_m));
        embedding.corner.row(i) = embedding.cubes.row(found.cube);
        embedding.weight.row(i) = found.weight;
    }
    if (pieces(embedding.cubes) > 1) throw MismatchError(fmt::format("a lattice of {:g} mm is too coarse for this solid: it is not connected where the solid is thin", 1e3 * spacing_m));
    return mesh;
}

}  // namespace tissue
