#pragma once

#include "springs/element.h"

namespace tissue {

/// Hooke's springs along their current direction: theta (l - L)^2 / 2, l now, L at rest. They turn with the tissue.
class TurningSprings final : public Elements {
   public:
    explicit TurningSprings(const SpringMesh& mesh);

    std::string kind() const override { return "spring"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

   private:
    double elongation(int e, const NodeField& u, double length) const;

    NodeField span_;          ///< X_i - X_j [m] (S x D)
    Eigen::VectorXd length_;  ///< L [m] (S)
};

}  // namespace tissue
