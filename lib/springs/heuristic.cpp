#include "springs/heuristic.h"

namespace tissue {

Eigen::VectorXd heuristic_stiffness(const SpringMesh& mesh, double modulus_N_m) {
    Eigen::VectorXd theta(mesh.spring_count());
    for (int s = 0; s < mesh.spring_count(); ++s) {
        const double length = mesh.rest_length(s);
        theta[s] = modulus_N_m * mesh.incident_area[s] / (length * length);
    }
    return theta;
}

Eigen::VectorXd uniform_stiffness(const SpringMesh& mesh, double stiffness_N_m) {
    Eigen::VectorXd theta(mesh.spring_count());
    for (int s = 0; s < mesh.spring_count(); ++s) {
        const Eigen::RowVectorXd along = mesh.nodes.row(mesh.springs(s, 0)) - mesh.nodes.row(mesh.springs(s, 1));
        const bool diagonal = along.cwiseAbs().minCoeff() > 1e-9 * along.norm();
        theta[s] = diagonal ? stiffness_N_m / 2 : stiffness_N_m;
    }
    return theta;
}

Eigen::VectorXd node_masses(const SpringMesh& mesh, double density_kg_m3, double thickness_m) {
    return density_kg_m3 * thickness_m * mesh.node_area;
}

}  // namespace tissue
