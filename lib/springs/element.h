#pragma once

#include <Eigen/Core>
#include <string>

#include "mesh/cells.h"
#include "mesh/spring_mesh.h"

namespace tissue {

using ElementVector = Eigen::VectorXd;
using ElementMatrix = Eigen::MatrixXd;

/// All elements of one kind on one mesh at rest: springs, cells, regions, supports. Element e stores constant_e *
/// energy(e, u). Thus
///   external nodal force that holds u   constant_e * force(e, u)     at D * corner + axis
///   tangent                             constant_e * tangent(e, u)   symmetric
///   derivatives by the constant         energy(e, u), force(e, u)
/// Constants are stiffnesses [N/m]. Functions give values per unit constant: energy [m^2], force [m], tangent [1].
/// (Where constants are moduli [Pa], each has one more factor of m.) There is one file per kind. All functions are
/// const and keep no state, so many threads may call them.
class Elements {
   public:
    virtual ~Elements() = default;

    virtual std::string kind() const = 0;
    const Cells& nodes() const { return nodes_; }  ///< node numbers of each element (E x corners)
    int count() const { return static_cast<int>(nodes_.rows()); }

    virtual double energy(int e, const NodeField& u) const = 0;
    virtual void force(int e, const NodeField& u, ElementVector& out) const = 0;
    virtual void tangent(int e, const NodeField& u, ElementMatrix& out) const = 0;

   protected:
    explicit Elements(Cells nodes) : nodes_(std::move(nodes)) {}

   private:
    Cells nodes_;
};

}  // namespace tissue
