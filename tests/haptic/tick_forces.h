#pragma once

#include <catch2/catch.hpp>

#include "../allocations.h"
#include "haptic/realtime_energy_model.h"
#include "springs/tissue_energy.h"

namespace tissue {

/// The mesh of the tick of an energy model.
inline RealtimeMesh springs_of(const TissueModel& model) { return {model.mesh, model.energy_model->curve, model.node_mass_kg}; }

/// Checks that at the displacement u [m] (N x D) the tick has the force and the energy of the trained energy model, to
/// these relative tolerances, and that its force allocates nothing.
inline void check_tick_forces(const TissueModel& model, const TissueEnergy& energy, const NodeField& u, double force_tolerance, double energy_tolerance) {
    const RealtimeMesh springs = springs_of(model);
    const RealtimeEnergyModel energy_model(model, springs);
    const NodeField expected = energy.force(model.energy_model->constants, u);
    const NodeColumns columns = u;
    NodeColumns f = NodeColumns::Ones(u.rows(), u.cols());
    RealtimeEnergyModel::Scratch scratch = energy_model.scratch();
    long allocations = 0;
    {
        const Allocations none;
        energy_model.force(columns, f, scratch);
        allocations = Allocations::count();
    }
    CHECK((f - NodeColumns(expected)).norm() <= force_tolerance * expected.norm());
    CHECK(energy_model.energy(u) == Approx(energy.energy(model.energy_model->constants, u)).epsilon(energy_tolerance));
    CHECK(allocations == 0);
}

}  // namespace tissue
