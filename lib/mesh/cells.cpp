#include "mesh/cells.h"

#include "error.h"
#include "mesh/topology.h"

namespace tissue {

Cells mesh_cells(const SpringMesh& mesh) {
    if (!mesh.embedding.empty()) return mesh.embedding.cubes;
    if (!on_lattice(mesh)) return mesh.simplices;
    // the two triangles of a lattice cell are consecutive: (a, b, .) and (., c, d), with either diagonal
    Cells cells(mesh.simplices.rows() / 2, 4);
    for (Eigen::Index c = 0; c < cells.rows(); ++c) {
        const auto first = mesh.simplices.row(2 * c), second = mesh.simplices.row(2 * c + 1);
        cells.row(c) << first[0], first[1], second[1], second[2];
        const bool rising = first[2] == second[1] && second[0] == first[0];   // diagonal from a to c
        const bool falling = first[2] == second[2] && second[0] == first[1];  // diagonal from b to d
        if (!rising && !falling) throw MismatchError("the triangles of the lattice do not form pairs in its cells");
    }
    return cells;
}

Eigen::Index cell_count(const SpringMesh& mesh) { return has_cells(mesh) ? mesh_cells(mesh).rows() : mesh.node_count(); }

Eigen::VectorXd cell_areas(const SpringMesh& mesh, const Cells& cells) {
    Eigen::VectorXd areas = Eigen::VectorXd::Zero(cells.rows());
    for (Eigen::Index c = 0; c < cells.rows(); ++c)
        for (Eigen::Index k = 0; k < cells.cols(); ++k) {
            const auto p = mesh.nodes.row(cells(c, k)), q = mesh.nodes.row(cells(c, (k + 1) % cells.cols()));
            areas[c] += (p[0] * q[1] - p[1] * q[0]) / 2;
        }
    return areas;
}

std::vector<std::vector<int>> node_stars(const SpringMesh& mesh, const Cells& cells) {
    std::vector<std::vector<int>> stars(static_cast<std::size_t>(mesh.node_count()));
    for (int c = 0; c < cells.rows(); ++c)
        for (Eigen::Index k = 0; k < cells.cols(); ++k) stars[static_cast<std::size_t>(cells(c, k))].push_back(c);
    return stars;
}

std::vector<std::vector<int>> cell_regions(const SpringMesh& mesh, const Cells& cells) {
    const Eigen::RowVectorXd low = mesh.nodes.colwise().minCoeff(), high = mesh.nodes.colwise().maxCoeff(), middle = (low + high) / 2;
    const double tiny = 1e-6 * (high - low).maxCoeff();
    std::vector<std::vector<int>> regions(1);
    for (int quarter = 0; quarter < 4; ++quarter) {
        std::vector<int> region;
        for (int c = 0; c < cells.rows(); ++c) {
            Eigen::RowVectorXd off = -middle;
            for (Eigen::Index k = 0; k < cells.cols(); ++k) off += mesh.nodes.row(cells(c, k)) / static_cast<double>(cells.cols());
            const double x = quarter % 2 ? off[0] : -off[0], y = quarter / 2 ? off[1] : -off[1];
            if (x > -tiny && y > -tiny) region.push_back(c);
            if (quarter == 0) regions[0].push_back(c);
        }
        if (!region.empty()) regions.push_back(region);
    }
    return regions;
}

}  // namespace tissue
