#pragma once

#include <vector>

#include "springs/element.h"

namespace tissue {

/// A spring between each held node of an embedded solid and where it is at rest: k |u|^2 / 2, u interpolated in the node's cube.
class Supports final : public Elements {
   public:
    /// Of the mesh's fixed nodes (M). Throws MismatchError for a mesh that is no embedded lattice.
    explicit Supports(const SpringMesh& mesh);

    std::string kind() const override { return "support"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

   private:
    std::vector<int> held_;  ///< the solid's nodes that are held (M)
    Embedding embedding_;
};

/// What part of the held surface is each fixed node's: a third of its held facets [m^2] (M).
Eigen::VectorXd held_areas(const SpringMesh& mesh);

}  // namespace tissue
