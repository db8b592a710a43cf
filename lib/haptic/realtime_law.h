#pragma once

#include <array>
#include <memory>
#include <vector>

#include "haptic/realtime_mesh.h"
#include "haptic/state_bytes.h"
#include "springs/cell_volumes.h"
#include "springs/ball_contact.h"
#include "springs/contact_patch.h"
#include "springs/patch_sizes.h"
#include "springs/tissue_energy.h"
#include "springs/tissue_model.h"

namespace tissue {

/// What of a law may become another while it plays.
struct LawStiffness {
    Eigen::VectorXd constants;          ///< of a TissueEnergy [N/m] (E), all > 0
    PatchLaw patch;                     ///< of as many rows and columns
    Eigen::VectorXd contact_log_scale;  ///< (N)
};

/// What the branches of a law that relaxes hold and have turned into heat, its contact's left out.
struct BranchBook {
    double stored_J = 0, dissipated_J = 0;
};

/// A model's law laid out for the tick: the forces of a TissueEnergy and its contacts. Constants only. Springs are the bands of a RealtimeMesh. A lattice's squares lie in one run, one a node, as a band's
/// springs do: the area between a square's diagonals pulls at their ends. Every other region is a walk round its outline.
/// In space cubes lie in runs of consecutive first nodes, and pull at all eight corners, by the gradient at their tissue's centroid.
class RealtimeLaw {
   public:
    /// springs: of the model's mesh and its law's curve; it must outlive this. ball_m: radius of the ball that presses; 0: the law's disc.
    /// Throws MismatchError for a model without a law, and for springs of another law or curve.
    RealtimeLaw(const TissueModel& model, const RealtimeMesh& springs, double ball_m = 0);
    /// The same law on the same springs, which becomes another by itself: each session has its own.
    RealtimeLaw(const RealtimeLaw& other);
    RealtimeLaw& operator=(const RealtimeLaw&) = delete;

    /// Working memory of force(): each caller has its own. Rows of u without a node stay 0.
    struct Scratch {
        NodeColumns u, f;  ///< by row, where that is not by node
    };
    Scratch scratch() const;

    /// dW/du: what holds u [N]. Fixed nodes get theirs too. scratch: made by scratch().
    /// memory: of a law that relaxes, made by memory(); empty, it is the instantaneous one. It goes on by a step, to u.
    /// No allocation; cost in proportion to springs, outlines and cells.
    void force(const NodeColumns& u, NodeColumns& f, Scratch& scratch, BranchMemory& memory) const noexcept;
    void force(const NodeColumns& u, NodeColumns& f, Scratch& scratch) const noexcept;  ///< of the instantaneous law

    /// At rest from all time, for steps of this length; empty where the law does not relax.
    BranchMemory memory(double dt_s) const;
    ToolMemory tool_memory(double dt_s) const;
    double slowest_s() const { return relaxation_.empty() ? 0 : relaxation_.tau_s.maxCoeff(); }  ///< 0 where it does not relax

    /// W without a contact's [J], of the instantaneous law.
    double energy(const NodeColumns& u) const;
    /// What springs, cells and their branches store [J] at u, a step after what memory has seen.
    double energy(const NodeColumns& u, BranchMemory memory) const;

    /// Of a memory that is booked (BranchMemory::book); constants as they are now.
    BranchBook branches(const BranchMemory& memory) const;

    /// The contact at a place of the mesh's boundary, as training and evaluation have it (ContactKernel::tool_at); of a ball the one at that push d and those displacements
    /// (springs/ball_press.h). tool: the same contact a tick ago; for a new contact, a tool without growth. No allocation.
    void contact(int facet, const Eigen::Vector3d& weight, const Point& push_m, const NodeColumns& u, ToolSpring& tool) const noexcept;
    bool contact_grows() const { return ball_.radius_m > 0; }  ///< with the push
    /// The contact there of a growth that is known, a ball's; of none the law's own disc.
    void contact(int facet, const Eigen::Vector3d& weight, const ToolSpring::Growth& growth, ToolSpring& tool) const noexcept;

    /// What is seen of displacements u while the tool pushes there (ContactKernel::show_skin). No allocation.
    void show_skin(int facet, const Eigen::Vector3d& weight, const Point& push_m, NodeColumns& u) const noexcept;

    double spacing_m() const { return kernel_->spacing_m(); }  ///< mean, of the free surface's nodes

    const LawStiffness& stiffness() const { return now_; }
    const Relaxation& relaxation() const { return relaxation_; }
    /// Another one of the same sizes from now on, between ticks; memory stays what it is. No allocation.
    void become(const LawStiffness& stiffness) noexcept;

    /// What become() changes.
    void fields(StateBytes& state) noexcept;

   private:
    /// Squares whose corners are first + k, + b, + c, + d: one a node; where there is none, gain is 0.
    struct Squares {
        int first = 0, count = 0, b = 0, c = 0, d = 0;
        std::vector<double> px, py, qx, qy;  ///< rest diagonals, first to third and second to fourth corner [m]
        std::vector<double> gain;            ///< A / (4 a) [N/m3]: half of A (area - a) / a over area - a, and a cross product's half
        std::vector<Eigen::Index> constant;  ///< which of the law's it has, -1 where there is no square
    };
    /// A region: nodes of its outline in order, in walks that close. steps [begin, end) of walk_.
    struct Region {
        int begin, end;
        double gain;  ///< A / (4 a) [N/m3]
        Eigen::Index constant;
    };
    struct Step {
        int node, before, after;
        double x, y;  ///< after's rest place from before's [m]
    };
    /// Cubes of an embedded lattice, in slots. In a run the corners of slot first_slot + k are rows first_row + k + corner[c]; where there is none, gain is 0. A slot's growth
    /// is J - 1 at the centroid of the tissue in it.
    struct Cubes {
        struct Run {
            int first_row, first_slot, count;
            int corner[8];               ///< corner[1] is 1, and every odd one follows the even one before
        };
        std::vector<Run> runs;
        double per_m = 0;                ///< 1 / edge
        std::vector<double> centroid[3]; ///< of their tissue, from corner 0 in edges
        std::vector<double> gain;        ///< A V [Nm] of A V (J - 1)^2 / 2
        std::vector<Eigen::Index> constant;

        int count() const { return static_cast<int>(gain.size()); }
    };
    /// Points of an embedded solid that are held by springs.
    struct Supports {
        std::vector<int> begin;          ///< where each support's corners begin in the two arrays below, and where the last one's end (M + 1)
        std::vector<int> corner;         ///< lattice nodes that move it, but for those of weight 0: a bed on a plane of the lattice has four
        std::vector<double> weight;
        std::vector<double> gain;        ///< [N/m] (M)
        Eigen::Index first_constant = 0;

        Eigen::Vector3d moved(std::size_t m, const NodeColumns& u) const noexcept;  ///< how far its point has
    };
    // first: of the kind's constants among the law's
    void add_plane_cells(const Elements& cells, const Eigen::VectorXd& constants, Eigen::Index first);
    bool add_squares(const Elements& cells, const Eigen::VectorXd& constants, Eigen::Index first);
    void add_region(const std::vector<std::array<int, 2>>& edges, double constant, Eigen::Index index);
    void add_cubes(const TissueModel& model, const CellVolumes& cells, Eigen::Index first);
    void supports_force(const NodeColumns& u, NodeColumns& f) const noexcept;
    double supports_energy(const NodeColumns& u) const noexcept;
    template <class Of>
    double sum_of_elements(const Of& of_element) const;
    double twice_growth(const Region& region, const NodeColumns& u) const noexcept;
    void squares_force(const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept;
    void regions_force(const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept;
    void cubes_grown(const Cubes::Run& run, int done, int n, const NodeColumns& u, double* g, double* grown) const noexcept;
    void cubes_force(const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept;
    double cubes_energy(const NodeColumns& u) const noexcept;
    void elements_force(const NodeColumns& u, NodeColumns& f, BranchMemory* memory) const noexcept;
    void all_force(const NodeColumns& u, NodeColumns& f, Scratch& scratch, BranchMemory* memory) const noexcept;

    /// A ball at a place and a push.
    struct BallAt {
        Eigen::Vector3d push_m, inward;
        double effective_m, depth_m, radius_m, growth;  ///< of the contact: its radius, and da / dd; 0 of the smallest
    };
    BallAt ball_at(int facet, const Eigen::Vector3d& weight, const Point& push_m) const noexcept;

    const RealtimeMesh& springs_;
    SkinLaw skin_;
    LawStiffness now_;
    Eigen::VectorXd theta_;  ///< by slot (P)
    Relaxation relaxation_;
    int first_square_ = 0, first_region_ = 0, first_cube_ = 0;  ///< in a memory, after the springs' slots
    std::vector<Eigen::Index> spring_of_slot_;                                   ///< (P), -1 where there is none
    Squares squares_;
    std::vector<Region> regions_;
    std::vector<Step> walk_;
    Cubes cubes_;
    Supports supports_;
    std::unique_ptr<ContactKernel> kernel_;
    BallContact ball_;   ///< radius 0: a disc
    PatchSizes sizes_;   ///< of a ball
};

}  // namespace tissue
