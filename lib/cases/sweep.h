#pragma once

#include <array>
#include <string>
#include <vector>

#include "cases/load_path.h"
#include "mesh/shape.h"
#include "study/study.h"

namespace tissue {

/// One FE solve of a study: indentation, depth and role.
struct PlannedPath {
    StudyPath push;
    /// train; a role of the draws (validation, held_out, held_out_WORD); map; check (another path again, on the finer
    /// mesh).
    std::string role;
    double depth_m;
    int records;         ///< without the one at rest
    int refine;          ///< of the mesh it is solved on
    /// For a solid: size of that mesh's elements, near the contact and far from it.
    std::array<double, 2> sizes_m = {};
};

/// All FE solves of a study in a fixed order, drawn before any of them runs. Names are different.
/// In the plane only one of two training contacts of the block that mirror each other is solved, and mirrored() makes
/// the other. On a shape all contacts are solved, because it need not be symmetric. Drawn contacts are 2 mm or 5
/// degrees from every training contact. Solids: cases/solid_sweep.h.
/// Throws MismatchError when a draw finds no such contact, and when a listed path has the name of another path's check.
std::vector<PlannedPath> planned_paths(const Study& study, const std::optional<Shape>& shape = {});

/// The cases with only the training paths and magnitudes that a variant keeps, and with all drawn paths and histories.
Cases thinned(const Study& study, const Cases& cases, const Study::Variant& variant);

}  // namespace tissue
