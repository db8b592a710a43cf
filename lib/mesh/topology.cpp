#include "mesh/topology.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "error.h"
#include "mesh/embedded_lattice.h"

namespace tissue {
namespace {

SpringMesh plane_lattice(const char* topology, bool diagonals, const Lattice& of) {
    const int cells_x = of.cells[0], cells_y = of.cells[1];
    const double width_m = of.size_m[0], height_m = of.size_m[1];
    if (cells_x < 1 || cells_y < 1 || !(width_m > 0) || !(height_m > 0))
        throw MismatchError(fmt::format("a lattice of {} x {} cells on {} x {} m is not possible", cells_x, cells_y,
                                        width_m, height_m));

    const auto node = [cells_x](int ix, int iy) { return iy * (cells_x + 1) + ix; };
    SpringMesh mesh;
    mesh.topology = topology;
    mesh.nodes.resize((cells_x + 1) * (cells_y + 1), 2);
    for (int iy = 0; iy <= cells_y; ++iy)
        for (int ix = 0; ix <= cells_x; ++ix)
            mesh.nodes.row(node(ix, iy)) << width_m * ix / cells_x, height_m * iy / cells_y;

    const double cell_area = width_m / cells_x * height_m / cells_y;
    std::vector<std::array<int, 2>> springs;
    std::vector<double> areas;
    const auto add = [&](int i, int j, double area) {
        springs.push_back({i, j});
        areas.push_back(area);
    };
    const auto cells_beside = [](int line, int cells) { return line == 0 || line == cells ? 1 : 2; };
    for (int iy = 0; iy <= cells_y; ++iy)
        for (int ix = 0; ix < cells_x; ++ix)
            add(node(ix, iy), node(ix + 1, iy), cell_area / 2 * cells_beside(iy, cells_y));
    for (int iy = 0; iy < cells_y; ++iy)
        for (int ix = 0; ix <= cells_x; ++ix)
            add(node(ix, iy), node(ix, iy + 1), cell_area / 2 * cells_beside(ix, cells_x));
    if (diagonals)
        for (int iy = 0; iy < cells_y; ++iy)
            for (int ix = 0; ix < cells_x; ++ix) {
                add(node(ix, iy), node(ix + 1, iy + 1), cell_area);
                add(node(ix + 1, iy), node(ix, iy + 1), cell_area);
            }
    mesh.springs.resize(static_cast<int>(springs.size()), 2);
    mesh.incident_measure.resize(static_cast<int>(springs.size()));
    for (int s = 0; s < mesh.spring_count(); ++s) {
        mesh.springs.row(s) << springs[s][0], springs[s][1];
        mesh.incident_measure[s] = areas[s];
    }

    mesh.simplices.resize(2 * cells_x * cells_y, 3);
    mesh.node_measure = Eigen::VectorXd::Zero(mesh.node_count());
    int t = 0;
    for (int iy = 0; iy < cells_y; ++iy)
        for (int ix = 0; ix < cells_x; ++ix) {
            const int a = node(ix, iy), b = node(ix + 1, iy), c = node(ix + 1, iy + 1), d = node(ix, iy + 1);
            const bool left = 2 * ix < cells_x;  // diagonals are mirror-symmetric, as in the FE mesh
            mesh.simplices.row(t++) << a, b, left ? d : c;
            mesh.simplices.row(t++) << (left ? b : a), c, d;
            for (int corner : {a, b, c, d}) mesh.node_measure[corner] += cell_area / 4;
        }

    std::vector<int> loop;
    for (int ix = 0; ix < cells_x; ++ix) loop.push_back(node(ix, 0));
    for (int iy = 0; iy < cells_y; ++iy) loop.push_back(node(cells_x, iy));
    for (int ix = cells_x; ix > 0; --ix) loop.push_back(node(ix, cells_y));
    for (int iy = cells_y; iy > 0; --iy) loop.push_back(node(0, iy));
    mesh.facets = loop_facets(loop);
    for (int ix = 0; ix <= cells_x; ++ix) mesh.fixed.push_back(node(ix, 0));
    return mesh;
}

SpringMesh grid4(const Lattice& of) { return plane_lattice("grid4", false, of); }

SpringMesh grid8(const Lattice& of) { return plane_lattice("grid8", true, of); }

SpringMesh edges(const Lattice& of) { return edge_mesh(shape_of(grid4(of))); }

SpringMesh edges_of(const Shape& shape, double) { return edge_mesh(shape); }

}  // namespace

const Registry<Topology>& topologies() {
    static const Registry<Topology> kinds("topology",
                                          {
                                              {"grid4", 2, grid4, nullptr},
                                              {"grid8", 2, grid8, nullptr},
                                              {"edges", 2, edges, edges_of},
                                              {"embedded", 3, nullptr, embedded_lattice},
                                          },
                                          [](const Topology& kind) { return kind.name; });
    return kinds;
}

bool on_lattice(const SpringMesh& mesh) { return topologies().at(mesh.topology).needs_lattice(); }

bool has_cells(const SpringMesh& mesh) { return on_lattice(mesh) || !mesh.embedding.empty(); }

bool is_box(const SpringMesh& mesh) {
    const Eigen::RowVectorXd low = mesh.own_nodes().colwise().minCoeff(), high = mesh.own_nodes().colwise().maxCoeff();
    const double tiny_m = 1e-9 * mesh.size_m();
    for (Eigen::Index f = 0; f < mesh.facets.rows(); ++f) {
        bool on_one = false;
        for (Eigen::Index d = 0; d < mesh.dimension(); ++d)
            for (double plane_m : {low[d], high[d]}) {
                bool all = true;
                for (int node : mesh.facets.row(f)) all = all && std::abs(mesh.nodes(node, d) - plane_m) < tiny_m;
                on_one = on_one || all;
            }
        if (!on_one) return false;
    }
    return true;
}

SpringMesh make_lattice(const std::string& topology, const Lattice& lattice) {
    const Topology& kind = topologies().at(topology);
    if (!kind.on_lattice) throw MismatchError(fmt::format("topology '{}' is not possible on the lattice of a block", topology));
    if (lattice.dimension() != kind.dimension)
        throw MismatchError(fmt::format("topology '{}' has {} dimensions, the lattice has {}", topology, kind.dimension, lattice.dimension()));
    return kind.on_lattice(lattice);
}

SpringMesh make_lattice(const std::string& topology, int cells_x, int cells_y, double width_m, double height_m) {
    return make_lattice(topology, {{cells_x, cells_y}, {width_m, height_m}});
}

}  // namespace tissue
