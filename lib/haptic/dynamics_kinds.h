#pragma once

#include <memory>

#include "haptic/dynamics.h"
#include "registry.h"

namespace tissue {

/// A kind of time integration: its name, the stiffest mesh that it is chosen for, and the function that makes it. Each
/// kind has its own file.
struct DynamicsKind {
    const char* name;
    double stable_omega_dt;   ///< largest omega dt at which stable_dynamics() chooses it; negative: never
    std::unique_ptr<Dynamics> (*make)(const RealtimeMesh& mesh, const DynamicsOptions& options);
};

/// (13)-(15) as printed, with the acceleration at the positions of the step before. It diverges at any useful dt, and
/// is kept to show this.
extern const DynamicsKind paper_dynamics;

/// Symplectic Euler: velocity from the force at the old positions, positions from the new velocity. Stable while
/// omega dt < 2. The error is proportional to dt, and the energy stays within a band.
extern const DynamicsKind symplectic_dynamics;

/// Backward Euler, with the coupling included. Stable at any stiffness. The error is proportional to dt, and the energy
/// only falls. A step in which theta has changed factors a banded matrix (Cholesky), in storage allocated before.
extern const DynamicsKind implicit_dynamics;

/// All kinds. A new one needs a file of its own and a line in dynamics.cpp.
const Registry<const DynamicsKind*>& dynamics_kinds();

}  // namespace tissue
