#pragma once

#include "springs/tissue_model.h"

namespace tissue {

/// Group /law of model.h5 (law_table, springs/tissue_table.h).
void write_law(Hdf5Writer& file, const LawModel& law);

/// mesh: of the same file, without fault. Throws FileError, "FILE: DATASET: WHY", for what is not a law of this mesh.
LawModel read_law(const Hdf5Reader& file, const SpringMesh& mesh);

}  // namespace tissue
