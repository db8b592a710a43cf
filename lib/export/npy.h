#pragma once

#include "export/files.h"
#include "io/hdf5_store.h"

namespace tissue {

/// Every dataset of a file of this project as NumPy's own format (.npy 1.0), by its HDF5 name: /mesh/nodes becomes
/// mesh/nodes.npy. Numbers are <f8, integers <i4, texts <U; C order.
Files npy_files(const Hdf5Reader& in);

}  // namespace tissue
