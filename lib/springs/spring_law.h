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

/// Springs that lie behind one another in memory, as the tick wants them: element k of each array is of spring k, one array an
/// axis, two in the plane and three in space. An element without a spring has theta = 0.
struct SpringRun {
    int dimension;
    const double* theta;                ///< [N/m]
    const double *u_i[3], *u_j[3];      ///< displacement of both ends [m]
    const double* span[3];              ///< rest span X_j - X_i [m]
    const double* length;               ///< and its length [m]
    const double* axis[3];              ///< and its direction, a unit vector
    bool parallel = false;              ///< all springs have one rest direction,
    bool alike = false;                 ///< and one rest length: a lattice's
    double one_axis[3], one_span[3], one_length;  ///< these; where they do, the arrays are not read
    double *f_i[3], *f_j[3];            ///< the external force that holds each end [N]: the springs' is added. No array meets another
    BranchMemory* memory = nullptr;     ///< of springs that turn and relax: of sqrt(2 energy), Hooke's elongation [m],
    int first = 0;                      ///< in which element k of the run is this one + k
};

/// How a spring turns displacement into force, the paper's (10): f = A(u) theta, always linear in the stiffness
/// theta (S) [N/m]. f (N x D) [N] is the external nodal force that holds the displacement u (N x D) [m].
/// Per spring, `rest` is X_i - X_j and `relative` u_i - u_j [m].
class SpringLaw {
   public:
    virtual ~SpringLaw() = default;

    virtual std::string name() const = 0;

    /// True when A is linear in u, so that f = K(theta) u with a constant K.
    virtual bool linear_in_displacement() const = 0;

    /// True when K never mixes the axes and is the same along each: one number a pair of nodes.
    virtual bool axes_apart() const = 0;

    /// Of springs that turn, how they pull; null for others.
    virtual const SpringCurve* curve() const = 0;

    /// A(u) [m] (N*D x S): column s is the force of spring s per unit stiffness.
    virtual SparseMatrix force_matrix(const SpringMesh& mesh, const NodeField& u) const = 0;

    /// K = df/du at u [N/m] (N*D x N*D), symmetric.
    virtual SparseMatrix stiffness(const SpringMesh& mesh, const Eigen::VectorXd& theta, const NodeField& u) const = 0;

    // The tick's own; none allocates.

    /// Whether pull() plays in space too.
    virtual bool plays_in_space() const = 0;

    /// With g_k = theta_k times the pull of spring k on its first end [N], for k = 0 .. n-1: f_i -= g, f_j += g.
    virtual void pull(const SpringRun& run, int n) const noexcept = 0;

    /// d f_i / d u_i of one spring per unit theta (the block of i, j is its opposite). `convex` keeps it positive
    /// semi-definite where a compressed spring that turns would buckle.
    virtual Eigen::Matrix2d unit_stiffness(const Eigen::Vector2d& rest, const Eigen::Vector2d& relative,
                                           bool convex) const noexcept = 0;
    virtual Eigen::Matrix3d unit_stiffness(const Eigen::Vector3d& rest, const Eigen::Vector3d& relative,
                                           bool convex) const noexcept = 0;

    /// Energy of one spring per unit theta [m^2], 0 at rest.
    virtual double unit_energy(const Point& rest, const Point& relative) const noexcept = 0;
};

using MakeSpringLaw = std::unique_ptr<SpringLaw> (*)();

/// Every law there is. Each has a file of its own, and a line here.
const Registry<MakeSpringLaw>& spring_laws();

/// `geometric` with springs of another curve than Hooke's: an energy model's.
std::unique_ptr<SpringLaw> make_turning_law(const SpringCurve& curve);

/// Throws MismatchError for an unknown name.
std::unique_ptr<SpringLaw> make_spring_law(const std::string& name);

}  // namespace tissue
