#pragma once

#include "io/dataset_table.h"

namespace tissue {

/// What each dataset of cases.h5 is and must be: writer, reader and tests walk it. `measured`: where nobody knows what
/// happened inside the tissue. Beside it, read_cases asks for triangles without fault (mesh/mesh_fault.h).
const DatasetTable& cases_table(bool measured);

}  // namespace tissue
