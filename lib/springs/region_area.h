#pragma once

#include <array>
#include <vector>

#include "springs/element.h"

namespace tissue {

/// A region of many cells that keeps its true area together: A a (area / a - 1)^2 / 2, as one cell does. Its area depends
/// on its outline alone, so it pulls softly at many nodes and costs the time step little. Two dimensions; one element.
class RegionArea final : public Elements {
   public:
    /// cells: of the mesh, plane and counter-clockwise; region: which of them.
    RegionArea(const SpringMesh& mesh, const Cells& cells, const std::vector<int>& region);

    std::string kind() const override { return "region"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

    /// Edges that one cell of the region has and no other: from node to node, as columns of nodes(). Any number of loops.
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
    NodeField rest_;      ///< of its nodes, from the first of them [m]
    double area_;         ///< a [m^2]
};

}  // namespace tissue
