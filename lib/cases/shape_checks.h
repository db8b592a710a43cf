#pragma once

#include <optional>
#include <vector>

#include "cases/sweep.h"
#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// Whether a shape's file is in the unit that the study says, before anything divides it into springs. mesh: the shape's mesh, its
/// surface, or its curves alone; points that no element has do not count.
/// Throws StudyError: more than 1,000 springs or finite elements along it, or more than 100,000 in all; less than two springs along it; so far
/// from the origin that coordinates lose digits (a thousand times its length).
void refuse_wrong_unit(const Study& study, const MshFile& mesh);
/// Of a block: its sides against the tool.
void refuse_wrong_unit(const Study& study);

/// What to tell of a shape whose contour is much finer than lattice.size_m, so that springs are; empty: nothing.
std::string finer_than_asked(const Study& study, const Shape& shape);

/// What would fail after hours of finite elements, asked for before them.
/// Throws StudyError with the key: a patch wider than half a side.
void refuse_tool(const Study& study, const SpringMesh& mesh);

/// Throws StudyError where pushes go through the tissue, deeper than the tissue is thick there: one that must not be lost (listed, in the
/// plane), or more than a tenth of all. FE may lose the others, as at the tip of a shape.
void refuse_push_through(const Study& study, const SpringMesh& mesh, const std::vector<PlannedPath>& paths);

/// Throws StudyError where the study's own disc or a drawn contact's is smaller or larger than those of all training contacts, and where a term is of the discs' size and all are of one.
void refuse_unknown_discs(const Study& study, const std::vector<PlannedPath>& paths);

}  // namespace tissue
