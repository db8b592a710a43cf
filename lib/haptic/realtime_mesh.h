#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "haptic/lattice_rows.h"
#include "springs/spring_law.h"

namespace tissue {

/// The spring mesh of Sec. 4 laid out for the tick: constants only, nothing here changes while it runs. In space, D = 3, only
/// springs that turn play (SpringLaw::plays_in_space).
///
/// Springs live in slots. Springs that join row i to row i + offset (LatticeRows), for one offset, form a band: one run of slots,
/// one a row, so that force is a few sums over contiguous arrays instead of a walk through pairs of nodes. Slots of a
/// band that hold no spring have theta = 0. A lattice has four bands in the plane; an embedded one thirteen, and some more for each layer.
/// Springs of rare offsets (meshes that are no lattice) are loose: pairs.
///
/// The nodes of a solid in an embedded lattice have no mass, and move with the lattice (mesh/embedding.h).
class RealtimeMesh {
   public:
    struct Band {
        int first_row, offset, first_slot, count;  ///< slot first_slot + k joins first_row + k and that + offset
        bool parallel, alike;                       ///< all its springs have one axis; and one length, as on a lattice
        double axis[3], span[3], length;            ///< these [m]
    };

    /// node_mass_kg (N), all positive but those of an embedded solid's own nodes, which are 0. law: a name of spring_laws().
    /// Throws MismatchError when sizes do not fit, in space for springs that do not turn, and as LatticeRows does.
    RealtimeMesh(const SpringMesh& mesh, const std::string& law, const Eigen::VectorXd& node_mass_kg);
    /// Of springs that turn, with a curve of their own: an energy model's.
    RealtimeMesh(const SpringMesh& mesh, const SpringCurve& curve, const Eigen::VectorXd& node_mass_kg);

    int node_count() const { return static_cast<int>(rest_.rows()); }
    int slot_count() const { return static_cast<int>(axis_.rows()); }
    int spring_count() const { return static_cast<int>(slot_of_spring_.size()); }
    const SpringLaw& law() const { return *law_; }
    const NodeColumns& rest() const { return rest_; }                    ///< [m] (N x D)
    const Eigen::VectorXd& mass() const { return mass_; }                ///< [kg] (N)
    const Eigen::VectorXd& inverse_mass() const { return inverse_mass_; }  ///< [1/kg] (N), 0 where a node is fixed, or an embedded solid's
    const Embedding& embedding() const { return embedding_; }            ///< of a solid in a lattice, else empty
    const LatticeRows& rows() const { return rows_; }
    bool fixed(int node) const { return inverse_mass_[node] == 0; }
    int dimension() const { return static_cast<int>(rest_.cols()); }
    const std::vector<int>& outline() const { return outline_; }         ///< in the plane: boundary nodes, counter-clockwise (M)
    const Cells& facets() const { return facets_; }                      ///< of the boundary, as SpringMesh has them (B x D)
    Point rest_place(int facet, const Eigen::Vector3d& weight) const noexcept;  ///< on the boundary [m] (D)
    const std::vector<Band>& bands() const { return bands_; }
    const std::vector<int>& slot_of_spring() const { return slot_of_spring_; }
    Eigen::Vector2i nodes_of_slot(int slot) const { return {first_[slot], second_[slot]}; }

    /// theta (S) [N/m] by spring -> by slot (P).
    Eigen::VectorXd to_slots(const Eigen::Ref<const Eigen::VectorXd>& theta) const;

    /// f = K(theta) u, (10): the external nodal force [N] that holds u. u, f by row, theta by slot. Fixed nodes get theirs too.
    /// No allocation; cost in proportion to the springs.
    /// memory: of sqrt(2 energy), Hooke's elongation, of springs that turn and relax, by slot; null where they do not. It goes on by a step.
    void force(const Eigen::VectorXd& theta, const NodeColumns& u, NodeColumns& f, BranchMemory* memory = nullptr) const noexcept;

    /// Energy in the springs [J], u by node. No allocation.
    double potential_energy(const Eigen::VectorXd& theta, const NodeColumns& u) const noexcept;

    /// In the plane, the block k = d f_i / d u_i of one slot per unit theta at u, by node (the block of i, j is -k). `convex` keeps it
    /// positive semi-definite where a compressed spring that turns would buckle.
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
    std::vector<int> first_, second_;   ///< nodes of each slot (P); equal where there is no spring
    std::vector<int> loose_first_, loose_second_;  ///< rows of loose springs' ends
    NodeColumns axis_;                  ///< rest direction of each slot, a unit vector (P x D)
    NodeColumns rest_span_;             ///< X_j - X_i of each slot [m] (P x D)
    Eigen::VectorXd rest_length_;       ///< [m] (P)
};

}  // namespace tissue
