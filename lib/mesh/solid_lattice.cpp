#include "mesh/solid_lattice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>

#include "error.h"
#include "mesh/open_faces.h"

namespace tissue {
namespace {

using Corner = std::array<int, 3>;

/// The eight corners of a cell, bit by bit: 1 along x, 2 along y, 4 along z.
Corner corner(int k) { return {k & 1, (k >> 1) & 1, (k >> 2) & 1}; }

}  // namespace

double spring_share(int axes) { return axes == 2 ? 1.0 / 6 : 1.0 / 4; }

SpringMesh solid_lattice(const Lattice& lattice) {
    const std::vector<int>& n = lattice.cells;
    const std::vector<double>& size = lattice.size_m;
    if (n.size() != 3 || size.size() != 3 || *std::min_element(n.begin(), n.end()) < 1 || !(*std::min_element(size.begin(), size.end()) > 0))
        throw MismatchError(fmt::format("a lattice of {} cells on {} m is not possible", fmt::join(n, " x "), fmt::join(size, " x ")));
    const auto node = [&](int x, int y, int z) { return (z * (n[1] + 1) + y) * (n[0] + 1) + x; };

    SpringMesh mesh;
    mesh.topology = "grid26";
    mesh.nodes.resize((n[0] + 1) * (n[1] + 1) * (n[2] + 1), 3);
    for (int z = 0; z <= n[2]; ++z)
        for (int y = 0; y <= n[1]; ++y)
            for (int x = 0; x <= n[0]; ++x)
                mesh.nodes.row(node(x, y, z)) << size[0] * x / n[0], size[1] * y / n[1], size[2] * z / n[2];

    const double volume = size[0] / n[0] * size[1] / n[1] * size[2] / n[2];
    mesh.node_measure = Eigen::VectorXd::Zero(mesh.node_count());
    mesh.simplices.resize(6 * n[0] * n[1] * n[2], 4);
    std::array<std::map<std::array<int, 2>, double>, 4> springs;  // by the axes they run along: measure of each
    Eigen::Index t = 0;
    for (int z = 0; z < n[2]; ++z)
        for (int y = 0; y < n[1]; ++y)
            for (int x = 0; x < n[0]; ++x) {
                const auto at = [&](int k) {
                    const Corner c = corner(k);
                    return node(x + c[0], y + c[1], z + c[2]);
                };
                for (int i = 0; i < 8; ++i) {
                    mesh.node_measure[at(i)] += volume / 8;
                    for (int j = i + 1; j < 8; ++j) {
                        const int axes = __builtin_popcount(static_cast<unsigned>(i ^ j));
                        springs[static_cast<std::size_t>(axes)][{std::min(at(i), at(j)), std::max(at(i), at(j))}] += spring_share(axes) * volume;
                    }
                }
                // from corner 0 to corner 7 one axis after the other, in every order; neighbours divide their face alike
                std::array<int, 3> order = {1, 2, 4};
                int turn = 0;
                do {
                    const int a = at(0), b = at(order[0]), c = at(order[0] | order[1]), d = at(7);
                    const bool even = order == std::array<int, 3>{1, 2, 4} || order == std::array<int, 3>{2, 4, 1} || order == std::array<int, 3>{4, 1, 2};
                    mesh.simplices.row(t + turn++) << a, even ? b : c, even ? c : b, d;
                } while (std::next_permutation(order.begin(), order.end()));
                t += turn;
            }

    std::size_t count = 0;
    for (const auto& family : springs) count += family.size();
    mesh.springs.resize(static_cast<Eigen::Index>(count), 2);
    mesh.incident_measure.resize(static_cast<Eigen::Index>(count));
    Eigen::Index s = 0;
    for (const auto& family : springs)
        for (const auto& [ends, measure] : family) {
            mesh.springs.row(s) << ends[0], ends[1];
            mesh.incident_measure[s++] = measure;
        }

    mesh.facets = open_faces(mesh.simplices);
    for (int i = 0; i < (n[0] + 1) * (n[1] + 1); ++i) mesh.fixed.push_back(i);
    return mesh;
}

}  // namespace tissue
