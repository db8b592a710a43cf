#include "springs/heuristic.h"

#include <algorithm>
#include <map>

#include "error.h"
#include "mesh/topology.h"

namespace tissue {

Eigen::VectorXd heuristic_stiffness(const SpringMesh& mesh, double modulus_N_m) {
    Eigen::VectorXd theta(mesh.spring_count());
    for (int s = 0; s < mesh.spring_count(); ++s) {
        const double length = mesh.rest_length(s);
        theta[s] = modulus_N_m * mesh.incident_measure[s] / (length * length);
    }
    return theta;
}

Eigen::VectorXd heuristic_stiffness(const SpringMesh& mesh, const Eigen::VectorXd& triangle_modulus_N_m) {
    std::map<std::pair<int, int>, double> sum;  // E2 area(T_e), summed by edge
    for (Eigen::Index t = 0; t < mesh.simplices.rows(); ++t) {
        const int a = mesh.simplices(t, 0), b = mesh.simplices(t, 1), c = mesh.simplices(t, 2);
        const Eigen::RowVector2d ab = mesh.nodes.row(b) - mesh.nodes.row(a), ac = mesh.nodes.row(c) - mesh.nodes.row(a);
        const double own = triangle_modulus_N_m[t] * (ab.x() * ac.y() - ab.y() * ac.x()) / 2;
        for (const auto& [i, j] : {std::pair(a, b), {b, c}, {c, a}}) sum[std::minmax(i, j)] += own;
    }
    Eigen::VectorXd theta(mesh.spring_count());
    for (int s = 0; s < mesh.spring_count(); ++s) {
        const double length = mesh.rest_length(s);
        const auto there = sum.find(std::minmax(mesh.springs(s, 0), mesh.springs(s, 1)));
        if (there == sum.end()) throw MismatchError("a modulus by triangle needs springs on the triangles' edges");
        theta[s] = there->second / (length * length);
    }
    return theta;
}

Eigen::VectorXd uniform_stiffness(const SpringMesh& mesh, double stiffness_N_m) {
    const bool lattice = has_cells(mesh);
    Eigen::VectorXd theta(mesh.spring_count());
    for (int s = 0; s < mesh.spring_count(); ++s) {
        const Eigen::RowVectorXd along = mesh.nodes.row(mesh.springs(s, 0)) - mesh.nodes.row(mesh.springs(s, 1));
        const bool diagonal = lattice && (along.array().abs() > 1e-9 * along.norm()).count() > 1;
        theta[s] = diagonal ? stiffness_N_m / 2 : stiffness_N_m;
    }
    return theta;
}

Eigen::VectorXd node_masses(const SpringMesh& mesh, double density_kg_m3, double thickness_m) {
    return density_kg_m3 * thickness_m * mesh.node_measure;
}

}  // namespace tissue
