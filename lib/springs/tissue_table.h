#pragma once

#include "io/dataset_table.h"

namespace tissue {

/// Description and constraints of each dataset of TissueModel in model.h5; writer, reader and tests use it. read_model
/// also requires a valid mesh (mesh/mesh_fault.h), contacts on its surface and a known spring law.
const DatasetTable& tissue_table(bool solid = false);

/// Datasets of a model with spring sets, and of one with an energy model.
const DatasetTable& sets_table();
const DatasetTable& energy_model_table(bool solid = false);

}  // namespace tissue
