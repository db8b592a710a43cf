#pragma once

#include <Eigen/Core>

#include "mesh/spring_mesh.h"

namespace tissue {

/// Van Gelder's heuristic, the paper's (7): k_c = E2 sum_e area(T_e) / |c|^2.
/// modulus_N_m: two-dimensional Young's modulus E2 [N/m]. Returns theta [N/m] (S).
Eigen::VectorXd heuristic_stiffness(const SpringMesh& mesh, double modulus_N_m);

/// The same where E2 varies from triangle to triangle (T) [N/m]. The springs must be the triangles' edges; throws
/// MismatchError otherwise.
Eigen::VectorXd heuristic_stiffness(const SpringMesh& mesh, const Eigen::VectorXd& triangle_modulus_N_m);

/// One stiffness k [N/m] for every spring, k/2 for the diagonals of a lattice. Returns theta [N/m] (S).
Eigen::VectorXd uniform_stiffness(const SpringMesh& mesh, double stiffness_N_m);

/// Node masses, the paper's (8), with the quad cells as elements, or with the triangles for topology "edges". Returns
/// masses [kg] (N). Their sum is density * thickness * area.
Eigen::VectorXd node_masses(const SpringMesh& mesh, double density_kg_m3, double thickness_m);

}  // namespace tissue
