#pragma once

#include "cases/load_path.h"
#include "export/files.h"
#include "export/law_tables.h"
#include "springs/spring_sets.h"

namespace tissue {

/// Tables with one header line, separated by commas, units in the columns' names.
///   nodes.csv      node, position, mass, fixed             springs.csv  spring, its nodes, rest length, baselines
///   triangles.csv  node numbers                            sets.csv     set, contact, push, magnitude
///   stiffness.csv  spring, then one column a set [N/m]
Files csv_files(const TissueModel& model, const std::vector<NamedSet>& sets);

/// Of a law:
///   nodes.csv, triangles.csv  as above                     springs.csv     theta of the law in place of the one set
///   areas.csv      area, cell or region, a at rest, A      area_edges.csv  area, its nodes from and to
///   terms.csv      term, coefficient                       contact.csv     log k of each row by its factors; in
///                                                          space least and most of curved
///   surface.csv    node, where along the free surface, log of how much stiffer contacts are there
///   presses.csv     case, contact, in space the disc's radius, push, force of the hand, or
///   pressed.csv    case, node, displacement, force                         the reason why it has none
/// Displacement is the lattice's own, with which forces balance: beside a disc the surface is seen elsewhere (springs/skin.h).
/// Where it relaxes branches.csv (time, the contact's share) and shares.csv (of each constant, springs first, a column a branch).
/// In space tetrahedra.csv and facets.csv stand in place of triangles.csv, and of areas and surface
///   cells.csv      cell, its corners, where its volume is taken, volume at rest, A; embedding.csv (node, its cube's corners and their
///                  weights) and supports.csv (held node, k)
///   correction.csv   disc's radius, facet, weights of its nodes, log of how much stiffer contacts are there
///   surface.csv      node, the same of a law that has learned from pokes
///   contact_rows.csv  row, case, kind, stiffness, what it takes of the push
///   contact_pull.csv  row, node, what it takes of its displacement           contact_hardening.csv  case, hardening
Files csv_files(const TissueModel& model, const std::vector<PressedCase>& cases);

///   nodes.csv      node, position
///   records.csv    path, record, magnitude, energy, contact and support force, smallest J; of measured cases magnitude and contact force alone
///   fields.csv     path, record, node, displacement, force
Files csv_files(const Cases& cases, const std::vector<const LoadPath*>& paths);

}  // namespace tissue
