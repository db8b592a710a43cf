#pragma once

#include <string>

#include "cases/load_path.h"
#include "export/files.h"
#include "export/energy_model_tables.h"
#include "springs/spring_sets.h"

namespace tissue {

/// One load path for ParaView: `PATH.pvd`, whose time steps are the records and whose time is the tool displacement
/// [m], and a VTK unstructured grid (XML, double precision) per record, `PATH/0000.vtu` and on. Several steps in one
/// file are read differently by each reader; VTK 9.1 mixes them up. Points are displaced positions in metres, in the
/// plane at z = 0. Cells are the quads (in space hexahedra) of the lattice, the tetrahedra of a solid shape, or else
/// the nodes alone.
///   points  rest_m, displacement_m, force_N (N x 3)
///   field   magnitude_m, energy_J, smallest_J (1)
/// No files for a path without records, whose first FE step failed.
Files path_vtu(const Cases& cases, const LoadPath& path);

/// One spring set as a VTK unstructured grid: the spring mesh in equilibrium with the contact of the set's load case
/// displaced. At rest for a set without a load case or without an equilibrium; `reason` then says why.
///   points   rest_m, displacement_m, force_N (N x 3), mass_kg, fixed
///   springs  stiffness_N_m, rest_length_m (S)
std::string set_vtu(const TissueModel& model, const NamedSet& set, std::string& reason);

/// The same for an energy model at one of its load cases; at rest where there is no equilibrium. The displacement is
/// the lattice's own, without the skin at a disc (springs/skin.h). In space the hexahedra of the lattice follow the
/// springs, with stiffness_Pa. An array is 0 at cells to which it does not apply.
std::string pressed_vtu(const TissueModel& model, const IndentationOfCase& pressed);

}  // namespace tissue
