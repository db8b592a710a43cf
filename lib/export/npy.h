#pragma once

#include "export/files.h"
#include "export/energy_model_tables.h"
#include "export/solid_model_tables.h"
#include "io/hdf5_store.h"

namespace tissue {

/// Every dataset of a file of this project in NumPy's format (.npy 1.0), under its HDF5 name: /mesh/nodes becomes
/// mesh/nodes.npy. Numbers are <f8, integers <i4, texts <U; C order.
Files npy_files(const Hdf5Reader& in);

/// Tables of an energy model that are not datasets of its file, because they follow from the mesh:
///   law/area_edges     area, from, to (K x 3)
///   law/area_kind, area_rest [m^2]
///   law/surface_node, surface_arc [m]
///   law/spring_curve   (3), where the springs are not Hooke's
Files npy_files(const EnergyModelTables& tables);

/// The same in space; contact rows of all load cases, one after the other:
///   law/cells (C x 8), cell_at (C x 3), cell_rest [m^3], spring_curve (3)
///   law/contact_case, contact_kind, contact_k [N/m] (R), contact_push (R x 3)
///   law/contact_pull_row, contact_pull_node (Q), contact_pull (Q x 3)
///   law/contact_hardening (4 per case): hardening, saturation [1/J], coupling [N/m2], 1 in compression alone
Files npy_files(const SolidModelTables& tables, const ContactTable& contact);

}  // namespace tissue
