#pragma once

#include "export/files.h"
#include "export/law_tables.h"
#include "export/solid_law_tables.h"
#include "io/hdf5_store.h"

namespace tissue {

/// Every dataset of a file of this project as NumPy's own format (.npy 1.0), by its HDF5 name: /mesh/nodes becomes
/// mesh/nodes.npy. Numbers are <f8, integers <i4, texts <U; C order.
Files npy_files(const Hdf5Reader& in);

/// What of a law's energy is no dataset of its file, since it follows from the mesh, beside it:
///   law/area_edges  area, from, to (K x 3)    law/area_kind, area_rest [m^2]    law/surface_node, surface_arc [m]
Files npy_files(const LawTables& law);

/// The same in space:
///   law/cells (C x 8), cell_at (C x 3), cell_rest [m^3]    of the contacts of all load cases, one row after the other: law/contact_case, contact_kind,
///   contact_k [N/m], contact_push (R x 3), contact_pull_row, contact_pull_node, contact_pull (Q x 3); contact_hardening [1/J]
Files npy_files(const SolidLawTables& law, const ContactTable& contact);

}  // namespace tissue
