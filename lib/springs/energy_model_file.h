#pragma once

#include "springs/tissue_model.h"

namespace tissue {

/// Writes group /law of model.h5 (energy_model_table, springs/tissue_table.h).
void write_energy_model(Hdf5Writer& file, const EnergyModel& energy_model);

/// Reads group /law. mesh: the valid mesh of the same file. Throws FileError, "FILE: DATASET: WHY", for data that are
/// not an energy model of this mesh.
EnergyModel read_energy_model(const Hdf5Reader& file, const SpringMesh& mesh);

}  // namespace tissue
