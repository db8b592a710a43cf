#pragma once

#include <memory>

#include "haptic/dynamics.h"

namespace tissue {

/// Each in its own file; make_dynamics chooses.
std::unique_ptr<Dynamics> make_paper_dynamics(const RealtimeMesh& mesh, const DynamicsOptions& options);
std::unique_ptr<Dynamics> make_symplectic_dynamics(const RealtimeMesh& mesh, const DynamicsOptions& options);
std::unique_ptr<Dynamics> make_implicit_dynamics(const RealtimeMesh& mesh, const DynamicsOptions& options);

}  // namespace tissue
