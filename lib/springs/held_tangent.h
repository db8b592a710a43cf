#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "springs/spring_law.h"

namespace tissue {

/// Numbers of a mesh's free degrees of freedom; -1 for those of fixed nodes.
struct FreeNumbering {
    std::vector<int> number;  ///< by degree of freedom D * node + axis (N*D)
    int count = 0;            ///< number of free degrees of freedom, F

    explicit FreeNumbering(const SpringMesh& mesh);
    Eigen::VectorXd gather(const Eigen::VectorXd& nodal) const;             ///< (N*D) -> (F)
    /// nodal += free; fixed nodes are not changed
    void add(const Eigen::VectorXd& free, NodeField& nodal) const;
    Eigen::MatrixXd scatter_columns(const Eigen::MatrixXd& free) const;     ///< (. x F) -> (. x N*D), zero where fixed
};

/// Definiteness of a symmetric matrix by the pivots of its factorisation; p is the largest magnitude of a pivot.
enum class Definiteness {
    positive,  ///< every pivot > 1e-10 p
    /// the first pivot <= 1e-10 p is >= -1e-10 p, or is 0: some displacement meets no resistance
    flat,
    negative   ///< the first pivot <= 1e-10 p is < -1e-10 p: some displacement lowers the energy
};

/// A tangent K on the free degrees of freedom (F x F) and its factorisation.
struct FreeTangent {
    SparseMatrix K;
    Eigen::SimplicialLDLT<SparseMatrix> factor;
    Definiteness definiteness;

    FreeTangent(const SparseMatrix& stiffness, const FreeNumbering& numbering);
};

/// Tangent of a mesh with a prescribed contact, W'du = gap. Only K on the displacements that leave the contact where it
/// is, W'du = 0, matters. A mesh that would collapse or slide by itself may be stable with its contact prescribed.
/// If K is positive definite, its factor is used. Otherwise the contact is eliminated, du = Z y + Y gap with W'Z = 0
/// and W'Y = 1, and Z'KZ is factorised.
class HeldTangent {
   public:
    /// W (F x D): the contact's weights, one column per axis, none of them zero. `free` and W must outlive this object.
    /// shift [N/m]: added to the diagonal of Z'KZ, for a direction of descent where Z'KZ is not positive definite.
    HeldTangent(const FreeTangent& free, const Eigen::MatrixXd& W, double shift = 0);

    Definiteness definiteness() const;  ///< of Z'KZ + shift

    struct Step {
        Eigen::VectorXd du;     ///< [m] (F)
        Eigen::VectorXd force;  ///< multiplier r of W'du = gap [N] (D)
    };
    /// Solves K du - W r = -residual, W'du = gap. Requires definiteness() == positive.
    Step solve(const Eigen::VectorXd& residual, const Eigen::VectorXd& gap) const;

    /// G (D x F): r = G residual when gap = 0. Requires definiteness() == positive.
    Eigen::MatrixXd sensitivity() const;

   private:
    const FreeTangent& free_;
    const Eigen::MatrixXd& W_;
    // If K is positive definite:
    Eigen::MatrixXd KW_;                       // K^-1 W
    Eigen::LDLT<Eigen::MatrixXd> compliance_;  // W'K^-1 W
    // Otherwise:
    struct Eliminated;
    std::shared_ptr<const Eliminated> eliminated_;
};

}  // namespace tissue
