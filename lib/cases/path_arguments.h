#pragma once

#include <string>

#include "cases/history_plan.h"
#include "cases/sweep.h"
#include "study/study.h"

namespace tissue {

/// The words with which a load path is solved, as fem/*.edp and scripts/solve_path take them. Numbers are written so that they read back to the same bits.

constexpr const char* solid_geo = "fem/block3.geo";  ///< of which scripts/solve_path makes a mesh a path
constexpr const char* history_role = "history";      ///< of a path that is solved along a course

/// For FreeFEM, fem/solve_path.edp.
std::string path_arguments(const Study& s, const PlannedPath& path);

/// For scripts/solve_path, which shares them between gmsh and fem/solve_solid.edp.
std::string solid_arguments(const Study& s, const PlannedPath& path);

/// For scripts/solve_path, of a solid shape. springs: the mesh whose nodes are asked for.
std::string solid_shape_arguments(const Study& s, const PlannedPath& path, const std::string& springs);

/// What a history needs beside the arguments of a path. file: of its course.
std::string history_arguments(const Study& s, const PlannedHistory& history, const std::string& file, bool relaxes);

}  // namespace tissue
