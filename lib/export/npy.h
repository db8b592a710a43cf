#pragma once

#include "export/files.h"
#include "export/law_tables.h"
#include "io/hdf5_store.h"

namespace tissue {

/// Every dataset of a file of this project as NumPy's own format (.npy 1.0), by its HDF5 name: /mesh/nodes becomes
/// mesh/nodes.npy. Numbers are <f8, integers <i4, texts <U; C order.
Files npy_files(const Hdf5Reader& in);

/// What of a law's energy is no dataset of its file, since it follows from the mesh, beside it:
///   law/area_edges  area, from, to (K x 3)    law/area_kind, area_rest [m^2]    law/surface_node, surface_arc [m]
Files npy_files(const LawTables& law);

}  // namespace tissue
