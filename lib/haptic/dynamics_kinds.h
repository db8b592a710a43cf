#pragma once

#include <memory>

#include "haptic/dynamics.h"
#include "registry.h"

namespace tissue {

/// A kind of step: its name, how stiff a mesh it bears, how it is made. Each in its own file.
struct DynamicsKind {
    const char* name;
    double stable_omega_dt;   ///< largest omega dt at which it may be chosen by itself; negative: never
    std::unique_ptr<Dynamics> (*make)(const RealtimeMesh& mesh, const DynamicsOptions& options);
};

/// (13)-(15) as printed, read with the acceleration at the positions of the step before: grows without bound at any
/// useful dt; kept to show that.
extern const DynamicsKind paper_dynamics;

/// Velocity from the force at the old positions, positions from the new velocity; stable while omega dt < 2, error
/// proportional to dt, energy stays within a band.
extern const DynamicsKind symplectic_dynamics;

/// Backward Euler, the coupling included: stable at any stiffness; error proportional to dt, energy only falls. One
/// banded Cholesky a step in which theta changed, in storage made before.
extern const DynamicsKind implicit_dynamics;

/// Every kind there is: a file of its own, and a line in dynamics.cpp.
const Registry<const DynamicsKind*>& dynamics_kinds();

}  // namespace tissue
