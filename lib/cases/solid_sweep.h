#pragma once

#include <optional>
#include <vector>

#include "cases/sweep.h"

namespace tissue {

/// Every FE solve of a solid: the study's own pushes, then those drawn on its top, then those of its map, then some of
/// `held_out` again on the finer mesh. A drawn place is uniform over the part of the top that is as far from the nearest wall as its role says,
/// its push uniform in solid angle between two tilts; it keeps 2 mm or 5 degrees from every training push.
/// On a shape drawn places are uniform by area over the part of the free surface that is so far from where it ends or turns,
/// and tilts are off its smooth normal.
/// Throws MismatchError when a draw finds no such push, StudyError as solid_training.
std::vector<PlannedPath> solid_paths(const Study& study, const std::optional<Shape>& shape = {});

}  // namespace tissue
