#pragma once

#include <cmath>

#include "mesh/solid_block.h"
#include "mesh/solid_shape.h"
#include "mesh/topology.h"

namespace tissue {

/// A rounded dome on a flat fixed bed, z = 0: n x n x n / 2 boxes of six tetrahedra, mapped towards half a ball of
/// radius 0.05 m. The bed's edge is the only crease.
inline Shape dome(int n = 10) {
    Shape shape = solid_block(Lattice{{n, n, n / 2}, {2, 2, 1}});
    for (Eigen::Index i = 0; i < shape.nodes.rows(); ++i) {
        const double x = shape.nodes(i, 0) - 1, y = shape.nodes(i, 1) - 1, z = shape.nodes(i, 2);
        const auto round = [](double a, double b, double c) { return a * std::sqrt(1 - b * b / 2 - c * c / 2 + b * b * c * c / 3); };
        constexpr double ball = 0.8;
        shape.nodes.row(i) << ball * round(x, y, z) + (1 - ball) * x, ball * round(y, x, z) + (1 - ball) * y, ball * round(z, x, y) + (1 - ball) * z;
    }
    shape.nodes *= 0.05;
    return shape;
}

/// The same as a mesh of gmsh in millimetres, with the groups "bed" 5 and "flesh" 7.
inline MshFile dome_file(int n = 10) {
    const Shape shape = dome(n);
    MshFile file;
    file.file = "dome.msh";
    for (Eigen::Index i = 0; i < shape.nodes.rows(); ++i)
        file.points.push_back({1e3 * shape.nodes(i, 0), 1e3 * shape.nodes(i, 1), 1e3 * shape.nodes(i, 2)});
    long number = 0;
    for (const auto& f : shape.fixed_facets) file.triangles.push_back({++number, {f[0], f[1], f[2]}, 5});
    for (Eigen::Index t = 0; t < shape.simplices.rows(); ++t)
        file.tetrahedra.push_back({++number, {shape.simplices(t, 0), shape.simplices(t, 1), shape.simplices(t, 2), shape.simplices(t, 3)}, 7});
    file.triangle_names = {{5, "bed"}};
    file.tetrahedron_names = {{7, "flesh"}};
    return file;
}

}  // namespace tissue
