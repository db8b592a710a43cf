#pragma once

#include <optional>
#include <vector>

#include "cases/sweep.h"
#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// Checks the unit of length of a shape's file by its size, before it is divided into springs. mesh: the shape's mesh,
/// its surface, or its curves alone; points that belong to no element are ignored.
/// Throws StudyError for a shape
///   more than 1,000 springs or finite elements long, or of more than 100,000 in all
///   less than two springs long
///   that is a mesh in the plane, and more than 1,000 times as long as the tool's half width or depth
///   farther from the origin than a thousand times its length, where coordinates lose digits
void refuse_wrong_unit(const Study& study, const MshFile& mesh);
/// Throws StudyError for a block more than 1,000 times as long as the tool's half width or depth.
void refuse_wrong_unit(const Study& study);

/// A warning for a shape whose contour, and so its springs, are much finer than lattice.size_m; empty: none.
std::string finer_than_asked(const Study& study, const Shape& shape);

/// Checks the tool before FE solves that would fail hours later.
/// Throws StudyError with the key: a patch that is not narrower than the tissue's shortest side.
void refuse_tool(const Study& study, const SpringMesh& mesh);

/// Throws StudyError where indentations are deeper than the tissue is thick at their contact: one of the listed paths
/// of the plane, where a missing FE solution is an error, or more than a tenth of all paths. At fewer contacts, as at
/// the tip of a shape, FE may find no equilibrium.
void refuse_push_through(const Study& study, const SpringMesh& mesh, const std::vector<PlannedPath>& paths);

/// Throws StudyError where the radius of the study's own disc, or of a drawn contact's, is not between the smallest and
/// the largest of the training contacts; and where a term depends on the disc's radius but all training contacts have
/// the same.
void refuse_unknown_discs(const Study& study, const std::vector<PlannedPath>& paths);

}  // namespace tissue
