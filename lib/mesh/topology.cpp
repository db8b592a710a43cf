#include "mesh/topology.h"

#include <fmt/format.h>

#include <array>

#include "error.h"

namespace tissue {
namespace {

SpringMesh lattice(const char* topology, bool diagonals, int cells_x, int cells_y, double width_m, double height_m) {
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
    mesh.incident_area.resize(static_cast<int>(springs.size()));
    for (int s = 0; s < mesh.spring_count(); ++s) {
        mesh.springs.row(s) << springs[s][0], springs[s][1];
        mesh.incident_area[s] = areas[s];
    }

    mesh.triangles.resize(2 * cells_x * cells_y, 3);
    mesh.node_area = Eigen::VectorXd::Zero(mesh.node_count());
    int t = 0;
    for (int iy = 0; iy < cells_y; ++iy)
        for (int ix = 0; ix < cells_x; ++ix) {
            const int a = node(ix, iy), b = node(ix + 1, iy), c = node(ix + 1, iy + 1), d = node(ix, iy + 1);
            const bool left = 2 * ix < cells_x;  // mirror-symmetric, as the FE mesh is
            mesh.triangles.row(t++) << a, b, left ? d : c;
            mesh.triangles.row(t++) << (left ? b : a), c, d;
            for (int corner : {a, b, c, d}) mesh.node_area[corner] += cell_area / 4;
        }

    for (int ix = 0; ix < cells_x; ++ix) mesh.boundary.push_back(node(ix, 0));
    for (int iy = 0; iy < cells_y; ++iy) mesh.boundary.push_back(node(cells_x, iy));
    for (int ix = cells_x; ix > 0; --ix) mesh.boundary.push_back(node(ix, cells_y));
    for (int iy = cells_y; iy > 0; --iy) mesh.boundary.push_back(node(0, iy));
    for (int ix = 0; ix <= cells_x; ++ix) mesh.fixed.push_back(node(ix, 0));
    return mesh;
}

SpringMesh grid4(int cells_x, int cells_y, double width_m, double height_m) {
    return lattice("grid4", false, cells_x, cells_y, width_m, height_m);
}

SpringMesh grid8(int cells_x, int cells_y, double width_m, double height_m) {
    return lattice("grid8", true, cells_x, cells_y, width_m, height_m);
}

SpringMesh edges(int cells_x, int cells_y, double width_m, double height_m) {
    return edge_mesh(shape_of(grid4(cells_x, cells_y, width_m, height_m)));
}

}  // namespace

const Registry<Topology>& topologies() {
    static const Registry<Topology> kinds("topology",
                                          {
                                              {"grid4", grid4, nullptr},
                                              {"grid8", grid8, nullptr},
                                              {"edges", edges, edge_mesh},
                                          },
                                          [](const Topology& kind) { return kind.name; });
    return kinds;
}

bool on_lattice(const SpringMesh& mesh) { return topologies().at(mesh.topology).needs_lattice(); }

SpringMesh make_lattice(const std::string& topology, int cells_x, int cells_y, double width_m, double height_m) {
    return topologies().at(topology).on_lattice(cells_x, cells_y, width_m, height_m);
}

}  // namespace tissue
