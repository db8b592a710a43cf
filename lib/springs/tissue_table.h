#pragma once

#include "io/dataset_table.h"

namespace tissue {

/// What each dataset of TissueModel in model.h5 is and must be: writer, reader and tests walk it. Beside it, read_model
/// asks for a mesh without fault (mesh/mesh_fault.h), contacts on its outline and a law that is known.
const DatasetTable& tissue_table(bool solid = false);

/// Those that stand there when the stiffness is sets, and those when it is a law.
const DatasetTable& sets_table();
const DatasetTable& law_table(bool solid = false);

}  // namespace tissue
