#pragma once

#include <Eigen/Core>
#include <string>

#include "mesh/cells.h"
#include "mesh/spring_mesh.h"

namespace tissue {

using ElementVector = Eigen::VectorXd;
using ElementMatrix = Eigen::MatrixXd;

/// All elements of one kind on one mesh at rest: springs, cells. Element e stores constant_e * energy(e, u), and so
///   force it takes to hold u        constant_e * force(e, u)        of its nodes, D * corner + axis
///   tangent                         constant_e * tangent(e, u)      symmetric
///   derivative by its constant      energy(e, u), force(e, u)
/// Constants are stiffnesses [N/m]; what is here is per unit of them: energy [m^2], force [m], tangent [1].
/// One file a kind. All are const, keep nothing, and serve many threads.
class Elements {
   public:
    virtual ~Elements() = default;

    virtual std::string kind() const = 0;
    const Cells& nodes() const { return nodes_; }  ///< of each element, one row each (E x corners)
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
