#pragma once

#include <vector>

#include "cases/sweep.h"

namespace tissue {

/// Every FE solve of a solid block: the study's own pushes, then those drawn on its top, then those of its map, then some of
/// `held_out` again on the finer mesh. A drawn place is uniform over the part of the top that is as far from the nearest wall as its role says,
/// its push uniform in solid angle between two tilts; it keeps 2 mm or 5 degrees from every training push.
/// Throws MismatchError when a draw finds no such push.
std::vector<PlannedPath> solid_paths(const Study& study);

}  // namespace tissue
