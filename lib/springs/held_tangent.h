#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "springs/spring_law.h"

namespace tissue {

/// Numbers of a mesh's free degrees of freedom, -1 for those of fixed nodes.
struct FreeNumbering {
    std::vector<int> number;  ///< (N*D)
    int count = 0;            ///< F

    explicit FreeNumbering(const SpringMesh& mesh);
    Eigen::VectorXd gather(const Eigen::VectorXd& nodal) const;             ///< (N*D) -> (F)
    void add(const Eigen::VectorXd& free, NodeField& nodal) const;          ///< nodal += free, fixed nodes stay
    Eigen::MatrixXd scatter_columns(const Eigen::MatrixXd& free) const;     ///< (. x F) -> (. x N*D), zero where fixed
};

/// Sign of a symmetric matrix by the pivots of its factorisation; p is the largest magnitude among them.
enum class Definiteness {
    positive,  ///< every pivot > 1e-10 p
    flat,      ///< the first that is not lies in [-1e-10 p, 1e-10 p]: some displacement meets no resistance
    negative   ///< the first that is not is < -1e-10 p: some displacement is driven on
};

/// A tangent K of the free degrees of freedom (F x F) and its factorisation.
struct FreeTangent {
    SparseMatrix K;
    Eigen::SimplicialLDLT<SparseMatrix> factor;
    Definiteness definiteness;

    FreeTangent(const SparseMatrix& stiffness, const FreeNumbering& numbering);
};

/// The tangent of a mesh whose contact is held, W'du = gap: what counts is K on the displacements that leave the contact
/// where it is, W'du = 0. A free mesh that would collapse or slide may be held by its contact.
/// Where K itself is positive definite its factor is used, else the contact is eliminated: du = Z y + Y gap with W'Z = 0,
/// W'Y = 1, and Z'KZ is factorised.
class HeldTangent {
   public:
    /// W (F x D): the contact's weights, one column an axis, none of them zero. Both must outlive this.
    /// shift [N/m]: added to the diagonal of Z'KZ, for a direction of descent where it is not positive definite.
    HeldTangent(const FreeTangent& free, const Eigen::MatrixXd& W, double shift = 0);

    Definiteness definiteness() const;  ///< of Z'KZ + shift

    struct Step {
        Eigen::VectorXd du;     ///< [m] (F)
        Eigen::VectorXd force;  ///< r, the multiplier of W'du = gap [N] (D)
    };
    /// K du - W r = -residual, W'du = gap. Only where positive definite.
    Step solve(const Eigen::VectorXd& residual, const Eigen::VectorXd& gap) const;

    /// G (D x F): r = G residual when gap = 0. Only where positive definite.
    Eigen::MatrixXd sensitivity() const;

   private:
    const FreeTangent& free_;
    const Eigen::MatrixXd& W_;
    // K positive definite
    Eigen::MatrixXd KW_;                       // K^-1 W
    Eigen::LDLT<Eigen::MatrixXd> compliance_;  // W'K^-1 W
    // else
    struct Eliminated;
    std::shared_ptr<const Eliminated> eliminated_;
};

}  // namespace tissue
