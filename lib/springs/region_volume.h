#pragma once

#include <array>
#include <vector>

#include "springs/element.h"

namespace tissue {

/// A region of tetrahedra that keeps its true volume together: A V (volume / V - 1)^2 / 2, as one cell does
/// (springs/cell_volumes.h). Its volume depends on its surface alone. One element; A is a modulus [Pa].
class RegionVolume final : public Elements {
   public:
    /// tetrahedra: of the mesh, of positive volume; region: which of them.
    RegionVolume(const SpringMesh& mesh, const Cells& tetrahedra, const std::vector<int>& region);

    std::string kind() const override { return "cell"; }
    double energy(int e, const NodeField& u) const override;
    void force(int e, const NodeField& u, ElementVector& out) const override;
    void tangent(int e, const NodeField& u, ElementMatrix& out) const override;

    double volume_m3() const { return volume_; }  ///< V
    /// Its closed surface, normals out, as columns of nodes().
    const std::vector<std::array<int, 3>>& facets() const { return facets_; }

   private:
    struct Surface {
        Cells nodes;
        std::vector<std::array<int, 3>> facets;
    };
    static Surface surface_of(const Cells& tetrahedra, const std::vector<int>& region);
    RegionVolume(const SpringMesh& mesh, Surface surface);

    double swelling(const NodeField& u) const;  ///< volume / V - 1
    NodeField places(const NodeField& u) const;  ///< of its nodes, from where the first of them is now
    void volume_gradient(const NodeField& u, ElementVector& out) const;

    std::vector<std::array<int, 3>> facets_;
    NodeField rest_;  ///< of its nodes, from the first of them [m]
    double volume_;
};

}  // namespace tissue
