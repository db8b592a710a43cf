#pragma once

#include "cases/load_path.h"
#include "export/files.h"
#include "export/energy_model_tables.h"
#include "springs/spring_sets.h"

namespace tissue {

/// CSV tables of spring sets: one header line, commas, units in the column names.
///   nodes.csv      node, position, mass, fixed
///   triangles.csv  node numbers; in space tetrahedra.csv and facets.csv
///   springs.csv    spring, its nodes, rest length, stiffness of the baselines and of the one set
///   sets.csv       set, contact, direction of the tool displacement, magnitude
///   stiffness.csv  spring, then one column per set [N/m]
Files csv_files(const TissueModel& model, const std::vector<NamedSet>& sets);

/// CSV tables of an energy model. nodes.csv and triangles.csv (tetrahedra.csv, facets.csv) are as above.
///   springs.csv       as above, with the model's theta in place of the one set
///   spring_curve.csv  parameters of the springs' force curve, where it is not Hooke's
///   terms.csv         term, coefficient
///   contact.csv       log k of each contact row by its factors; in space also least and most of `curved`
///   presses.csv       case, contact, arc length or (in space) disc radius, tool displacement, force of the tool or the
///                     reason why there is no equilibrium
///   pressed.csv       case, node, displacement, force
///   branches.csv      of a model that relaxes: relaxation time, relative modulus of the contact
///   shares.csv        of a model that relaxes: relative moduli of each constant, springs first, one column per branch
/// The displacement is the lattice's own, which is in equilibrium with the forces. The surface beside a disc is drawn
/// differently (springs/skin.h).
///
/// In the plane:
///   areas.csv         area, cell or region, area a at rest, stiffness A
///   area_edges.csv    area, and the nodes from and to of each edge
///   surface.csv       node, arc length along the free surface, log of the contact stiffness ratio after adaptation
/// In space:
///   cells.csv              cell, its corners, where its volume is taken, volume at rest, A
///   embedding.csv          node, corners of its cube and their weights
///   supports.csv           fixed node, k
///   correction.csv         disc radius, facet, weights of its nodes, log of the contact stiffness ratio there
///   surface.csv            node, log of the contact stiffness ratio; of an adapted model only
///   contact_rows.csv       row, case, kind, stiffness, coefficients of the tool displacement
///   contact_pull.csv       row, node, coefficients of its displacement
///   contact_hardening.csv  case, hardening, saturation, coupling, in_compression
Files csv_files(const TissueModel& model, const std::vector<IndentationOfCase>& cases);

/// CSV tables of FE load paths.
///   nodes.csv      node, position
///   records.csv    path, record, magnitude, energy, contact and support force, smallest J; for pairs of discs the
///                  force of the second; of measured cases only magnitude and contact force
///   fields.csv     path, record, node, displacement, force
Files csv_files(const Cases& cases, const std::vector<const LoadPath*>& paths);

}  // namespace tissue
