#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "springs/equilibrium.h"
#include "springs/equilibrium_solver.h"
#include "springs/tissue_model.h"

namespace tissue {

/// Contact of a tool on the surface and tool displacement, both [m] (D).
struct ToolPush {
    Point contact_m, push_m;
};

/// The same outcome in the words of a spring mesh, for reason_of().
EquilibriumStatus status_of(SolverStatus status);

/// Equilibrium under several tools.
struct ToolsEquilibrium {
    NodeField displacement;                       ///< u [m] (N x D)
    std::vector<Eigen::VectorXd> contact_force;   ///< force of each tool on the tissue [N] (D)
    EquilibriumStatus status;                     ///< as in Equilibrium

    explicit operator bool() const { return status == EquilibriumStatus::balanced; }
};

/// Indentation of an energy model at any place of its surface. Each solution starts from rest, so the result does not
/// depend on earlier ones. Many threads may use one object; each takes a solver of its own. A solver keeps its matrix
/// pattern while contacts have the same nodes. Constructors throw MismatchError for a mesh or a number of
/// constants that TissueEnergy or the contact kernel refuses.
class IndentationSolver {
   public:
    IndentationSolver(const SpringMesh& mesh, EnergyModel energy_model);

    /// `model` must have an energy model; this is not checked.
    explicit IndentationSolver(const TissueModel& model) : IndentationSolver(model.mesh, *model.energy_model) {}

    /// Equilibrium with a tool displacement push_m [m] (D) at the surface point nearest to contact_m [m] (D): force of
    /// the tool and displacement of the mesh.
    /// Status: `not_converged` where the load steps failed; `unstable` where the equilibrium is not a minimum;
    /// `inverted` where a cell is; in the plane `contact_fixed` on the fixed edge; in space `no_contact`
    /// where the lattice has no tissue nearby.
    Equilibrium at(const Point& contact_m, const Point& push_m) const;

    /// The same with several tools of that disc at once, whose displacements grow in proportion. Throws
    /// OverlappingToolsError where the centres of two discs are closer than two radii, at rest or displaced. Throws
    /// MismatchError for several tools in the plane, where a tool has no width.
    ToolsEquilibrium at(const std::vector<ToolPush>& tools) const;

    /// The same for a disc of another radius [m] (springs/energy_model_at_radius.h); 0: this object. The reference is valid as
    /// long as this object.
    const IndentationSolver& of(double radius_m) const;

    /// Displacement of such a result as it is displayed: the skin at a disc (springs/skin.h), elsewhere that of the
    /// nodes.
    NodeField displayed(const Point& contact_m, const Point& push_m, NodeField displacement_m) const;

   private:
    void refuse_overlap(const std::vector<ToolPush>& tools) const;
    std::unique_ptr<EquilibriumSolver> take() const;  ///< an idle solver, or a new one

    EnergyModel law_;
    TissueEnergy energy_;
    SpringMesh mesh_;
    std::unique_ptr<ContactKernel> kernel_;
    mutable std::mutex guard_;
    mutable std::map<double, std::unique_ptr<IndentationSolver>> others_;  ///< by radius [m]
    mutable std::vector<std::unique_ptr<EquilibriumSolver>> idle_;
};

}  // namespace tissue
