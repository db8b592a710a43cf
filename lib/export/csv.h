#pragma once

#include "cases/load_path.h"
#include "export/files.h"
#include "springs/spring_sets.h"

namespace tissue {

/// Tables with one header line, separated by commas, units in the columns' names.
///   nodes.csv      node, position, mass, fixed             springs.csv  spring, its nodes, rest length, baselines
///   triangles.csv  node numbers                            sets.csv     set, contact, push, magnitude
///   stiffness.csv  spring, then one column a set [N/m]
Files csv_files(const TissueModel& model, const std::vector<NamedSet>& sets);

///   nodes.csv      node, position
///   records.csv    path, record, magnitude, energy, contact and support force, smallest J
///   fields.csv     path, record, node, displacement, force
Files csv_files(const Cases& cases, const std::vector<const LoadPath*>& paths);

}  // namespace tissue
