#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "haptic/lattice_rows.h"
#include "springs/spring_law.h"

namespace tissue {

/// The spring mesh of Sec. 4 in the layout of the tick. Constants only: nothing here changes while a session runs. In
/// space (D = 3) only springs that turn are supported (SpringLaw::plays_in_space).
///
/// Springs are stored in slots. Springs that join row i to row i + offset (LatticeRows), with one offset, form a band:
/// a contiguous run of slots, one per row. The force of a band is a few sums over contiguous arrays instead of a loop
/// over node pairs. Slots of a band without a spring have theta = 0. A lattice in the plane has four bands; an embedded
/// lattice has thirteen, and some more for each layer. Springs with rare offsets, in meshes that are no lattice, are
/// loose: they are stored as node pairs.
///
/// The nodes of a solid in an embedded lattice have no mass and move with the lattice (mesh/embedding.h).
class RealtimeMesh {
   public:
    struct Band {
        int first_row, offset, first_slot, count;  ///< slot first_slot + k joins rows r = first_row + k and r + offset
        /// all springs have one axis; all have one rest span, as in a lattice
        bool parallel, alike;
        /// unit axis, span X_j - X_i [m] and length [m] of the first spring
        double axis[3], span[3], length;
    };

    /// node_mass_kg (N): all positive, except for an embedded solid's own nodes, which have 0. law: a name of
    /// spring_laws().
    /// Throws MismatchError where sizes do not fit, for a spring without length, in space for springs that do not turn,
    /// and as LatticeRows does.
    RealtimeMesh(const SpringMesh& mesh, const std::string& law, const Eigen::VectorXd& node_mass_kg);
    /// With springs that turn and have this curve: those of an energy model.
    RealtimeMesh(const SpringMesh& mesh, const SpringCurve& curve, const Eigen::VectorXd& node_mass_kg);

    int node_count() const { return static_cast<int>(rest_.rows()); }
    int slot_count() const { return static_cast<int>(axis_.rows()); }
    int spring_count() const { return static_cast<int>(slot_of_spring_.size()); }
    const SpringLaw& law() const { return *law_; }
    const NodeColumns& rest() const { return rest_; }                    ///< [m] (N x D)
    const Eigen::VectorXd& mass() const { return mass_; }                ///< [kg] (N)
    /// [1/kg] (N); 0 of fixed nodes and of an embedded solid's own
    const Eigen::VectorXd& inverse_mass() const { return inverse_mass_; }
    const Embedding& embedding() const { return embedding_; }            ///< of a solid in a lattice; else empty
    const LatticeRows& rows() const { return rows_; }
    bool fixed(int node) const { return inverse_mass_[node] == 0; }
    int dimension() const { return static_cast<int>(rest_.cols()); }
    /// in the plane: boundary nodes, counter-clockwise (M)
    const std::vector<int>& outline() const { return outline_; }
    /// of the boundary, as SpringMesh has them (B x D)
    const Cells& facets() const { return facets_; }
    /// Position at rest of a point of the boundary [m] (D).
    Point rest_place(int facet, const Eigen::Vector3d& weight) const noexcept;
    const std::vector<Band>& bands() const { return bands_; }
    const std::vector<int>& slot_of_spring() const { return slot_of_spring_; }
    Eigen::Vector2i nodes_of_slot(int slot) const { return {first_[slot], second_[slot]}; }

    /// theta [N/m] by spring (S), reordered by slot (P). Throws MismatchError for another number of springs.
    Eigen::VectorXd to_slots(const Eigen::Ref<const Eigen::VectorXd>& theta) const;

    /// f = K(theta) u, (10): the external nodal forces [N] that hold u [m], at fixed nodes too. u, f by row, theta by
    /// slot. Allocates nothing; the cost is proportional to the number of springs.
    /// memory: Maxwell branches of springs that turn and relax, by slot, in the measure sqrt(2 energy), which is a
    /// Hookean spring's elongation; it advances by one step. Null where springs do not relax.
    void force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f, BranchMemory* memory = nullptr) const noexcept;

    /// Energy of the springs [J], u by node. Allocates nothing.
    double potential_energy(const Eigen::VectorXd& theta, const NodeColumns& u) const noexcept;

    /// In the plane: the block k = d f_i / d u_i of one slot per unit theta; the block of i, j is -k. u by node.
    /// convex: keep k positive semi-definite where a compressed spring that turns would buckle.
    Eigen::Matrix2d unit_stiffness(int slot, const NodeColumns& u, bool convex) const noexcept;

    /// K(theta) at rest [N/m] (N*D x N*D), degrees of freedom D * node + axis. theta by slot.
    SparseMatrix stiffness_at_rest(const Eigen::VectorXd& theta) const;

   private:
    RealtimeMesh(const SpringMesh& mesh, std::unique_ptr<SpringLaw> law, const Eigen::VectorXd& node_mass_kg);
    void bands_force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept;
    void loose_force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept;
    SpringRun run_at(int slot, const Eigen::VectorXd& theta) const noexcept;

    std::shared_ptr<const SpringLaw> law_;
    Embedding embedding_;
    LatticeRows rows_;
    NodeColumns rest_;
    Eigen::VectorXd mass_, inverse_mass_;
    std::vector<int> outline_;
    Cells facets_;
    std::vector<Band> bands_;
    int loose_slot_ = 0;                ///< slots from here on are loose springs
    std::vector<int> slot_of_spring_;   ///< (S)
    std::vector<int> first_, second_;   ///< nodes of each slot (P); equal where the slot has no spring
    std::vector<int> loose_first_, loose_second_;  ///< rows of the ends of loose springs
    NodeColumns axis_;                  ///< rest direction of each slot, a unit vector (P x D)
    NodeColumns rest_span_;             ///< X_j - X_i of each slot [m] (P x D)
    Eigen::VectorXd rest_length_;       ///< [m] (P)
};

}  // namespace tissue
