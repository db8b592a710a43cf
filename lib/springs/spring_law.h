#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <string>
#include <vector>

#include "mesh/spring_mesh.h"

namespace tissue {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// How a spring turns displacement into force, the paper's (10): f = A(u) theta, always linear in the stiffness
/// theta (S) [N/m]. f (N x D) [N] is the external nodal force that holds the displacement u (N x D) [m].
class SpringLaw {
   public:
    virtual ~SpringLaw() = default;

    virtual std::string name() const = 0;

    /// True when A is linear in u, so that f = K(theta) u with a constant K.
    virtual bool linear_in_displacement() const = 0;

    /// A(u) [m] (N*D x S): column s is the force of spring s per unit stiffness.
    virtual SparseMatrix force_matrix(const SpringMesh& mesh, const NodeField& u) const = 0;

    /// K = df/du at u [N/m] (N*D x N*D), symmetric.
    virtual SparseMatrix stiffness(const SpringMesh& mesh, const Eigen::VectorXd& theta, const NodeField& u) const = 0;
};

/// Names of the laws, in the order in which messages list them.
///   isotropic  theta (u_i - u_j): the same in every direction, so no 4-connected row can slide for nothing
///   axial      theta times the elongation along the rest direction: the spring of linear elasticity
///   geometric  theta (|x_i - x_j| - L0) along the current direction, so it turns with the tissue
///   rubber     theta L0 (lambda - lambda^-2) / 3 along the current direction: turns, and stiffens when pressed
const std::vector<std::string>& spring_law_names();

/// Throws MismatchError for an unknown name.
std::unique_ptr<SpringLaw> make_spring_law(const std::string& name);

}  // namespace tissue
