#pragma once

#include <vector>

#include "springs/element.h"

namespace tissue {

/// Springs between the fixed nodes of an embedded solid and their rest positions: energy k |u|^2 / 2, with u
/// interpolated in the node's cube.
class Supports final : public Elements {
   public:
    /// One support per fixed node of the mesh (M). Throws MismatchError for a mesh that is not an embedded lattice.
    explicit Supports(const SpringMesh& mesh);

    std::string kind() const override { return "support"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

   private:
    std::vector<int> fixed_;  ///< fixed nodes of the solid (M)
    Embedding embedding_;
};

/// Area of the fixed surface per fixed node: a third of each adjacent fixed facet [m^2] (M).
Eigen::VectorXd fixed_areas(const SpringMesh& mesh);

}  // namespace tissue
