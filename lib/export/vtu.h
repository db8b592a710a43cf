#pragma once

#include <string>

#include "cases/load_path.h"
#include "export/files.h"
#include "export/law_tables.h"
#include "springs/spring_sets.h"

namespace tissue {

/// One load path for ParaView: `PATH.pvd`, a time step a record of which the time is the push [m], and a VTK unstructured grid
/// (XML, double precision) of each, `PATH/0000.vtu` and on. One file with several steps is read differently by every reader: VTK 9.1 mixes
/// its steps up. Points are where the tissue is then, in metres, in the plane z = 0; cells are the lattice's quads, in space its
/// hexahedra, or the nodes alone where they are no lattice.
///   points  rest_m, displacement_m, force_N (N x 3)    field  magnitude_m, energy_J, smallest_J (1)
/// No files of a path without records, which FE gave up at once.
Files path_vtu(const Cases& cases, const LoadPath& path);

/// One spring set as a VTK unstructured grid: the spring mesh with the set's contact pushed and everything else in
/// equilibrium; at rest for a set without a load case, or when there is no equilibrium, and then `reason` says why.
///   points  rest_m, displacement_m, force_N (N x 3), mass_kg, fixed    springs  stiffness_N_m, rest_length_m (S)
std::string set_vtu(const TissueModel& model, const NamedSet& set, std::string& reason);

/// The same of a law, pressed at a load case: at rest where it has no answer. Displacement is the lattice's own, without the skin at a disc (springs/skin.h). In space the lattice's hexahedra follow the
/// springs, with stiffness_Pa; an array is 0 at cells that it does not belong to.
std::string pressed_vtu(const TissueModel& model, const PressedCase& pressed);

}  // namespace tissue
