#pragma once

#include <array>
#include <vector>

#include "springs/element.h"

namespace tissue {

/// Area term of a region of many cells: energy A a (area / a - 1)^2 / 2, as for one cell (springs/cell_areas.h). The
/// area depends on the region's outline only. The term therefore has small stiffnesses at many nodes and hardly reduces
/// the time step. Two dimensions; one element.
class RegionArea final : public Elements {
   public:
    /// cells: those of the mesh, plane and counter-clockwise. region: indices of its cells.
    RegionArea(const SpringMesh& mesh, const Cells& cells, const std::vector<int>& region);

    std::string kind() const override { return "region"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

    /// Edges that belong to exactly one cell of the region, from node to node, as columns of nodes(). There may be
    /// several loops.
    const std::vector<std::array<int, 2>>& edges() const { return edges_; }

   private:
    struct Outline {
        Cells nodes;
        std::vector<std::array<int, 2>> edges;
    };
    static Outline outline_of(const Cells& cells, const std::vector<int>& region);
    RegionArea(const SpringMesh& mesh, Outline outline);

    double swelling(const NodeField& u) const;  ///< area / a - 1
    void area_gradient(const NodeField& u, ElementVector& out) const;

    std::vector<std::array<int, 2>> edges_;
    NodeField rest_;      ///< positions of its nodes at rest, relative to the first [m]
    double area_;         ///< a [m^2]
};

}  // namespace tissue
