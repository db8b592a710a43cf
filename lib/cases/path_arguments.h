#pragma once

#include <string>

#include "cases/history_plan.h"
#include "cases/sweep.h"
#include "study/study.h"

namespace tissue {

/// Command-line arguments with which fem/*.edp and scripts/solve_path solve a load path. Numbers are written so that
/// they read back to the same bits.

constexpr const char* solid_geo = "fem/block3.geo";  ///< geometry from which scripts/solve_path makes each path's mesh
constexpr const char* history_role = "history";      ///< role of a path that is solved along a displacement history

/// A path in the plane: arguments of fem/solve_path.edp without the mesh.
std::string path_arguments(const Study& s, const PlannedPath& path);

/// A path of a solid block: arguments of scripts/solve_path, which passes them to gmsh and to fem/solve_solid.edp.
std::string solid_arguments(const Study& s, const PlannedPath& path);

/// A path of a solid shape: arguments of scripts/solve_path. springs: file of the mesh whose nodes are recorded.
std::string solid_shape_arguments(const Study& s, const PlannedPath& path, const std::string& springs);

/// Further arguments of a history, appended to those of its path. file: its displacement history as trajectory_text()
/// writes it. relaxes: whether the tissue relaxes in this solve.
std::string history_arguments(const Study& s, const PlannedHistory& history, const std::string& file, bool relaxes);

}  // namespace tissue
