#include "mesh/solid_block.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "error.h"
#include "mesh/open_faces.h"

namespace tissue {

Shape solid_block(const Lattice& lattice) {
    const std::vector<int>& n = lattice.cells;
    const std::vector<double>& size = lattice.size_m;
    if (n.size() != 3 || size.size() != 3 || *std::min_element(n.begin(), n.end()) < 1 || !(*std::min_element(size.begin(), size.end()) > 0))
        throw MismatchError(fmt::format("a lattice of {} cells on {} m is not possible", fmt::join(n, " x "), fmt::join(size, " x ")));
    const auto node = [&](int x, int y, int z) { return (z * (n[1] + 1) + y) * (n[0] + 1) + x; };

    Shape block;
    block.nodes.resize((n[0] + 1) * (n[1] + 1) * (n[2] + 1), 3);
    for (int z = 0; z <= n[2]; ++z)
        for (int y = 0; y <= n[1]; ++y)
            for (int x = 0; x <= n[0]; ++x) block.nodes.row(node(x, y, z)) << size[0] * x / n[0], size[1] * y / n[1], size[2] * z / n[2];

    block.simplices.resize(6 * n[0] * n[1] * n[2], 4);
    Eigen::Index t = 0;
    for (int z = 0; z < n[2]; ++z)
        for (int y = 0; y < n[1]; ++y)
            for (int x = 0; x < n[0]; ++x) {
                // bits 1, 2, 4 of `corner` step along x, y, z
                const auto at = [&](int corner) { return node(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)); };
                // one tetrahedron for each path from corner 0 to corner 7 along the three axes in turn
                std::array<int, 3> order = {1, 2, 4};
                do {
                    const int a = at(0), b = at(order[0]), c = at(order[0] | order[1]), d = at(7);
                    const bool even = order == std::array<int, 3>{1, 2, 4} || order == std::array<int, 3>{2, 4, 1} || order == std::array<int, 3>{4, 1, 2};
                    block.simplices.row(t++) << a, even ? b : c, even ? c : b, d;
                } while (std::next_permutation(order.begin(), order.end()));
            }
    block.region.assign(static_cast<std::size_t>(t), 0);
    const int bottom = (n[0] + 1) * (n[1] + 1);
    const Cells facets = open_faces(block.simplices);
    for (Eigen::Index f = 0; f < facets.rows(); ++f)
        if (facets.row(f).maxCoeff() < bottom) block.fixed_facets.push_back({facets(f, 0), facets(f, 1), facets(f, 2)});
    return block;
}

}  // namespace tissue
