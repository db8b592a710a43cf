#pragma once

#include "springs/equilibrium.h"
#include "springs/press.h"
#include "springs/tissue_model.h"

namespace tissue {

/// A model's law, pressed anywhere on its surface: each press from rest, so that the answer depends on nothing before it.
/// Serves many threads.
class LawPress {
   public:
    LawPress(const SpringMesh& mesh, LawModel law);

    /// The model must have a law.
    explicit LawPress(const TissueModel& model) : LawPress(model.mesh, *model.energy_law) {}

    /// The contact at an arc length [m] held at a push, everything else at rest: force of the tool and displacement.
    /// `not_converged` where load steps lost the rest, `unstable` where it is no minimum, `contact_fixed` on the fixed edge.
    Equilibrium at(double arc_m, const Eigen::Vector2d& push_m) const;

   private:
    LawModel law_;
    TissueEnergy energy_;
    ContactSurface surface_;
};

}  // namespace tissue
