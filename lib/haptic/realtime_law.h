#pragma once

#include <array>
#include <memory>
#include <vector>

#include "haptic/realtime_mesh.h"
#include "springs/contact_patch.h"
#include "springs/tissue_energy.h"
#include "springs/tissue_model.h"

namespace tissue {

/// A model's law laid out for the tick: the forces of a TissueEnergy, of constants that never change, and its contacts.
/// Constants only. Springs are the bands of a RealtimeMesh. A lattice's squares lie in one run, one a node, as a band's
/// springs do: the area between a square's diagonals pulls at their ends. Every other region is a walk round its outline.
class RealtimeLaw {
   public:
    /// springs: of the model's mesh, with the law `geometric`, which is a law's own (springs/turning_springs.h); it must outlive this.
    /// Throws MismatchError for a model without a law, and for springs of another law.
    RealtimeLaw(const TissueModel& model, const RealtimeMesh& springs);

    /// dW/du: what holds u [N]. Fixed nodes get theirs too. No allocation; cost in proportion to springs and outlines.
    void force(const NodeColumns& u, NodeColumns& f) const noexcept;

    /// W without a contact's [J]. No allocation.
    double energy(const NodeColumns& u) const noexcept;

    /// The contact at a place of the mesh's boundary, as training and evaluation have it (ContactKernel::tool_at). No allocation.
    void contact(int facet, const Eigen::Vector3d& weight, ToolSpring& tool) const noexcept { kernel_->tool_at(facet, weight, patch_, tool); }

    double spacing_m() const { return kernel_->spacing_m(); }  ///< mean, of the free surface's nodes

   private:
    /// Squares whose corners are first + k, + b, + c, + d: one a node; where there is none, gain is 0.
    struct Squares {
        int first = 0, count = 0, b = 0, c = 0, d = 0;
        std::vector<double> px, py, qx, qy;  ///< rest diagonals, first to third and second to fourth corner [m]
        std::vector<double> gain;            ///< A / (4 a) [N/m3]: half of A (area - a) / a over area - a, and a cross product's half
    };
    /// A region: nodes of its outline in order, in walks that close. steps [begin, end) of walk_.
    struct Region {
        int begin, end;
        double gain;  ///< A / (4 a) [N/m3]
    };
    struct Step {
        int node, before, after;
        double x, y;  ///< after's rest place from before's [m]
    };
    bool add_squares(const Elements& cells, const Eigen::VectorXd& constants);
    void add_region(const std::vector<std::array<int, 2>>& edges, double constant);
    double twice_growth(const Region& region, const NodeColumns& u) const noexcept;
    void squares_force(const NodeColumns& u, NodeColumns& f) const noexcept;

    const RealtimeMesh& springs_;
    Eigen::VectorXd theta_;  ///< by slot (P)
    Squares squares_;
    std::vector<Region> regions_;
    std::vector<Step> walk_;
    std::unique_ptr<ContactKernel> kernel_;
    PatchLaw patch_;
};

}  // namespace tissue
