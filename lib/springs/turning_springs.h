#pragma once

#include "springs/element.h"
#include "springs/spring_curve.h"

namespace tissue {

/// Springs along their current direction with one force curve. Hooke's store theta (l - L)^2 / 2, with the current
/// length l and the rest length L. They rotate with the tissue.
class TurningSprings final : public Elements {
   public:
    TurningSprings(const SpringMesh& mesh, const SpringCurve& curve);

    std::string kind() const override { return "spring"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

   private:
    double drawn_out(int e, const NodeField& u, double length) const;

    SpringCurve curve_;
    NodeField span_;          ///< X_i - X_j [m] (S x D)
    Eigen::VectorXd length_;  ///< L [m] (S)
};

}  // namespace tissue
