#pragma once

#include "io/dataset_table.h"

namespace tissue {

/// Rules of the datasets of cases.h5, which writer, reader and tests use. measured: the table of measured cases, which
/// have forces alone and no displacement of the tissue. read_cases also checks the mesh (mesh/mesh_fault.h).
const DatasetTable& cases_table(bool measured);

}  // namespace tissue
