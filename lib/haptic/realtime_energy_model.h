#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "haptic/realtime_mesh.h"
#include "haptic/state_bytes.h"
#include "haptic/tool_contact.h"
#include "springs/cell_volumes.h"
#include "springs/tissue_energy.h"
#include "springs/tissue_model.h"

namespace tissue {

/// The part of an energy model that may change during a session. Sizes stay as they are.
struct EnergyModelStiffness {
    Eigen::VectorXd constants;          ///< of a TissueEnergy [N/m] (E), all > 0
    ContactParameters patch;            ///< contact stiffnesses of the first tool
    Eigen::VectorXd contact_log_scale;  ///< log of a factor on the contact stiffness at each node (N)
};

/// Energy that the Maxwell branches of an energy model store, and energy that they have dissipated, without those of
/// its contact.
struct BranchEnergies {
    double stored_J = 0, dissipated_J = 0;
};

/// The energy model of a TissueModel in the layout of the tick: forces of a TissueEnergy and of its contacts. Holds
/// constants, no state.
///
/// Springs are in the bands of a RealtimeMesh. In the plane the squares of a lattice are in the order of their first
/// nodes; a node without a square has one of gain 0, so that the loop over them has no lookups. The area of a square
/// is half the cross product of its diagonals. Other cells, and regions, are closed walks along their outlines. In
/// space, cubes are in runs by the row of their first node (LatticeRows), with cubes of gain 0 in small gaps. The volume
/// ratio of a cube is that of the displacement gradient at the centroid of its tissue.
class RealtimeEnergyModel {
   public:
    /// springs: layout of the model's mesh, with the spring curve of its energy model; must outlive this object.
    /// ball_m: radius of the ball that is the first tool [m]; 0: the model's own disc or patch.
    /// Throws MismatchError for a model without an energy model, for springs of another kind or curve, for constants or
    /// relative moduli that do not fit the mesh, and for cubes that are not numbered as in a lattice.
    RealtimeEnergyModel(const TissueModel& model, const RealtimeMesh& springs, double ball_m = 0);
    /// A copy on the same springs whose stiffness changes independently (become()). Each session has its own.
    RealtimeEnergyModel(const RealtimeEnergyModel& other);
    RealtimeEnergyModel& operator=(const RealtimeEnergyModel&) = delete;

    /// Working memory of force(), one per caller. Rows of u without a node stay 0.
    struct Scratch {
        NodeColumns u, f;  ///< by row (LatticeRows); empty where row i is node i
    };
    Scratch scratch() const;

    /// f = dW/du [N] (N x D): the nodal forces that hold u [m] (N x D), at fixed nodes too. scratch: made by scratch().
    /// memory: of an energy model that relaxes, made by memory(); it advances by one step, to u. An empty memory gives
    /// the instantaneous model. Allocates nothing; the cost is proportional to the number of springs, outline edges and
    /// cells.
    void force(const NodeColumns& u, NodeColumns& f, Scratch& scratch, BranchMemory& memory) const noexcept;
    void force(const NodeColumns& u, NodeColumns& f, Scratch& scratch) const noexcept;  ///< of the instantaneous model

    /// State of the Maxwell branches for steps of dt_s, relaxed at rest; empty where the model does not relax.
    BranchMemory memory(double dt_s) const;
    /// The same of a contact.
    ToolMemory tool_memory(double dt_s) const;
    /// Largest relaxation time; 0 where the model does not relax.
    double slowest_s() const { return relaxation_.empty() ? 0 : relaxation_.tau_s.maxCoeff(); }

    /// W of the instantaneous model [J], without a contact's energy.
    double energy(const NodeColumns& u) const;
    /// Energy [J] that springs, cells, supports and Maxwell branches store at u, one step after the state in `memory`.
    double energy(const NodeColumns& u, BranchMemory memory) const;

    /// Energies of the branches, with the present constants. 0 for a memory without an energy log (BranchMemory::book).
    BranchEnergies branches(const BranchMemory& memory) const;

    /// Adds a tool with other contacts than the first: those of `energy_model`, whose springs, cells and supports are the model's
    /// own. The arguments are as for ToolContact.
    void add_tool(const SpringMesh& mesh, const EnergyModel& energy_model, double ball_m);
    /// Contacts of a tool of the session; those of the first tool where no other was added.
    const ToolContact& contacts(int tool = 0) const noexcept { return contacts_[std::min(static_cast<std::size_t>(tool), contacts_.size() - 1)]; }

    const EnergyModelStiffness& stiffness() const { return now_; }
    const Relaxation& relaxation() const { return relaxation_; }
    /// Replaces the stiffness by another of the same sizes, between ticks. States of Maxwell branches stay as they are.
    /// Allocates nothing.
    void become(const EnergyModelStiffness& stiffness) noexcept;

    /// Saves or restores what become() changes.
    void fields(StateBytes& state) noexcept;

   private:
    /// Squares with corners at nodes n, n + b, n + c and n + d, n = first + k of slot k. Slots without a square have
    /// gain 0.
    /// With T twice the change of area, a square stores gain T^2 / 2 = A (area - a)^2 / (2 a), a: the area at rest.
    struct Squares {
        int first = 0, count = 0, b = 0, c = 0, d = 0;
        std::vector<double> px, py, qx, qy;  ///< rest diagonals, first to third and second to fourth corner [m]
        std::vector<double> gain;            ///< A / (4 a) [N/m3]
        std::vector<Eigen::Index> constant;  ///< index of the square's constant; -1 where the slot has no square
    };
    /// A region: steps [begin, end) of walk_, which follow its outline in closed walks. Its energy is as a square's.
    struct Region {
        int begin, end;
        double gain;  ///< A / (4 a) [N/m3]
        Eigen::Index constant;
    };
    struct Step {
        int node, before, after;
        double x, y;  ///< rest position of `after` minus that of `before` [m]
    };
    /// Cubes of an embedded lattice, in slots. The corners of slot first_slot + k of a run are rows first_row + k +
    /// corner[c]. Slots without a cube have gain 0. A slot's growth is J - 1 at the centroid of its tissue, J: the
    /// ratio of volumes.
    struct Cubes {
        struct Run {
            int first_row, first_slot, count;
            int corner[8];               ///< corner[1] is 1; each odd entry is the even one before it plus 1
        };
        std::vector<Run> runs;
        double per_m = 0;                ///< 1 / edge
        std::vector<double> centroid[3]; ///< of their tissue, from corner 0, in edges
        std::vector<double> gain;        ///< A V [Nm] of A V (J - 1)^2 / 2
        std::vector<Eigen::Index> constant;

        int count() const { return static_cast<int>(gain.size()); }
    };
    /// Fixed points of an embedded solid, each held by a spring to its place at rest.
    struct Supports {
        /// first entry of each support in the next two arrays, and their length (M + 1)
        std::vector<int> begin;
        /// lattice nodes with a weight that is not 0; four for a support in a lattice plane
        std::vector<int> corner;
        std::vector<double> weight;      ///< of these nodes, in the interpolation of the point's displacement
        std::vector<double> gain;        ///< [N/m] (M)
        Eigen::Index first_constant = 0;

        Eigen::Vector3d moved(std::size_t m, const NodeColumns& u) const noexcept;  ///< displacement of support m [m]
    };
    // first, first_constant: index of the kind's first constant among those of the energy model
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

    void contacts_become() noexcept;

    const RealtimeMesh& springs_;
    EnergyModelStiffness now_;
    Eigen::VectorXd theta_;  ///< of springs, by slot [N/m] (P)
    Relaxation relaxation_;
    int first_square_ = 0, first_region_ = 0, first_cube_ = 0;  ///< first elements in a BranchMemory, after the springs
    std::vector<Eigen::Index> spring_of_slot_;                  ///< -1 where the slot has no spring (P)
    Squares squares_;
    std::vector<Region> regions_;
    std::vector<Step> walk_;
    Cubes cubes_;
    Supports supports_;
    std::vector<ToolContact> contacts_;  ///< of each tool; one for all where they are alike
};

}  // namespace tissue
