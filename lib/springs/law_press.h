#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "springs/equilibrium.h"
#include "springs/press.h"
#include "springs/tissue_model.h"

namespace tissue {

/// A tool's place on the surface [m], and its push [m] (D).
struct ToolPush {
    Point contact_m, push_m;
};

/// Rest under several tools.
struct ToolsEquilibrium {
    NodeField displacement;                       ///< u [m] (N x D)
    std::vector<Eigen::VectorXd> contact_force;   ///< of each tool on the tissue [N] (D)
    EquilibriumStatus status;                     ///< as of Equilibrium

    explicit operator bool() const { return status == EquilibriumStatus::balanced; }
};

/// A model's law, pressed anywhere on its surface: each press from rest, so that the answer depends on nothing before it.
/// Serves many threads, each with a solver of its own, whose pattern is kept while contacts have the same nodes.
class LawPress {
   public:
    LawPress(const SpringMesh& mesh, LawModel law);

    /// The model must have a law.
    explicit LawPress(const TissueModel& model) : LawPress(model.mesh, *model.energy_law) {}

    /// The contact at a place of the surface [m] (D), or that nearest to it, held at a push, everything else at rest: force of
    /// the tool and displacement.
    /// `not_converged` where load steps lost the rest, `unstable` where it is no minimum, `inside_out` where it is none
    /// of a tissue, in the plane `contact_fixed` on the fixed edge, in space `no_contact` where the lattice has no tissue near the place. Throws MismatchError where law
    /// and mesh do not belong together.
    Equilibrium at(const Point& contact_m, const Point& push_m) const;

    /// The same with several tools of that disc at once, pushed in proportion. Throws OverlappingToolsError where the middles of two discs are nearer than two radii, at
    /// rest or at their pushes; MismatchError for several tools in the plane, whose law says no width of a tool.
    ToolsEquilibrium at(const std::vector<ToolPush>& tools) const;

    /// The same law under a disc of another radius [m] (springs/law_at_radius.h); 0: this one. Lives as long as this.
    const LawPress& of(double radius_m) const;

    /// What is seen of such an answer's displacement: at a disc the skin (springs/skin.h), everywhere else the nodes' own.
    NodeField seen(const Point& contact_m, const Point& push_m, NodeField displacement_m) const;

   private:
    void refuse_overlap(const std::vector<ToolPush>& tools) const;
    std::unique_ptr<PressSolver> take() const;  ///< an idle solver, or a new one

    LawModel law_;
    TissueEnergy energy_;
    SpringMesh mesh_;
    std::unique_ptr<ContactKernel> kernel_;
    mutable std::mutex guard_;
    mutable std::map<double, std::unique_ptr<LawPress>> others_;  ///< by radius
    mutable std::vector<std::unique_ptr<PressSolver>> idle_;
};

}  // namespace tissue
