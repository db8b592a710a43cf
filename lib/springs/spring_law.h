#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <string>
#include <vector>

#include "mesh/spring_mesh.h"
#include "registry.h"
#include "springs/branch_memory.h"
#include "springs/spring_curve.h"

namespace tissue {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Springs in consecutive memory, for the tick. Element k of each array belongs to spring k. There is one array per
/// axis, two in the plane and three in space. An element without a spring has theta = 0. Force arrays overlap no other
/// array.
struct SpringRun {
    int dimension;
    const double* theta;                ///< [N/m]
    const double *u_i[3], *u_j[3];      ///< displacement of both ends [m]
    const double* span[3];              ///< rest span X_j - X_i [m]
    const double* length;               ///< rest length [m]
    const double* axis[3];              ///< rest direction, a unit vector
    bool parallel = false;              ///< all springs have the same rest direction
    bool alike = false;                 ///< and the same rest length, as in a lattice
    /// the common values; where they apply, the arrays are not read
    double one_axis[3], one_span[3], one_length;
    /// external force that holds each end [N]; the springs' part is added
    double *f_i[3], *f_j[3];
    /// for turning springs that relax: their branches in the measure sqrt(2 energy), Hooke's elongation [m]; null: no
    /// relaxation
    BranchMemory* memory = nullptr;
    int first = 0;                      ///< element k of the run is element first + k of `memory`
};

/// How a spring converts displacement into force, the paper's (10): f = A(u) theta, always linear in the stiffnesses
/// theta (S) [N/m]. f (N x D) [N] is the external nodal force that holds the displacement u (N x D) [m]. Per spring,
/// `rest` is X_i - X_j and `relative` is u_i - u_j [m].
class SpringLaw {
   public:
    virtual ~SpringLaw() = default;

    virtual std::string name() const = 0;

    /// True when A is linear in u: f = K(theta) u with a constant K.
    virtual bool linear_in_displacement() const = 0;

    /// True when K does not couple the axes and is the same along each: one number per node pair.
    virtual bool axes_apart() const = 0;

    /// Force curve of springs that rotate with the tissue; null for other laws.
    virtual const SpringCurve* curve() const = 0;

    /// A(u) [m] (N*D x S): column s is the force of spring s per unit stiffness.
    virtual SparseMatrix force_matrix(const SpringMesh& mesh, const NodeField& u) const = 0;

    /// K = df/du at u [N/m] (N*D x N*D), symmetric.
    virtual SparseMatrix stiffness(const SpringMesh& mesh, const Eigen::VectorXd& theta, const NodeField& u) const = 0;

    // For the tick; none of the following allocates.

    /// Whether pull() supports three dimensions.
    virtual bool plays_in_space() const = 0;

    /// With g_k = theta_k times the unit force of spring k on its first end [N], for k = 0 .. n-1: f_i -= g, f_j += g.
    virtual void pull(const SpringRun& run, int n) const noexcept = 0;

    /// d f_i / d u_i of one spring per unit theta; the block of i, j is its negative. `convex` keeps it positive
    /// semi-definite where a compressed turning spring would buckle.
    virtual Eigen::Matrix2d unit_stiffness(const Eigen::Vector2d& rest, const Eigen::Vector2d& relative,
                                           bool convex) const noexcept = 0;
    virtual Eigen::Matrix3d unit_stiffness(const Eigen::Vector3d& rest, const Eigen::Vector3d& relative,
                                           bool convex) const noexcept = 0;

    /// Energy of one spring per unit theta [m^2], 0 at rest.
    virtual double unit_energy(const Point& rest, const Point& relative) const noexcept = 0;
};

using MakeSpringLaw = std::unique_ptr<SpringLaw> (*)();

/// All spring laws. Each has a file of its own and is registered in spring_law.cpp.
const Registry<MakeSpringLaw>& spring_laws();

/// `geometric` with another curve than Hooke's, for an energy model.
std::unique_ptr<SpringLaw> make_turning_law(const SpringCurve& curve);

/// Throws MismatchError for an unknown name.
std::unique_ptr<SpringLaw> make_spring_law(const std::string& name);

}  // namespace tissue
