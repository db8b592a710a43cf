#pragma once

#include "springs/element.h"

namespace tissue {

/// Springs between held points of an embedded solid and where they are at rest: k |u|^2 / 2 each, u of the point, interpolated in its cube.
class Supports final : public Elements {
   public:
    /// Of the mesh's fixed nodes (M). Throws MismatchError for a mesh that is no embedded lattice.
    explicit Supports(const SpringMesh& mesh);

    std::string kind() const override { return "support"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

   private:
    Eigen::Vector3d displacement(int e, const NodeField& u) const;

    NodeField weight_;  ///< of a point's corners (M x 8)
};

/// What part of the held surface is each fixed node's: a third of its held facets [m^2] (M).
Eigen::VectorXd held_areas(const SpringMesh& mesh);

}  // namespace tissue
